//! The diagnosis from beginning to end: split, noise, rounds of refits, one look at the test records.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::diagnosis::{Cost, Diagnosis, Errors, Noise, Verdict};
use super::measurements::noise;
use super::measurements::split::{self, Parts};
use super::measurements::weighted_dataset::{Scored, WeightedDataset, mean_square};
use super::measurements::{beginnings, inputs, magnitudes, thinned};
use super::refit::trial::{self, Effort, Fitted, Unknown};
use super::residual::{blocks, maps, remainder};
use super::search::candidates::{self, Candidate};
use super::search::select::{Search, State};
use super::search::selection_path::{ADEQUATE, Outcome, ResidualSummary, SelectionPath, UNEXPLAINED};
use super::{evaluate, few_points, verdict};
use crate::data::Dataset;
use crate::effects::{Effect, Location};
use crate::fit::InterruptHook;
use crate::fit::compare::{Comparison, RefitError, Stage, evaluate_from};
use crate::model::Model;

/// Mean square of the weighted residuals below which the noise must be smaller than it is said to be.
const INCREDIBLE: f64 = 0.5;

/// What a diagnosis tries.
///
/// ```
/// use stickslip::diagnose::DiagnoseOptions;
/// // Two effects of the catalogue, and at most one of them added.
/// let options = DiagnoseOptions { effects: Some(vec!["backlash".into(), "wear".into()]), max_effects: 1 };
/// assert!(DiagnoseOptions::default().effects.is_none() && options.max_effects == 1);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DiagnoseOptions {
    /// Ids of the only effects to try; `None` for the whole catalogue.
    pub effects: Option<Vec<String>>,
    /// Effects that may be added at most.
    pub max_effects: usize,
}

impl Default for DiagnoseOptions {
    fn default() -> Self {
        Self { effects: None, max_effects: 3 }
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

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DiagnoseError {
    /// An id that the catalogue does not have.
    #[error("there is no effect `{0}`")]
    UnknownEffect(String),
    /// The model as it is could not be refitted.
    #[error("{0}")]
    Refit(#[from] RefitError),
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
/// The records are split into training, validation and test records. Every effect of the catalogue is added to the full
/// simulator and refitted with the whole model on the training records; effects are selected by their error on the
/// validation records. The test records are read once, at the end: they may remove effects again, and decide whether the
/// model explains the data.
///
/// # Errors
/// [`DiagnoseError`]: an unknown effect, a model without a free parameter, records that cannot be predicted.
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
/// // One record cannot be split into training, validation and test records.
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
    let baseline = evaluate("as given", model, dataset);
    let (mut whole, scales) = prepared(model, dataset, watch.interrupt)?;
    // The search makes hundreds of refits; the last few are made on all samples.
    let thinned = thinned::of(model, dataset);
    let mut bench = match &thinned {
        Some(thinned) => prepared(model, thinned, watch.interrupt)?.0,
        None => prepared(model, dataset, watch.interrupt)?.0,
    };
    let parts =
        split::split(dataset, |record| noise::driver(record).map(|c| c.values.clone()).unwrap_or_default());
    let measured = noise::measure(&whole.lanes);
    let meter = Progress { watch, done: AtomicUsize::new(0), of: AtomicUsize::new(1) };
    meter.tell("refitting the model as it is");
    if few_points::applies(dataset) {
        return table(model, dataset, options, watch, (bench, scales), (baseline, measured, &meter));
    }
    if let Some(reason) = split::too_little(dataset, &parts) {
        return Ok(verdict::insufficient(model, dataset, baseline, measured, &parts, reason));
    }
    let given = model.effects.len();
    let report = |what: &str| meter.tell(what);
    let first = refitted_at_first(&bench, model, &parts, |model| {
        candidates::unknowns(model, given, &scales, dataset)
    })
    .map_err(|reason| unpredictable(&bench, model, reason))?;
    bench.reseed(&first.model);
    let through = inputs::through(&first.model, &bench);
    let stated = noise::weigh(&mut bench.lanes, &measured, &through);
    noise::weigh(&mut whole.lanes, &measured, &through);
    let linearised_at_measurement = bench.linearised_at_measurement();
    let beginnings = beginnings::of(model, dataset);
    let mut beginnings =
        beginnings.as_ref().and_then(|cut| WeightedDataset::new(model, cut, watch.interrupt).ok());
    if let Some(beginnings) = &mut beginnings {
        beginnings.reseed(&first.model);
        noise::weigh(&mut beginnings.lanes, &measured, &through);
    }
    let search = Search {
        beginnings: beginnings.as_ref(),
        linearised_at_measurement: linearised_at_measurement.as_ref(),
        ..Search::new(&bench, &parts, &scales, model, &report)
    };
    let base = search.state(&first.model).map_err(|reason| unpredictable(&bench, &first.model, reason))?;
    let smallest = base.chi_square().min(search.fitted_chi_square(&base));
    let known = stated && smallest > INCREDIBLE;
    let (mut tried, untried) = candidates::of(model, &bench);
    if let Some(only) = &options.effects {
        tried.retain(|candidate| only.iter().any(|id| id == candidate.effect.id));
    }
    meter.expect(1 + tried.len());
    let findings = SelectionPath::search(&search, base, &tried, options.max_effects, known, &meter);
    let outcome = conclude(&search, &whole, model, findings, known)?;
    let mut diagnosis = verdict::of(
        &search,
        &whole,
        verdict::Material { model, dataset, baseline, measured, known, tried, untried, outcome },
    );
    let reasons = &mut diagnosis.reasons;
    if stated && !known {
        reasons.push(format!(
            "the reduced χ² of the refitted model is {smallest:.2}: the noise that is stated, or that repeats show, is \
             too large for these data, so it counts as unknown"
        ));
    }
    reasons.extend(split::copies(dataset));
    if let Some(only) = &options.effects {
        let only = only.join(", ");
        reasons.push(format!("only {only} was tried: the result says nothing of the other effects"));
    }
    if options.max_effects == 0 {
        reasons.push("no effect may be added (--max-effects 0): the candidates are listed only".to_owned());
    }
    Ok(diagnosis)
}

/// The model refitted from where it is or, where motions are solved for, from what fits best about those that were
/// measured: the better of the two.
fn refitted_at_first(
    bench: &WeightedDataset,
    model: &Model,
    parts: &Parts,
    unknowns: impl Fn(&Model) -> Vec<Unknown>,
) -> Result<Fitted, String> {
    let fit = |bench: &WeightedDataset, model: &Model| {
        trial::fit(bench, model, &unknowns(model), &parts.fit, Effort::Full)
    };
    let direct = fit(bench, model);
    let about = bench.linearised_at_measurement().and_then(|about| fit(&about, model).ok());
    match (direct, about.and_then(|about| fit(bench, &about.model).ok())) {
        (Ok(direct), Some(led)) if direct.cost <= led.cost => Ok(direct),
        (_, Some(led)) => Ok(led),
        (direct, None) => direct,
    }
}

/// The diagnosis of a table of few points.
fn table(
    model: &Model,
    dataset: &Dataset,
    options: &DiagnoseOptions,
    watch: DiagnoseWatch,
    (mut bench, scales): (WeightedDataset, crate::effects::Scales),
    (baseline, measured, meter): (Stage, Vec<Noise>, &Progress),
) -> Result<Diagnosis, DiagnoseError> {
    noise::weigh(&mut bench.lanes, &measured, &vec![Vec::new(); dataset.records.len()]);
    let parts = few_points::whole(dataset);
    let report = |what: &str| meter.tell(what);
    let search = Search::new(&bench, &parts, &scales, model, &report);
    let material =
        few_points::Material { model, dataset, baseline, measured, options, interrupt: watch.interrupt };
    few_points::diagnose(&search, material).map_err(|reason| unpredictable(&bench, model, reason))
}

/// The bench and the magnitudes, or why the model cannot be refitted to the dataset.
fn prepared<'d>(
    model: &Model,
    dataset: &'d Dataset,
    interrupt: Option<InterruptHook<'d>>,
) -> Result<(WeightedDataset<'d>, crate::effects::Scales), DiagnoseError> {
    if !model.parameters().iter().any(|parameter| parameter.free) {
        return Err(RefitError::NothingFree.into());
    }
    let bench = WeightedDataset::new(model, dataset, interrupt)
        .map_err(|(record, reason)| RefitError::Unpredictable { record, reason })?;
    Ok((bench, magnitudes::of(model, dataset)))
}

/// Why `model` could not be refitted, with the first record that it does not predict as it stands.
fn unpredictable(bench: &WeightedDataset, model: &Model, reason: String) -> DiagnoseError {
    let records = &bench.dataset.records;
    let failing = (0..records.len()).find(|record| bench.score(model, &[*record]).is_err());
    let record = records.get(failing.unwrap_or(0)).map(|record| record.name.clone()).unwrap_or_default();
    RefitError::Unpredictable { record, reason }.into()
}

/// Standard errors by which the first effect must worsen the test records to be taken back.
const HARMFUL_Z: f64 = 1.0;

/// How many effects of a chain the test records confirm, from their `scores` and `errors` with the first effect to
/// those with all, and `before` any: those up to the first that does not lower the error. A first effect that changes
/// nothing there may still be small; one that does harm is none. But an effect may do good only beside one that was
/// found after it: where more of the chain gains significantly, that much of it is kept.
fn validated_prefix(
    whole: &WeightedDataset,
    before: &[Scored],
    scores: &[Vec<Scored>],
    errors: &[f64],
) -> usize {
    let Some(first) = scores.first() else { return 0 };
    let lost = first.is_empty() && !before.is_empty();
    let harmful = lost || blocks::gain(whole, before, first).z < -HARMFUL_Z;
    let rising = (1..errors.len()).find(|k| errors[*k] >= errors[k - 1]);
    let kept = if harmful { 0 } else { rising.unwrap_or(errors.len()) };
    let stop = if kept == 0 { before } else { &scores[kept - 1] };
    let best = (kept..errors.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b]));
    match best {
        Some(best) if blocks::gain(whole, stop, &scores[best]).passes() => best + 1,
        _ => kept,
    }
}

/// The last fits, to all samples of all records that were seen, and the one look at those that were not. It may
/// take back effects that do not hold there.
fn conclude(
    search: &Search,
    whole: &WeightedDataset,
    given: &Model,
    mut findings: SelectionPath,
    known: bool,
) -> Result<Outcome, DiagnoseError> {
    let seen = search.parts.seen();
    let refit = |model: &Model| -> Result<Fitted, DiagnoseError> {
        trial::fit(whole, model, &search.unknowns(model), &seen, Effort::Full)
            .map_err(|reason| unpredictable(whole, model, reason))
    };
    let mut fits = vec![refit(&findings.base.fitted.model)?];
    for step in &findings.steps {
        fits.push(refit(&step.state.fitted.model)?);
    }
    if findings.dropped() {
        fits.push(refit(&findings.last().fitted.model)?);
    }
    let chain = chain(search, &findings, &fits, refit)?;
    let test = &search.parts.test;
    let score = |fitted: &Fitted| whole.score_anew(fitted, test).unwrap_or_default();
    let before = score(&fits[0]);
    let mut scores: Vec<Vec<Scored>> = chain.iter().map(|(_, fitted)| score(fitted)).collect();
    // What the noise is not known of is judged by the error that is reported.
    let error = |scored: &Vec<Scored>| match known {
        _ if scored.is_empty() => f64::INFINITY,
        true => mean_square(scored),
        false => whole.normalised_error(scored),
    };
    let errors: Vec<f64> = scores.iter().map(error).collect();
    let kept = validated_prefix(whole, &before, &scores, &errors);
    if kept < scores.len() {
        let without = (0, fits[0].clone());
        let (count, fitted) = if kept == 0 { &without } else { &chain[kept - 1] };
        // What the backward drop left is no longer the end.
        if findings.dropped() {
            fits.pop();
        }
        findings.veto(search, *count, &fitted.model);
        fits.push(fitted.clone());
        scores.truncate(kept);
    }
    let after = scores.pop().unwrap_or_else(|| before.clone());
    let chi_square = (known && !after.is_empty()).then(|| mean_square(&after));
    let given = whole.normalised_error(&whole.score(given, test).unwrap_or_default());
    let follows = if known { remainder::follows(whole, &after) } else { Vec::new() };
    let last = fits.last().map(|last| whole.score_anew(last, &seen));
    let last = last.and_then(Result::ok).unwrap_or_default();
    let repeated = maps::repeated(whole, &last, &after);
    let selecting = search.least_chi_square(findings.last(), UNEXPLAINED);
    let left = known.then(|| {
        let least = blocks::least_mean_square;
        let selecting = selecting.min(least(search.bench, &findings.last().scored));
        let certain = selecting.max(least(whole, &last)).max(least(whole, &after));
        ResidualSummary::of(&last, &after, certain)
    });
    let within_covariance = chi_square.is_some_and(|chi_square| {
        let model = fits.last().map(|fitted| &fitted.model);
        let made = |model| search.prediction_variance(whole, model, &seen, test);
        chi_square > UNEXPLAINED
            && mean_square(&last) < ADEQUATE
            && model.is_some_and(|model| chi_square - made(model) < ADEQUATE)
    });
    Ok(Outcome {
        findings,
        fits,
        given,
        before,
        after,
        chi_square,
        selecting,
        left,
        within_covariance,
        follows,
        repeated,
    })
}

/// The models from the first effect that was kept to all of them, each one more than the one before, fitted to
/// all records seen; with the number of their effects. `fits` holds those of the steps and the last.
fn chain(
    search: &Search,
    findings: &SelectionPath,
    fits: &[Fitted],
    refit: impl Fn(&Model) -> Result<Fitted, DiagnoseError>,
) -> Result<Vec<(usize, Fitted)>, DiagnoseError> {
    if !findings.dropped() {
        let mut count = 0;
        let counted = findings.steps.iter().zip(&fits[1..]).map(|(step, fitted)| {
            count += step.candidates.len();
            (count, fitted.clone())
        });
        return Ok(counted.collect());
    }
    let last = &fits[fits.len() - 1];
    let kept = findings.effects();
    let mut chain = Vec::new();
    for count in 1..kept.len() {
        let step = findings.steps.iter().take(count).flat_map(|step| &step.candidates);
        let fitted = if step.eq(&kept[..count]) {
            fits[count].clone()
        } else {
            let mut model = last.model.clone();
            model.effects.truncate(search.given + count);
            refit(&model)?
        };
        chain.push((count, fitted));
    }
    chain.push((kept.len(), last.clone()));
    Ok(chain)
}

/// Adds `effect` at `location` to `model` from all its starts, refits all together to the records that a fit
/// may see, and evaluates before and after.
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
    let before = evaluate("as given", model, dataset);
    let (bench, scales) = prepared(model, dataset, watch.interrupt)?;
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
    let meter = Progress { watch, done: AtomicUsize::new(0), of: AtomicUsize::new(2) };
    let report = |what: &str| meter.tell(what);
    let parts = Parts { fit, ..Parts::default() };
    let search = Search::new(&bench, &parts, &scales, model, &report);
    let failed = |reason| unpredictable(&bench, model, reason);
    let base: State = search.state(model).map_err(failed)?;
    meter.tell("refitted");
    let candidate = Candidate { effect, location };
    let with = search.added(&base.fitted.model, &[candidate]).map_err(failed)?;
    meter.tell(effect.id);
    let mut stages = vec![before];
    for (name, fitted, start) in
        [("refitted", &base.fitted, model), (effect.id, &with.fitted, &base.fitted.model)]
    {
        stages.push(stage(name, fitted, start, dataset));
    }
    Ok(Added { model: with.fitted.model.with_effects_free(model.effects.len()), stages })
}

/// The evaluation of a fitted model, its parameters marked with where they started.
pub(super) fn stage(name: &str, fitted: &Fitted, start: &Model, dataset: &Dataset) -> Stage {
    let mut stage = evaluate_from(name, &fitted.model, dataset, |record| fitted.seed(record));
    stage.evaluations = fitted.simulations;
    for parameter in &mut stage.parameters {
        let changed = fitted.estimates.iter().any(|estimate| estimate.name == parameter.path);
        parameter.fitted_from = if changed { start.get(&parameter.path) } else { None };
    }
    stage
}

/// Counts what is done of what is expected.
pub(super) struct Progress<'a> {
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
    pub fn expect(&self, more: usize) {
        self.of.fetch_add(more, Ordering::Relaxed);
    }
}

/// The comparison of all stages.
pub(super) fn comparison(dataset: &Dataset, stages: Vec<Stage>) -> Comparison {
    Comparison { title: dataset.title.clone().unwrap_or_default(), records: dataset.records.clone(), stages }
}

/// Errors of the last models and of those before, by the parts.
pub(super) fn errors(
    search: &Search,
    bench: &WeightedDataset,
    outcome: &Outcome,
    stages: &[Stage],
    known: bool,
) -> Errors {
    let floor = |records: &[usize]| {
        let channels = records.iter().flat_map(|record| {
            let lane = &bench.lanes[*record];
            lane.channels.iter().map(|(_, range)| lane.scales[range.start] / lane.weights[range.start])
        });
        let (sum, count) =
            channels.fold((0.0, 0), |(sum, count), fraction| (sum + fraction * fraction, count + 1));
        (known && count > 0).then(|| (sum / f64::from(count)).sqrt())
    };
    let error = |index: usize| stages.get(index).map_or(f64::NAN, |stage| stage.error);
    Errors {
        baseline: error(0),
        refitted: error(1),
        last: stages.last().map_or(f64::NAN, |stage| stage.error),
        test: bench.normalised_error(&outcome.after),
        test_refitted: bench.normalised_error(&outcome.before),
        noise_floor: floor(&search.parts.all()),
        test_noise_floor: floor(&search.parts.test),
    }
}

/// What was spent.
pub(super) fn cost(benches: &[Option<&WeightedDataset>]) -> Cost {
    let total =
        |of: fn((usize, usize)) -> usize| benches.iter().flatten().map(|bench| of(bench.spent())).sum();
    Cost { refits: total(|spent| spent.0), simulations: total(|spent| spent.1) }
}

impl Verdict {
    /// Whether the model of the last stage stands for what was found.
    pub fn stands(self) -> bool {
        matches!(self, Self::NothingMissing | Self::EffectFound)
    }
}
