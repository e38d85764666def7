//! A diagnosis as JSON.

use serde_json::{Map, Value, json};
use stickslip::data::{Record, Use};
use stickslip::diagnose::{Candidate, Diagnosis, Estimate, Group, Stage, Step, Verdict};

use super::Run;

/// The diagnosis without its arrays of samples, schema `stickslip.diagnosis/1`.
///
/// ```json
/// {"schema": "stickslip.diagnosis/1", "verdict": "effect-found", "effects": ["backlash"], "groups": [],
///  "error": {"baseline": 0.41, "refitted": 0.38, "final": 0.021, "untouched": 0.023, "noise_floor": 0.02},
///  "candidates": [{"effect": "backlash", "error": 0.021, "gain_z": 41.0,
///    "parameters": {"half_gap": {"value": 2.3e-3, "low": 2.2e-3, "high": 2.4e-3, "unit": "m"}}}],
///  "detectable": {"wear": {"parameter": "rate", "value": 3.1, "unit": "1/m"}},
///  "next_experiment": null, "seconds": 1.9}
/// ```
///
/// and more keys, which give the details. `effects` are the significant ones, where the verdict
/// is `effect-found` or `not-distinguishable`; `places` says where they sit, `law`
/// which contact law shows them in the place of the model's (`null` for effects of their own); `groups` are lists of ids.
/// `P_relevant` of a detection limit is the posterior probability that the effect, if it is there, moves a channel by more than
/// 1 % of its variation. `residual` holds the shapes of what the last model lacks, each with the share of the residual's variance
/// that it predicts in other records, and hints. Units are SI. Numbers that are unknown or not finite are `null`.
pub fn diagnosis_json(diagnosis: &Diagnosis, run: &Run) -> Value {
    let named = matches!(diagnosis.verdict, Verdict::EffectFound | Verdict::NotDistinguishable);
    let groups: Vec<&[&str]> = diagnosis.groups.iter().map(|group| &group.effects[..]).collect();
    let next = diagnosis.next_experiment.clone().or_else(|| {
        let open = diagnosis.verdict == Verdict::NotDistinguishable;
        diagnosis.groups.first().filter(|_| open).map(|group| group.experiment.clone())
    });
    json!({
        "schema": "stickslip.diagnosis/1",
        "verdict": diagnosis.verdict.id(),
        "probability": diagnosis.probability,
        "noise_known": diagnosis.noise_is_known,
        "effects": if named { &diagnosis.effects[..] } else { &[] },
        "law": diagnosis.law,
        "places": places(diagnosis),
        "groups": groups,
        "error": errors(diagnosis),
        "candidates": diagnosis.candidates.iter().map(candidate).collect::<Vec<_>>(),
        "parameters": estimates(&diagnosis.parameters),
        "detectable": detectable(diagnosis),
        "next_experiment": next,
        "seconds": run.seconds,
        "reasons": diagnosis.reasons,
        "notes": super::words::warnings(diagnosis, run),
        "surrogates": diagnosis.surrogates,
        "group_details": diagnosis.groups.iter().map(group).collect::<Vec<_>>(),
        "chi_square": diagnosis.chi_square,
        "steps": diagnosis.steps.iter().map(step).collect::<Vec<_>>(),
        "rounds": diagnosis.rounds.iter().map(|round| round.iter().map(candidate).collect()).collect::<Vec<Vec<_>>>(),
        "untried": diagnosis.untried.iter().map(|one| json!({ "effect": one.effect, "reason": one.reason }))
            .collect::<Vec<_>>(),
        "confounding": diagnosis.confounding.iter()
            .map(|one| json!({ "effects": one.effects, "correlation": one.correlation })).collect::<Vec<_>>(),
        "evidence": diagnosis.evidence.iter()
            .map(|one| json!({ "effect": one.effect, "seen": one.seen, "otherwise": one.otherwise }))
            .collect::<Vec<_>>(),
        "residual": super::residual::to_json(diagnosis),
        "skipped": diagnosis.skipped.iter()
            .map(|one| json!({ "file": one.record, "reason": one.reason })).collect::<Vec<_>>(),
        "checks": crate::comparison::findings::to_json(&diagnosis.comparison.findings),
        "split": split(diagnosis),
        "noise": noise(diagnosis),
        "stages": diagnosis.comparison.stages.iter().map(stage).collect::<Vec<_>>(),
        "model": run.model,
        "dataset": run.dataset,
        "model_written": run.written,
        "settings": {
            "effects": run.options.effects,
            "max_effects": run.options.max_effects,
            "assumptions": run.options.assumptions.named().into_iter().collect::<std::collections::BTreeMap<_, _>>(),
        },
        "starts": { "tried": diagnosis.agreement.starts, "agreeing": diagnosis.agreement.agreeing },
        "cost": cost(diagnosis, run),
        "interrupted": run.interrupted,
    })
}

/// Where the effects sit that were found and sit somewhere.
fn places(diagnosis: &Diagnosis) -> Map<String, Value> {
    let found = diagnosis.model.effects.iter().filter(|one| diagnosis.effects.contains(&one.effect.id));
    found
        .filter_map(|one| Some((one.effect.id.to_owned(), one.location.as_ref()?.to_string().into())))
        .collect()
}

/// An added effect: the stages before and after, schema `stickslip.added/1`.
///
/// `comparison` holds the comparison of the stages as [`crate::json`] gives it.
pub fn added_json(effect: &str, location: Option<&str>, written: &str, comparison: &Value) -> Value {
    json!({
        "schema": "stickslip.added/1", "effect": effect, "location": location, "model_written": written,
        "comparison": comparison,
    })
}

fn errors(diagnosis: &Diagnosis) -> Value {
    let error = &diagnosis.error;
    json!({
        "baseline": error.baseline, "refitted": error.refitted, "final": error.last, "untouched": error.test,
        "noise_floor": error.noise_floor, "untouched_refitted": error.test_refitted,
        "untouched_noise_floor": error.test_noise_floor,
    })
}

fn candidate(candidate: &Candidate) -> Value {
    json!({
        "effect": candidate.effects.join("+"), "effects": candidate.effects, "location": candidate.location,
        "law": candidate.law,
        "error": candidate.error, "gain_z": candidate.gain_z, "gain_share": candidate.gain_fraction,
        "parameters": estimates(&candidate.parameters), "evaluations": candidate.evaluations,
    })
}

fn estimates(all: &[Estimate]) -> Value {
    let mut object = Map::new();
    for estimate in all {
        // Both effects of a pair may have a parameter of that name.
        let mut name = estimate.name.clone();
        for turn in 2.. {
            if !object.contains_key(&name) {
                break;
            }
            name = format!("{}_{turn}", estimate.name);
        }
        let Estimate { value, low, high, unit, .. } = estimate;
        object.insert(name, json!({ "value": value, "low": low, "high": high, "unit": unit }));
    }
    Value::Object(object)
}

fn detectable(diagnosis: &Diagnosis) -> Value {
    let mut object = Map::new();
    for one in &diagnosis.detectable {
        object
            .entry(one.effect)
            .or_insert_with(|| {
            json!({ "parameter": one.parameter, "value": one.value, "unit": one.unit, "P_relevant": one.relevant })
        });
    }
    Value::Object(object)
}

fn group(group: &Group) -> Value {
    json!({ "effects": group.effects, "reason": group.reason, "experiment": group.experiment })
}

fn step(step: &Step) -> Value {
    json!({
        "added": step.added, "error": step.error, "gain_z": step.gain_z, "gain_share": step.gain_fraction,
    })
}

fn record_name(diagnosis: &Diagnosis, record: usize) -> Option<&str> {
    diagnosis.comparison.records.get(record).map(|record| record.name.as_str())
}

fn split(diagnosis: &Diagnosis) -> Vec<Value> {
    let records: &[Record] = &diagnosis.comparison.records;
    records
        .iter()
        .zip(&diagnosis.split)
        .map(|(record, used)| json!({ "file": record.name, "use": id(*used) }))
        .collect()
}

/// As a dataset file spells it.
fn id(used: Use) -> &'static str {
    match used {
        Use::Fit => "fit",
        Use::Select => "select",
        Use::Confirm => "confirm",
    }
}

fn noise(diagnosis: &Diagnosis) -> Vec<Value> {
    let one = |noise: &stickslip::diagnose::Noise| {
        json!({
            "file": record_name(diagnosis, noise.record), "channel": noise.channel, "deviation": noise.deviation,
            "source": crate::json::source(noise.source),
        })
    };
    diagnosis.noise.iter().map(one).collect()
}

fn stage(stage: &Stage) -> Value {
    let parameters: Map<String, Value> = stage
        .parameters
        .iter()
        .map(|one| (one.path.clone(), crate::comparison::fitted::to_json(one)))
        .collect();
    json!({ "name": stage.name, "error": stage.error, "evaluations": stage.evaluations, "parameters": parameters })
}

fn cost(diagnosis: &Diagnosis, run: &Run) -> Value {
    let refits = diagnosis.cost.refits;
    let rate = (run.seconds > 0.0).then(|| refits as f64 / run.seconds);
    json!({
        "refits": refits, "simulations": diagnosis.cost.simulations, "refits_per_second": rate,
        "samples": diagnosis.cost.samples, "fitted_samples": diagnosis.cost.fitted_samples,
        "seconds_per_refit": rate.filter(|rate| *rate > 0.0).map(|rate| 1.0 / rate),
    })
}
