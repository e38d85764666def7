//! The diagnosis from beginning to end: split, noise, the evidence of sets of effects, one look at the test records.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::assumptions::Assumptions;
use super::candidates::{self, Candidate};
use super::diagnosis::{Diagnosis, Noise, Verdict};
use super::error::DiagnoseError;
use super::evaluate;
use super::evidence::{self, Measured, Posterior, Question, Weighed};
use super::measurements::noise::noise_of;
use super::measurements::split;
use super::measurements::weighted_dataset::WeightedDataset;
use super::measurements::{beginnings, cycles, inputs, magnitudes, thinned};
use super::solvable;
use super::stage::stage;
use super::verdict::{self, Context, Decision};
use crate::data::Dataset;
use crate::effects::{Effect, Location, Scales};
use crate::fit::checks::check;
use crate::fit::compare::{RefitError, Stage};
use crate::fit::{FitError, InterruptHook};
use crate::model::Model;

/// Effects that are added at most unless asked: more take several times as long, and stand for some of what none of them is.
const MOST: usize = 2;

/// What a diagnosis tries.
///
/// ```
/// use stickslip::diagnose::DiagnoseOptions;
/// // Two effects of the catalogue, and at most one of them added.
/// let effects = Some(vec!["backlash".into(), "wear".into()]);
/// let options = DiagnoseOptions { effects, max_effects: 1, ..DiagnoseOptions::default() };
/// assert!(DiagnoseOptions::default().effects.is_none() && options.max_effects == 1);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnoseOptions {
    /// Ids of the only effects to try; `None` for the whole catalogue.
    pub effects: Option<Vec<String>>,
    /// Effects that may be added at most.
    pub max_effects: usize,
    /// What is taken for granted.
    pub assumptions: Assumptions,
}

impl Default for DiagnoseOptions {
    fn default() -> Self {
        Self { effects: None, max_effects: MOST, assumptions: Assumptions::default() }
    }
}

/// Called with progress: what was done, how much is done, of how much.
pub type DiagnoseHook<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);

/// How a diagnosis is watched and stopped.
///
/// ```
/// use stickslip::diagnose::DiagnoseWatch;
/// let progress = |what: &str, done: usize, of: usize| println!("{what}: {done} of {of}");
/// let watch = DiagnoseWatch { progress: Some(&progress), interrupt: None };
/// watch.progress.unwrap()("backlash", 1, 20);
/// ```
#[derive(Clone, Copy, Default)]
pub struct DiagnoseWatch<'a> {
    /// Called when something has been tried, with what is done in words, and how much of how much.
    pub progress: Option<DiagnoseHook<'a>>,
    /// Asked repeatedly; `true` ends the diagnosis with the results so far.
    pub interrupt: Option<InterruptHook<'a>>,
}

/// A model with an effect added and refitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Added {
    /// The model.
    pub model: Model,
    /// Before, and after.
    pub stages: Vec<Stage>,
}

/// Finds which physical effect `model` lacks to predict `dataset`.
///
/// Sets of effects of the catalogue, and a discrepancy that stands for what the catalogue lacks, are fitted to the training
/// records by the full simulator, jointly with the whole model; the evidence of each, that of a likelihood with coloured
/// noise, gives its probability, and the probabilities give the verdict. The test records are read once, after the
/// decision: they may take a verdict back, and never choose one. Records that cannot be solved are left out, and named in
/// [`Diagnosis::skipped`].
///
/// # Errors
/// [`DiagnoseError`]: an unknown effect, a model without a free parameter, no record that can be predicted.
///
/// ```
/// use stickslip::prelude::*;
/// # let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
/// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.1\nnormal_load = 10.0";
/// let model = Model::parse(text)?;
/// let channel = |name: &str, unit, values: &[f64]| {
///     Channel { name: name.into(), unit, values: values.to_vec(), noise: None }
/// };
/// let channels = vec![
///     channel("time", "s", &[0.0, 1.0, 2.0]),
///     channel("displacement", "m", &[0.0, 0.5e-3, 1e-3]),
///     channel("force", "N", &[0.0, 0.8, 0.9]),
/// ];
/// let record = Record { name: "pull".into(), regime: Regime::FromRest, use_for: None, channels };
/// let dataset = Dataset { title: None, records: vec![record] };
/// let found = diagnose(&model, &dataset, &DiagnoseOptions::default(), DiagnoseWatch::default())?;
/// // One record cannot be split into training and test records.
/// assert_eq!(found.verdict, Verdict::InsufficientData);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn diagnose(
    model: &Model,
    dataset: &Dataset,
    options: &DiagnoseOptions,
    watch: DiagnoseWatch,
) -> Result<Diagnosis, DiagnoseError> {
    for id in options.effects.iter().flatten() {
        crate::effects::find(id).ok_or_else(|| DiagnoseError::UnknownEffect(id.clone()))?;
    }
    let attempt = |dataset: &Dataset| diagnosis(model, dataset, options, watch);
    let (mut found, skipped) = solvable::of(model, dataset, attempt)?;
    found.comparison.findings = check(model, dataset);
    Ok(Diagnosis { skipped, ..found })
}

/// The diagnosis by all records of `dataset`.
fn diagnosis(
    model: &Model,
    dataset: &Dataset,
    options: &DiagnoseOptions,
    watch: DiagnoseWatch,
) -> Result<Diagnosis, DiagnoseError> {
    let baseline = evaluate("as given", model, dataset);
    // The search makes hundreds of fits.
    let thinned = thinned::of(model, dataset);
    let (mut bench, scales) =
        prepared(model, thinned.as_ref().unwrap_or(dataset), options.assumptions, watch.interrupt)?;
    let table = split::is_table(dataset);
    let parts = match table {
        true => split::whole(dataset),
        false => split::split(dataset, |record| {
            cycles::driver(record).map(|c| c.values.clone()).unwrap_or_default()
        }),
    };
    let measured = noise_of(model, dataset);
    let progress = Progress { watch, done: AtomicUsize::new(0), of: AtomicUsize::new(1) };
    progress.tell("refitting the model as it is");
    if let Some(reason) = split::too_little(dataset, &parts).filter(|_| !table) {
        return Ok(verdict::insufficient(model, dataset, baseline, measured, &parts, reason));
    }
    let (tried, untried) = candidates::tried(model, &bench, options.effects.as_deref());
    progress.expect(1 + tried.len() + AFTER_EFFECTS);
    let Base { first, whole: base, lost, through } = base(&mut bench, model, &parts.seen(), &measured)?;
    let seen = parts.seen();
    let training = Fitted { records: &seen, noise: &measured, through: &through };
    let data = training.of(&bench);
    let tell = |what: &str| progress.tell(what);
    let weighed = asked(&bench, model, &training, &scales, watch.interrupt, |question| {
        evidence::weigh(question, base, &tried, options.max_effects, &tell)
    });
    let mut weighed = weighed.map_err(|reason| unpredictable(&bench, model, reason))?;
    let context = Context { model, dataset, bench: &bench, data: &data, parts: &parts, table };
    let test = Measured::new(&bench, &parts.test, &measured, &through);
    let all = Measured::new(&bench, &parts.all(), &measured, &through);
    let decision = Decision::of(&context, &weighed).confirmed(&context, &weighed, &test, &all);
    let is_base = weighed.weights[0] < 1.0 - options.assumptions.certain;
    let not_allowed = if decision.verdict == Verdict::Unexplained || (decision.best == 0 && is_base) {
        weighed.allow_for_inputs(decision.best, &data)
    } else {
        let every = thinned.is_some().then_some(dataset);
        assured(&mut weighed, decision.best, model, &training, &bench, every)?
    };
    if !bench.interrupted() {
        progress.tell("the parameters told, from other starts and in finer steps");
    }
    if is_base {
        weighed.refitted_as(first, &data);
    }
    let told = weighed.sets[decision.best].members.len();
    let mut diagnosis =
        verdict::of(&context, &weighed, decision, [&test, &all], (baseline, measured, untried));
    let of_options = limits(options, &diagnosis, told);
    diagnosis.reasons.extend(split::copies(dataset));
    diagnosis.reasons.extend(lost.into_iter().chain(not_allowed).chain(of_options));
    Ok(diagnosis)
}

/// What the options have to do with the answer, in which so many effects are `told`.
fn limits(options: &DiagnoseOptions, diagnosis: &Diagnosis, told: usize) -> Vec<String> {
    let mut limits = Vec::new();
    if let Some(only) = &options.effects {
        let only = only.join(", ");
        limits.push(format!("only {only} was tried: the result says nothing of the other effects"));
    }
    let most = options.max_effects;
    if most == 0 {
        limits.push("no effect may be added (--max-effects 0)".to_owned());
    } else if diagnosis.may_lack_more_than(most) {
        limits.push(format!("more than {most} together were not tried (--max-effects {})", most + 1));
    }
    if told > MOST {
        limits.push(format!("more than {MOST} effects together fit some of what they did not cause"));
    }
    limits
}

/// The model refitted as it is to some records.
struct Base {
    /// As if the residual were white.
    first: Posterior,
    whole: Posterior,
    /// Why `whole` is no more than a first look, if it is.
    lost: Option<String>,
    /// What the noise of the inputs makes of every record's channels.
    through: Vec<Vec<f64>>,
}

/// `model` refitted to `records`.
fn base(
    bench: &mut WeightedDataset,
    model: &Model,
    records: &[usize],
    measured: &[Noise],
) -> Result<Base, DiagnoseError> {
    let first = {
        let about = bench.linearised_at_measurement();
        let about = about.as_ref().map(|bench| Measured::new(bench, records, measured, &[]));
        evidence::first(&Measured::new(bench, records, measured, &[]), about.as_ref(), model)
    };
    let (first, solutions) = first.map_err(|reason| unpredictable(bench, model, reason))?;
    bench.reseed(&first.model, solutions);
    let all: Vec<usize> = (0..bench.lanes.len()).collect();
    let steps = evidence::steps_needed(&Measured::new(bench, &all, measured, &[]), &first.model);
    bench.lanes.iter_mut().zip(steps).for_each(|(lane, steps)| lane.steps = steps);
    let through = inputs::through(&first.model, bench);
    let whole = evidence::again(&Measured::new(bench, records, measured, &through), &first);
    let (whole, lost) = match whole {
        Ok(whole) => (whole, None),
        Err(reason) if bench.interrupted() => return Err(unpredictable(bench, &first.model, reason)),
        // Where the response is lost on the way, the first look is what there is.
        Err(reason) => (
            first.clone(),
            Some(format!("the model as it is was only looked at, not fitted in full: {reason}")),
        ),
    };
    let data = Measured::new(bench, records, measured, &through);
    let lacks_nothing = evidence::doubt(&data, &whole).is_ok_and(|doubt| doubt < 0.0);
    let freed = if lacks_nothing { None } else { evidence::freed(&data, &whole) };
    let Some(freed) = freed else { return Ok(Base { first, whole, lost, through }) };
    bench.reseed(&freed.model, Vec::new());
    Ok(Base { first, whole: freed, lost: None, through })
}

/// The bench and the magnitudes, or why the model cannot be refitted to the dataset.
fn prepared<'d>(
    model: &Model,
    dataset: &'d Dataset,
    assumptions: Assumptions,
    interrupt: Option<InterruptHook<'d>>,
) -> Result<(WeightedDataset<'d>, Scales), DiagnoseError> {
    if !model.parameters().iter().any(|parameter| parameter.free) {
        return Err(RefitError::NothingFree.into());
    }
    let bench = WeightedDataset::new(model, dataset, assumptions, interrupt)
        .map_err(|(record, reason)| RefitError::Unpredictable { record, reason })?;
    Ok((bench, magnitudes::of(model, dataset)))
}

/// Records that hypotheses are fitted to, with what is known of their noise.
#[derive(Clone, Copy)]
struct Fitted<'a> {
    records: &'a [usize],
    noise: &'a [Noise],
    /// What the noise of the inputs makes of every record's channels.
    through: &'a [Vec<f64>],
}

impl Fitted<'_> {
    fn of<'b, 'd>(&self, bench: &'b WeightedDataset<'d>) -> Measured<'b, 'd> {
        Measured::new(bench, self.records, self.noise, self.through)
    }
}

/// Makes sure of the numbers of the set that was `decided` for, by `every` sample where those of `bench` are not all; why they do
/// not hold, if they do not.
fn assured<'d>(
    weighed: &mut Weighed,
    decided: usize,
    model: &Model,
    training: &Fitted,
    bench: &WeightedDataset<'d>,
    every: Option<&'d Dataset>,
) -> Result<Option<String>, DiagnoseError> {
    let data = training.of(bench);
    let Some(every) = every.filter(|_| !bench.interrupted()) else {
        return Ok(weighed.assure(decided, &data, None));
    };
    let whole = bench.of_samples(model, every);
    let whole = whole.map_err(|(record, reason)| RefitError::Unpredictable { record, reason })?;
    let through = inputs::through(&weighed.sets[decided].posterior.model, &whole);
    let reason = weighed.assure(decided, &data, Some(&Fitted { through: &through, ..*training }.of(&whole)));
    bench.add_spent(&whole);
    Ok(reason)
}

/// What `answer` says of the question that `bench` poses, with first looks and beginnings of the same records.
fn asked<A>(
    bench: &WeightedDataset,
    model: &Model,
    fitted: &Fitted,
    scales: &Scales,
    interrupt: Option<InterruptHook>,
    answer: impl FnOnce(&Question) -> A,
) -> A {
    let about = bench.linearised_at_measurement();
    let looks = about.as_ref().map(|about| fitted.of(about));
    let cut = beginnings::of(model, bench.dataset);
    // Those that cannot be predicted lead nowhere.
    let benches =
        cut.iter().filter_map(|cut| WeightedDataset::new(model, cut, bench.assumptions, interrupt).ok());
    let benches: Vec<WeightedDataset> = benches.collect();
    let beginnings: Vec<Measured> = benches.iter().map(|bench| fitted.of(bench)).collect();
    let (data, dataset) = (fitted.of(bench), bench.dataset);
    answer(&Question { data: &data, looks: looks.as_ref(), beginnings: &beginnings, dataset, scales })
}

/// Why `model` could not be refitted: with the first record that no fit from there can start with, if there is one.
fn unpredictable(bench: &WeightedDataset, model: &Model, reason: String) -> DiagnoseError {
    if bench.interrupted() {
        return RefitError::Fit(FitError::Interrupted).into();
    }
    let records = &bench.dataset.records;
    // What has no response at all before what has none near to the measured motion.
    let all = || 0..records.len();
    let unsolved = |record: usize| Some((record, bench.score(model, &[record]).err()?));
    let no_start = |record: usize| Some((record, evidence::no_start(bench, model, record)?));
    match all().find_map(unsolved).or_else(|| all().find_map(no_start)) {
        Some((record, reason)) => RefitError::Unpredictable { record: records[record].name.clone(), reason },
        None => RefitError::Unfitted { reason },
    }
    .into()
}

/// Adds `effect` at `location` to `model` from all its starts, refits all together to the records that a fit
/// may see, and evaluates before and after. A record that cannot be solved is left out, and the stages say why.
///
/// # Errors
/// As [`diagnose`].
pub fn add(
    model: &Model,
    effect: &'static Effect,
    location: Option<Location>,
    dataset: &Dataset,
    watch: DiagnoseWatch,
) -> Result<Added, DiagnoseError> {
    let attempt = |dataset: &Dataset| added(model, effect, location.clone(), dataset, watch);
    let (mut found, skipped) = solvable::of(model, dataset, attempt)?;
    found.stages.iter_mut().for_each(|stage| solvable::tell(stage, dataset, &skipped));
    Ok(found)
}

/// The same by all records of `dataset`.
fn added(
    model: &Model,
    effect: &'static Effect,
    location: Option<Location>,
    dataset: &Dataset,
    watch: DiagnoseWatch,
) -> Result<Added, DiagnoseError> {
    let before = evaluate("as given", model, dataset);
    let (bench, scales) = prepared(model, dataset, Assumptions::default(), watch.interrupt)?;
    let records = &dataset.records;
    let marked =
        |mark| (0..records.len()).filter(|index| records[*index].use_for == mark).collect::<Vec<_>>();
    let fit = match marked(Some(crate::data::Use::Fit)) {
        fit if fit.is_empty() => marked(None),
        fit => fit,
    };
    if fit.is_empty() {
        return Err(RefitError::NothingToFit.into());
    }
    let progress = Progress { watch, done: AtomicUsize::new(0), of: AtomicUsize::new(2) };
    let measured = noise_of(model, dataset);
    let mut bench = bench;
    let Base { whole: mut base, lost, through, .. } = base(&mut bench, model, &fit, &measured)?;
    progress.tell("refitted");
    let forms = Candidate::forms(effect, location.as_ref(), model);
    let training = Fitted { records: &fit, noise: &measured, through: &through };
    let with = asked(&bench, model, &training, &scales, watch.interrupt, |question| {
        evidence::added(question, &base, &forms)
    });
    let mut with = with.map_err(|reason| unpredictable(&bench, model, reason))?;
    let [of_base, of_with] = [&mut base, &mut with].map(|of| evidence::intervals(&training.of(&bench), of));
    progress.tell(effect.id);
    let mut stages = vec![before];
    stages.push(stage("refitted", &base, model, dataset, &bench));
    stages[1].notes.extend(lost.into_iter().chain(of_base));
    let law = |model: &Model| model.contact.map(|contact| contact.law.kind);
    let name = match law(&with.model) {
        Some(other) if law(model) != Some(other) => format!("{} (law {})", effect.id, other.name),
        _ => effect.id.to_owned(),
    };
    let mut last = stage(&name, &with, &base.model, dataset, &bench);
    last.notes.extend(of_with);
    stages.push(last);
    Ok(Added { model: with.model.with_new_free(model), stages })
}

/// Stages of a diagnosis after its effects were tried, that are told.
const AFTER_EFFECTS: usize = 4;

/// Counts what is done of what is expected.
struct Progress<'a> {
    watch: DiagnoseWatch<'a>,
    done: AtomicUsize,
    of: AtomicUsize,
}

impl Progress<'_> {
    fn tell(&self, what: &str) {
        let done = self.done.fetch_add(1, Ordering::Relaxed);
        if let Some(progress) = self.watch.progress {
            progress(what, done, self.of.load(Ordering::Relaxed).max(done));
        }
    }

    /// Raises what is expected.
    fn expect(&self, more: usize) {
        self.of.fetch_add(more, Ordering::Relaxed);
    }
}

impl Verdict {
    /// Whether the model of the last stage stands for what was found.
    pub fn stands(self) -> bool {
        matches!(self, Self::NothingMissing | Self::EffectFound)
    }
}
