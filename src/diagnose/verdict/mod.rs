//! The verdict that the results of the search support, and the report of it.
//!
//! What the search found comes in, one of five verdicts goes out; `explain` gives its reasons in sentences.

mod explain;

use crate::data::Dataset;
use crate::diagnose::diagnosis::{
    Candidate, Cost, Diagnosis, Errors, Estimate, Group, Noise, Step, Untried, Verdict,
};
use crate::diagnose::engine::{comparison, cost, errors, stage};
use crate::diagnose::measurements::split::Parts;
use crate::diagnose::measurements::weighted_dataset::{WeightedDataset, mean_square};
use crate::diagnose::search::candidates::{Candidate as Tried, effect_of};
use crate::diagnose::search::confound;
use crate::diagnose::search::select::{PASSING_FRACTION, PASSING_Z, Search, Trial};
use crate::diagnose::search::selection_path::{Added, Outcome, UNEXPLAINED};
use crate::diagnose::search::sensitivity::{self, Sensitivities};
use crate::fit::compare::Stage;
use crate::model::Model;
use explain::VerdictContext;

/// Fraction of the squared residual above which a part of it that repeats from record to record says that something
/// is missing, though the whole is of the noise's size.
const STRUCTURED: f64 = 0.1;

/// Error over the channels' variation below which there is nothing to explain, whatever the noise.
const NOTHING_LEFT: f64 = 1e-3;
/// The same above which, the noise unknown, what was added explains too little to be named.
const MOST_LEFT: f64 = 0.6;
/// And fraction of the refitted model's squared error: whoever removes less may stand in for something else.
const MOST_FRACTION_LEFT: f64 = 0.6;

/// What a verdict is made of.
pub(in crate::diagnose) struct Material<'a> {
    pub model: &'a Model,
    pub dataset: &'a Dataset,
    pub baseline: Stage,
    pub measured: Vec<Noise>,
    /// Whether all noise is known.
    pub known: bool,
    pub tried: Vec<Tried>,
    pub untried: Vec<Untried>,
    pub outcome: Outcome,
}

/// The whole diagnosis.
pub(in crate::diagnose) fn of(search: &Search, whole: &WeightedDataset, material: Material) -> Diagnosis {
    let Material { model, dataset, baseline, measured, known, tried, mut untried, outcome } = material;
    let found = outcome.findings.effects();
    let stages = stages(model, dataset, baseline, &outcome);
    let last = &outcome.fits[outcome.fits.len() - 1];
    let error = errors(search, whole, &outcome, &stages, known);
    let sensitivities = sensitivities(search, &outcome, &tried);
    for id in &sensitivities.invisible {
        untried.push(Untried {
            effect: id,
            reason: "not identifiable in these data: the model's own parameters or the unknown initial states have the \
                     same effect"
                .to_owned(),
        });
    }
    let groups = groups(&outcome);
    let verdict = judge(&outcome, known, &groups, &error);
    let ids: Vec<&'static str> = found.iter().map(|candidate| candidate.effect.id).collect();
    let context = VerdictContext {
        search,
        outcome: &outcome,
        given: model,
        error: &error,
        known,
        groups: &groups,
        verdict,
    };
    let (effects, surrogates) = match verdict {
        Verdict::EffectFound => (ids.clone(), Vec::new()),
        Verdict::Unexplained => (Vec::new(), surrogates(&outcome)),
        // The significant effects, besides those that cannot be distinguished.
        Verdict::NotDistinguishable => {
            let doubtful = |id: &&&str| groups.iter().any(|group| group.effects.contains(*id));
            (ids.iter().filter(|id| !doubtful(id)).copied().collect(), Vec::new())
        }
        _ => (Vec::new(), Vec::new()),
    };
    Diagnosis {
        verdict,
        reasons: explain::reasons(&context),
        evidence: explain::evidence(&context, &ids, &sensitivities),
        next_experiment: explain::next_experiment(&context, &sensitivities),
        effects,
        surrogates,
        groups: if verdict == Verdict::NotDistinguishable { groups } else { Vec::new() },
        error,
        chi_square: outcome.chi_square,
        steps: outcome.findings.steps.iter().map(step).collect(),
        candidates: outcome.findings.rounds.first().map_or_else(Vec::new, |round| {
            settled(reported(search.bench, round, search.given), search, &outcome)
        }),
        parameters: last.estimates.clone(),
        rounds: outcome
            .findings
            .rounds
            .iter()
            .skip(1)
            .map(|round| reported(search.bench, round, search.given))
            .collect(),
        untried,
        confounding: sensitivities.confounding.clone(),
        detectable: sensitivities.detectable,
        split: search.parts.uses(dataset.records.len()),
        noise: measured,
        comparison: comparison(dataset, stages),
        model: last.model.clone().with_effects_free(search.given),
        cost: cost(&[Some(search.bench), search.beginnings, search.linearised_at_measurement, Some(whole)]),
    }
}

/// As given, refitted, and one per step that was kept.
fn stages(model: &Model, dataset: &Dataset, baseline: Stage, outcome: &Outcome) -> Vec<Stage> {
    let mut stages = vec![baseline];
    let mut before = model;
    let findings = &outcome.findings;
    let names = std::iter::once("refitted".to_owned())
        .chain(findings.steps.iter().map(|step| format!("+ {}", names(step))))
        .chain(findings.dropped().then(|| "without the effects that are not needed".to_owned()));
    for (name, fitted) in names.zip(&outcome.fits) {
        stages.push(stage(&name, fitted, before, dataset));
        before = &fitted.model;
    }
    stages
}

fn names(step: &Added) -> String {
    let names: Vec<&str> = step.candidates.iter().map(|candidate| candidate.effect.title).collect();
    names.join(" + ")
}

fn step(added: &Added) -> Step {
    Step {
        added: added.candidates.iter().map(|candidate| candidate.effect.id).collect(),
        error: added.error,
        gain_z: added.gain.z,
        gain_fraction: added.gain.fraction,
        dropped: added.dropped(),
    }
}

/// Effects that lower the error without explaining it: those added, else the best with a significant gain.
fn surrogates(outcome: &Outcome) -> Vec<&'static str> {
    let mut ids: Vec<&'static str> =
        outcome.findings.effects().iter().map(|candidate| candidate.effect.id).collect();
    let passing = outcome.findings.rounds.first().into_iter().flatten().filter(|trial| trial.passes());
    for trial in passing.take(3) {
        for id in trial.ids() {
            if !ids.contains(&id) {
                ids.push(id);
            }
        }
    }
    ids
}

/// Ties among the effects that were kept.
fn groups(outcome: &Outcome) -> Vec<Group> {
    let mut groups = Vec::new();
    for step in outcome.findings.steps.iter().filter(|step| !step.dropped()) {
        let mut ids: Vec<&'static str> =
            step.candidates.iter().map(|candidate| candidate.effect.id).collect();
        let own = ids.len();
        for other in &step.tied {
            if !ids.contains(&other.effect.id) {
                ids.push(other.effect.id);
            }
        }
        if ids.len() > own {
            groups.push(confound::group(ids));
        }
    }
    groups
}

/// The verdict.
fn judge(outcome: &Outcome, known: bool, groups: &[Group], errors: &Errors) -> Verdict {
    let error = errors.test;
    let none = outcome.findings.effects().is_empty();
    let test = outcome.chi_square.unwrap_or(f64::NAN);
    let selecting = if known { outcome.selecting } else { f64::NAN };
    let elsewhere = outcome.left.is_some_and(|left| left.is_too_much());
    // A part that comes again at the same places of the motion is no noise, however small.
    let structured = outcome.repeated.is_some_and(|repeated| repeated.gain.fraction > STRUCTURED);
    // What was named must explain the data; the model as it was is doubted for more than chance.
    let too_much = if none {
        outcome.left.is_some_and(|left| left.is_significant())
    } else {
        test > UNEXPLAINED || selecting > UNEXPLAINED || elsewhere
    };
    if known && too_much {
        return Verdict::Unexplained;
    }
    if none && known && structured {
        return Verdict::Unexplained;
    }
    if none {
        // A model whose error nothing lowers is not thereby right: without the noise nobody knows.
        return if known || error < NOTHING_LEFT { Verdict::NothingMissing } else { Verdict::Unexplained };
    }
    let fraction = (error / errors.test_refitted).powi(2);
    if !known && (error > MOST_LEFT || fraction > MOST_FRACTION_LEFT) {
        return Verdict::Unexplained;
    }
    if !groups.is_empty() {
        return Verdict::NotDistinguishable;
    }
    Verdict::EffectFound
}

/// The sensitivities around the model that the search ended with.
fn sensitivities(search: &Search, outcome: &Outcome, tried: &[Tried]) -> Sensitivities {
    let last = outcome.findings.last();
    let present = outcome.findings.effects();
    let left: Vec<Tried> = tried.iter().filter(|candidate| !present.contains(candidate)).cloned().collect();
    sensitivity::around(search, &last.fitted.model, &left, mean_square(&last.scored)).unwrap_or_default()
}

/// A round for the report.
fn reported(bench: &WeightedDataset, round: &[Trial], given: usize) -> Vec<Candidate> {
    round.iter().map(|trial| reported_one(bench, trial, given)).collect()
}

/// A trial for the report.
pub(in crate::diagnose) fn reported_one(bench: &WeightedDataset, trial: &Trial, given: usize) -> Candidate {
    let (error, parameters, evaluations) = match &trial.state {
        Ok(state) => (
            bench.normalised_error(&state.scored),
            own_parameters(trial, &state.fitted.estimates, &state.fitted.model, given),
            state.fitted.simulations,
        ),
        Err(_) => (f64::NAN, Vec::new(), 0),
    };
    Candidate {
        effects: trial.ids(),
        location: trial.candidates.iter().find_map(|c| c.location.as_ref().map(ToString::to_string)),
        error,
        gain_z: trial.gain.z,
        gain_fraction: trial.gain.fraction,
        parameters,
        evaluations,
        failure: trial.state.as_ref().err().cloned(),
    }
}

/// The first round with what was found put right: a candidate that was alone in its refit has taken over part of
/// what was found later, and its interval knows nothing of that.
fn settled(mut round: Vec<Candidate>, search: &Search, outcome: &Outcome) -> Vec<Candidate> {
    let last = &outcome.fits[outcome.fits.len() - 1];
    for (index, found) in outcome.findings.effects().iter().enumerate() {
        let place = found.location.as_ref().map(ToString::to_string);
        let of_it = |one: &&mut Candidate| one.effects == [found.effect.id] && one.location == place;
        if let Some(candidate) = round.iter_mut().find(of_it) {
            let index = search.given + index;
            candidate.parameters = parameters_of(&last.estimates, &last.model, index..index + 1);
        }
    }
    round
}

/// The parameters of a trial's own effects, by their names alone.
fn own_parameters(trial: &Trial, estimates: &[Estimate], model: &Model, given: usize) -> Vec<Estimate> {
    let first = model.effects.len().saturating_sub(trial.candidates.len()).max(given);
    parameters_of(estimates, model, first..usize::MAX)
}

/// The parameters of the effects of `model` with these numbers, by their names alone.
fn parameters_of(estimates: &[Estimate], model: &Model, effects: std::ops::Range<usize>) -> Vec<Estimate> {
    estimates
        .iter()
        .filter(|estimate| {
            effect_of(&estimate.name, model).is_some_and(|(index, _)| effects.contains(&index))
        })
        .map(|estimate| {
            let name = estimate.name.rsplit('.').next().unwrap_or_default().to_owned();
            Estimate { name, ..estimate.clone() }
        })
        .collect()
}

/// A diagnosis that could not be made.
pub(in crate::diagnose) fn insufficient(
    model: &Model,
    dataset: &Dataset,
    baseline: Stage,
    measured: Vec<Noise>,
    parts: &Parts,
    reason: String,
) -> Diagnosis {
    let error = baseline.error;
    Diagnosis {
        verdict: Verdict::InsufficientData,
        reasons: vec![reason],
        effects: Vec::new(),
        surrogates: Vec::new(),
        groups: Vec::new(),
        error: Errors {
            baseline: error,
            refitted: error,
            last: error,
            test: f64::NAN,
            test_refitted: f64::NAN,
            noise_floor: None,
            test_noise_floor: None,
        },
        chi_square: None,
        steps: Vec::new(),
        candidates: Vec::new(),
        parameters: Vec::new(),
        rounds: Vec::new(),
        untried: crate::effects::CATALOGUE
            .iter()
            .map(|effect| Untried {
                effect: effect.id,
                reason: "the dataset has too few records to try it".to_owned(),
            })
            .collect(),
        confounding: Vec::new(),
        detectable: Vec::new(),
        evidence: Vec::new(),
        next_experiment: Some(
            "Measure at least three levels, each twice, some of them from rest and over two periods or more"
                .to_owned(),
        ),
        split: parts.uses(dataset.records.len()),
        noise: measured,
        comparison: comparison(dataset, vec![baseline]),
        model: model.clone(),
        cost: Cost::default(),
    }
}

/// The thresholds in words, for the reasons.
pub(in crate::diagnose) fn thresholds() -> String {
    format!("z > {PASSING_Z} and more than {:.0} % of the squared error", 100.0 * PASSING_FRACTION)
}
