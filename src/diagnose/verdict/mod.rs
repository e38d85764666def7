//! The answer: probabilities of sets of effects come in, a [`Diagnosis`] with its reasons goes out.
//!
//! `context` is what the answer is about, `decision` holds the one rule (`shared`: of several sets
//! together) and the look at the test records, `explain` gives
//! reasons in sentences, `experiment` what to measure next, `confound` the experiments that separate effects.

pub(super) mod confound;
mod context;
mod decision;
mod experiment;
mod explain;
mod shared;

pub(super) use context::Context;
pub(super) use decision::Decision;

use super::candidates::Candidate as Form;
use super::diagnosis::{Agreement, Candidate, Cost, Diagnosis, Errors, Noise, Step, Untried, Verdict};
use super::evidence::{self, Measured, Sensitivities, Set, Weighed};
use super::measurements::split::Parts;
use super::measurements::weighted_dataset::Scored;
use super::stage::stage;
use crate::data::{Dataset, Record};
use crate::fit::compare::{Comparison, Stage};
use crate::fit::residual::{Appearance, appearance};
use crate::model::Model;

/// The whole diagnosis.
pub(super) fn of(
    context: &Context,
    weighed: &Weighed,
    decision: Decision,
    [test, all]: [&Measured; 2],
    (baseline, measured, untried): (Stage, Vec<Noise>, Vec<Untried>),
) -> Diagnosis {
    let best = &weighed.sets[decision.best];
    let (candidates, present) = (&weighed.candidates, &best.members);
    let sensitivities = evidence::around(context.data, &best.posterior, candidates, present)
        .unwrap_or_else(|_| Sensitivities::unknown(candidates, present));
    let decision = decision.limited(context, &sensitivities);
    let (steps, stages) = followed(context, weighed, decision.best, baseline);
    let tested = Tested::of(context, weighed, &decision, test);
    let errors = errors(&stages, &tested, [test, all]);
    // What only absorbs error would hide what is missing.
    let clear = if decision.verdict == Verdict::Unexplained { 1 } else { stages.len() - 1 };
    let residual =
        stages.get(clear).map(|stage| appearance(&context.dataset.records, stage)).unwrap_or_default();
    let explained = explain::Explained {
        context,
        weighed,
        decision: &decision,
        tested: &tested,
        errors: &errors,
        residual: &residual,
        all,
    };
    let (effects, surrogates) = named(weighed, &decision);
    Diagnosis {
        verdict: decision.verdict,
        probability: decision.probability,
        noise_is_known: context.data.noise_is_known(),
        reasons: explain::reasons(&explained),
        evidence: explain::evidence(&explained, &sensitivities),
        next_experiment: experiment::next(&explained),
        law: weighed
            .law(decision.best)
            .filter(|_| decision.verdict == Verdict::EffectFound)
            .map(|law| law.name),
        effects,
        surrogates,
        groups: decision.groups.clone(),
        error: errors,
        chi_square: tested.chi_square,
        steps,
        candidates: round(context, weighed, 1, Some(decision.best)),
        rounds: (2..)
            .map(|size| round(context, weighed, size, None))
            .take_while(|round| !round.is_empty())
            .collect(),
        parameters: best.posterior.estimates(),
        untried: untried_with(untried, weighed, &sensitivities),
        confounding: sensitivities.confounding,
        detectable: sensitivities.detectable,
        residual,
        split: context.parts.uses(context.dataset.records.len()),
        noise: measured,
        skipped: Vec::new(),
        comparison: comparison(context.dataset, stages),
        model: best.posterior.model.clone().with_new_free(context.model),
        agreement: weighed.agreement,
        cost: cost(context),
    }
}

/// What is found, and what only absorbs error.
fn named(weighed: &Weighed, decision: &Decision) -> (Vec<&'static str>, Vec<&'static str>) {
    let ids = weighed.ordered(decision.best);
    match decision.verdict {
        Verdict::EffectFound => (ids, Vec::new()),
        Verdict::Unexplained => (Vec::new(), ids),
        Verdict::NotDistinguishable => (decision.certain.clone(), Vec::new()),
        _ => (Vec::new(), Vec::new()),
    }
}

fn cost(context: &Context) -> Cost {
    let (refits, simulations) = context.bench.spent();
    let samples = |dataset: &Dataset| dataset.records.iter().map(Record::len).sum();
    let fitted_samples = samples(context.bench.dataset);
    Cost { refits, simulations, samples: samples(context.dataset), fitted_samples }
}

/// The way from the model as given to the set `best`: what each step gained, and the model after it.
fn followed(context: &Context, weighed: &Weighed, best: usize, baseline: Stage) -> (Vec<Step>, Vec<Stage>) {
    let chain = weighed.chain(best);
    let steps = steps(context, weighed, &chain);
    let (mut stages, mut before) = (vec![baseline], context.model);
    for (place, &set) in chain.iter().enumerate() {
        let name = if place == 0 { "refitted".to_owned() } else { name(&steps[place - 1]) };
        let fitted = &weighed.sets[set].posterior;
        stages.push(stage(&name, fitted, before, context.dataset, context.bench));
        before = &fitted.model;
    }
    (steps, stages)
}

/// What was not tried, and what was without being seen.
fn untried_with(mut untried: Vec<Untried>, weighed: &Weighed, sensitivities: &Sensitivities) -> Vec<Untried> {
    let silent = weighed.silent.iter().map(|candidate| candidate.effect.id);
    let invisible = sensitivities.invisible.iter().copied().chain(silent).map(|effect| {
        let reason = "not identifiable in these data: it changes nothing that the model's own parameters or the unknown initial \
                      states could not change";
        (effect, reason)
    });
    let lost = weighed.unpredictable.iter().map(|candidate| {
        let reason = "these records could not be predicted with it, in no size that was tried";
        (candidate.effect.id, reason)
    });
    for (effect, reason) in invisible.chain(lost) {
        if untried.iter().all(|known| known.effect != effect) {
            untried.push(Untried { effect, reason: reason.to_owned() });
        }
    }
    untried
}

fn comparison(dataset: &Dataset, stages: Vec<Stage>) -> Comparison {
    let title = dataset.title.clone().unwrap_or_default();
    Comparison {
        title,
        records: dataset.records.clone(),
        ring_downs: Vec::new(),
        findings: Vec::new(),
        notes: Vec::new(),
        stages,
    }
}

/// What the test records say.
struct Tested {
    /// Errors with the effects and without, and of the model as given.
    with: f64,
    without: f64,
    given: f64,
    chi_square: Option<f64>,
}

impl Tested {
    fn of(context: &Context, weighed: &Weighed, decision: &Decision, test: &Measured) -> Self {
        let score = |model: &Model| context.bench.score(model, &test.records).unwrap_or_default();
        let error = |scored: &[Scored]| context.bench.normalised_error(scored);
        let with = score(&weighed.sets[decision.best].posterior.model);
        let predictions: Vec<Vec<f64>> = with.iter().map(|one| one.predictions.clone()).collect();
        let values: Vec<f64> = with.iter().map(|one| one.predictions.len() as f64).collect();
        let sum: f64 = test.chi_squares(&predictions).iter().zip(&values).map(|(chi, n)| chi * n).sum();
        let known = test.noise_is_known() && !with.is_empty();
        Self {
            with: error(&with),
            without: error(&score(&weighed.sets[0].posterior.model)),
            given: error(&score(context.model)),
            chi_square: known.then(|| sum / values.iter().sum::<f64>()),
        }
    }
}

fn errors(stages: &[Stage], tested: &Tested, [test, all]: [&Measured; 2]) -> Errors {
    let error = |index: usize| stages.get(index).map_or(f64::NAN, |stage| stage.error);
    Errors {
        baseline: error(0),
        refitted: error(1),
        last: stages.last().map_or(f64::NAN, |stage| stage.error),
        test: tested.with,
        test_refitted: tested.without,
        noise_floor: all.floor(),
        test_noise_floor: test.floor(),
    }
}

fn name(step: &Step) -> String {
    let title = |id: &&str| crate::effects::find(id).map_or("", |effect| effect.title);
    format!("+ {}", step.added.iter().map(title).collect::<Vec<_>>().join(" + "))
}

/// The steps along a chain of sets.
fn steps(context: &Context, weighed: &Weighed, chain: &[usize]) -> Vec<Step> {
    let step = |pair: &[usize]| {
        let (before, after) = (&weighed.sets[pair[0]], &weighed.sets[pair[1]]);
        let added = after.members.iter().filter(|member| !before.members.contains(member));
        let (gain_z, gain_fraction) = gain(context, before, after);
        Step {
            added: added.map(|member| weighed.candidates[*member].candidate.effect.id).collect(),
            error: context.error(after),
            gain_z,
            gain_fraction,
        }
    };
    chain.windows(2).map(step).collect()
}

/// Gain in standard deviations, and as a fraction of the squared error.
fn gain(context: &Context, before: &Set, after: &Set) -> (f64, f64) {
    let gain = after.posterior.log_evidence - before.posterior.log_evidence;
    let fraction = 1.0 - (context.error(after) / context.error(before)).powi(2);
    (gain.signum() * (2.0 * gain.abs()).sqrt(), fraction)
}

/// The sets of a size for the report, best first; candidates that were not worth a fit gained nothing. The parameters of
/// those in the `best` set are those of that.
fn round(context: &Context, weighed: &Weighed, size: usize, best: Option<usize>) -> Vec<Candidate> {
    let mut sets: Vec<&Set> =
        weighed.sets.iter().filter(|set| set.discrepancy.is_none() && set.members.len() == size).collect();
    sets.sort_by(|a, b| b.posterior.log_evidence.total_cmp(&a.posterior.log_evidence));
    let mut round: Vec<Candidate> = sets.iter().map(|set| fitted(context, weighed, set)).collect();
    if size > 1 {
        return round;
    }
    let fitted = |one: &Form| sets.iter().any(|set| weighed.form(set.members[0]).is_form_of(one));
    for one in weighed.candidates.iter().map(|one| &one.candidate) {
        if one.law.is_none() && !fitted(one) {
            round.push(Candidate {
                effects: vec![one.effect.id],
                location: one.location.as_ref().map(ToString::to_string),
                law: None,
                error: context.error(&weighed.sets[0]),
                gain_z: 0.0,
                gain_fraction: 0.0,
                parameters: Vec::new(),
                evaluations: 0,
            });
        }
    }
    let best = &weighed.sets[best.unwrap_or(0)];
    for &member in &best.members {
        let one = weighed.form(member);
        let location = one.location.as_ref().map(ToString::to_string);
        let law = one.law.map(|law| law.name);
        let of_it = |told: &&mut Candidate| {
            told.effects == [one.effect.id] && told.location == location && told.law == law
        };
        if let Some(told) = round.iter_mut().find(of_it) {
            told.parameters = best.posterior.brought(Some(member));
        }
    }
    round
}

fn fitted(context: &Context, weighed: &Weighed, set: &Set) -> Candidate {
    let (gain_z, gain_fraction) = gain(context, &weighed.sets[0], set);
    let members = || set.members.iter().map(|member| weighed.form(*member));
    Candidate {
        effects: members().map(|one| one.effect.id).collect(),
        location: members().find_map(|one| one.location.as_ref().map(ToString::to_string)),
        law: members().find_map(|one| one.law).map(|law| law.name),
        error: context.error(set),
        gain_z,
        gain_fraction,
        parameters: set.posterior.brought(None),
        evaluations: set.posterior.simulations,
    }
}

/// A diagnosis that could not be made.
pub(super) fn insufficient(
    model: &Model,
    dataset: &Dataset,
    baseline: Stage,
    measured: Vec<Noise>,
    parts: &Parts,
    reason: String,
) -> Diagnosis {
    let error = baseline.error;
    let untried = |effect: &&'static crate::effects::Effect| Untried {
        effect: effect.id,
        reason: "the dataset has too few records to try it".to_owned(),
    };
    Diagnosis {
        verdict: Verdict::InsufficientData,
        probability: f64::NAN,
        noise_is_known: measured.iter().all(|noise| noise.deviation.is_some()),
        reasons: vec![reason],
        effects: Vec::new(),
        law: None,
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
        untried: crate::effects::CATALOGUE.iter().map(untried).collect(),
        confounding: Vec::new(),
        detectable: Sensitivities::default().detectable,
        evidence: Vec::new(),
        residual: Appearance::default(),
        next_experiment: Some(
            "Measure at least three levels, each twice, some of them from rest and over two periods or more"
                .to_owned(),
        ),
        split: parts.uses(dataset.records.len()),
        noise: measured,
        skipped: Vec::new(),
        comparison: comparison(dataset, vec![baseline]),
        model: model.clone(),
        agreement: Agreement::default(),
        cost: Cost::default(),
    }
}
