//! Response curves as JSON.

use std::f64::consts::PI;

use serde_json::{Map, Value, json};
use stickslip::harmonic::{Curve, Ending, Point};

use super::{Held, PhaseResonance, ResponseCurve, Responses, ending, trust};
use crate::Settings;

/// The curves, schema `stickslip.frf/1`.
///
/// ```json
/// {"schema": "stickslip.frf/1", "seconds": 0.03, "complete": true,
///  "settings": {"from": 0.2, "to": 2.0, "unit": "rad/s", "harmonics": 21, "tolerance": 1e-6, "stability": true,
///    "held": null, "levels": [0.4], "command": "...", "version": "...", "files": [{"name": "...", "sha256": "..."}]},
///  "nodes": ["m1", "m2"],
///  "curves": [{"level": 0.4, "held": null, "points": 160, "ending": "complete", "failure": null, "seconds": 0.03}],
///  "points": [{"curve": 0, "omega": 0.5, "frequency_hz": 0.0796, "level": 0.4, "held": null,
///    "amplitude": {"m1": 0.93}, "harmonic1": {"m1": 0.93}, "phase1": {"m1": -0.3}, "dissipated": 0.134, "work": 0.766,
///    "dissipated_by_structure": 0.0, "dissipated_by_dampers": 0.632,
///    "equivalent_stiffness": 0.0112, "stick_fraction": 0.05, "stable": true, "undecided": null,
///    "error_estimate": 1e-7, "resolved": true, "harmonics": 21}],
///  "peaks": [{"curve": 0, "node": "m1", "omega": 0.527, "frequency_hz": 0.0839, "amplitude": 1.008, "level": 0.4,
///    "error_estimate": 1e-7, "resolved": true}],
///  "phase_resonances": [{"curve": 0, "node": "m1", "omega": 0.52, "frequency_hz": 0.0828, "level": 0.4,
///    "interpolated": false}],
///  "folds": [{"curve": 0, "omega": 1.2, "frequency_hz": 0.19, "level": 0.4, "amplitude": {"m1": 1.0}}]}
/// ```
///
/// SI units; `omega` in rad/s. `amplitude` is the largest magnitude of the displacement over a period,
/// `harmonic1` the amplitude of its first harmonic and `phase1` the phase of that against the force (rad, in
/// (−π, π], negative where it lags). `error_estimate` and `resolved` of a peak are those of the nearest point;
/// both are `null` where the error is unknown. `level` is the force (N), `held` the held amplitude.
/// With a held response, `peaks` are the peaks of response over force, where the least force holds it, and
/// `phase_resonances` where the held displacement falls to a quarter period behind the force; otherwise there are none. `dissipated`,
/// `equivalent_stiffness` and `stick_fraction` are those of the model's contact. What the structure's own
/// nonlinearities (drag) take is `dissipated_by_structure`; `work` is the sum of both and of `dissipated_by_dampers`,
/// which is `null` for a beam. Where `stable` is `null` though it was asked for, `undecided` says why.
/// Numbers that do not exist are `null`.
pub fn responses_json(responses: &Responses, settings: &Settings) -> Value {
    let files: Vec<Value> =
        settings.files.iter().map(|file| json!({ "name": file.name, "sha256": file.sha256 })).collect();
    let (from, to) = responses.range;
    let mut document = json!({
        "schema": "stickslip.frf/1",
        "title": responses.title,
        "seconds": responses.seconds,
        "complete": responses.complete(),
        "warnings": responses.warnings().iter().map(|text| text.replace('\u{a0}', " ")).collect::<Vec<_>>(),
        "settings": {
            "from": responses.unit.of(from), "to": responses.unit.of(to), "unit": responses.unit.name(),
            "harmonics": responses.harmonics, "tolerance": responses.tolerance, "stability": responses.stability,
            "held": responses.held.as_ref().map(Held::name),
            "levels": responses.curves.iter().map(|one| one.level).collect::<Vec<_>>(),
            "command": settings.command, "version": settings.version, "files": files,
        },
        "nodes": responses.nodes(),
        "curves": responses.curves.iter().map(|one| curve(responses, one)).collect::<Vec<_>>(),
        "points": null, "peaks": null, "phase_resonances": null, "folds": null,
    });
    let points = |index: usize, one: &ResponseCurve| -> Vec<Value> {
        one.curve.points.iter().map(|at| point(responses, index, one, at)).collect()
    };
    // Large where there are many nodes: moved to their places, which `json!` would fill with copies.
    document["points"] = every(responses, points).into();
    document["peaks"] = every(responses, peaks).into();
    document["phase_resonances"] = every(responses, phase_resonances).into();
    document["folds"] = every(responses, |index, one| folds(index, &one.curve)).into();
    document
}

fn every(responses: &Responses, of: impl Fn(usize, &ResponseCurve) -> Vec<Value>) -> Vec<Value> {
    responses.curves.iter().enumerate().flat_map(|(index, one)| of(index, one)).collect()
}

/// The level where that is an amplitude held.
fn held(responses: &Responses, one: &ResponseCurve) -> Option<f64> {
    responses.held.as_ref().map(|_| one.level)
}

fn curve(responses: &Responses, one: &ResponseCurve) -> Value {
    json!({
        "level": responses.held.is_none().then_some(one.level), "held": held(responses, one),
        "points": one.curve.points.len(), "ending": ending(one), "failure": one.failure,
        "complete": one.curve.ending == Ending::Complete && one.failure.is_none(), "seconds": one.seconds,
    })
}

fn point(responses: &Responses, index: usize, one: &ResponseCurve, point: &Point) -> Value {
    let by_node = |values: &[f64]| -> Map<String, Value> {
        one.curve.nodes.iter().cloned().zip(values.iter().map(|value| json!(value))).collect()
    };
    let (losses, contact) = (&responses.losses, responses.losses.contact(point));
    let mut document = json!({
        "curve": index, "omega": point.angular_frequency,
        "frequency_hz": point.angular_frequency / std::f64::consts::TAU,
        "level": point.level, "held": held(responses, one),
        "amplitude": null, "harmonic1": null, "phase1": null,
        "dissipated": losses.of_contact(point), "work": point.work,
        "dissipated_by_structure": losses.of_structure(point), "dissipated_by_dampers": losses.of_dampers(point),
        "equivalent_stiffness": contact.map(|contact| contact.equivalent_stiffness),
        "stick_fraction": contact.and_then(|contact| contact.stick_fraction),
        "stable": point.stable, "undecided": point.undecided.map(trust::reason), "error_estimate": point.error_estimate, "resolved": resolved(point),
        "harmonics": point.harmonics,
    });
    document["amplitude"] = by_node(&point.amplitude).into();
    document["harmonic1"] = by_node(&point.first_harmonic()).into();
    document["phase1"] = by_node(&phases(point)).into();
    document
}

/// Nothing where the error is unknown.
fn resolved(point: &Point) -> Option<bool> {
    match trust::error(point) {
        trust::Error::Resolved => Some(true),
        trust::Error::Unresolved => Some(false),
        trust::Error::Unknown => None,
    }
}

/// Phase of each node's first harmonic relative to the force (rad), in (−π, π]; NaN where it does not move.
fn phases(point: &Point) -> Vec<f64> {
    let sign = if point.level < 0.0 { -1.0 } else { 1.0 };
    let phase = |node: &Vec<f64>| match node[..] {
        [_, cosine, sine, ..] if cosine != 0.0 || sine != 0.0 => {
            let phase = (-sign * sine).atan2(sign * cosine);
            if phase <= -PI { PI } else { phase }
        }
        _ => f64::NAN,
    };
    point.nodes.iter().map(phase).collect()
}

/// Where the held displacement is a quarter period behind the force.
fn phase_resonances(index: usize, one: &ResponseCurve) -> Vec<Value> {
    let resonance = |at: &PhaseResonance| {
        json!({
            "curve": index, "node": one.curve.nodes.get(at.node), "omega": at.angular_frequency,
            "frequency_hz": at.angular_frequency / std::f64::consts::TAU, "level": at.level,
            "interpolated": at.interpolated,
        })
    };
    one.phase_resonances.iter().map(resonance).collect()
}

fn peaks(index: usize, one: &ResponseCurve) -> Vec<Value> {
    let curve = &one.curve;
    let peak = |peak: &stickslip::harmonic::Peak| {
        let point = trust::nearest(one, peak);
        json!({
            "curve": index, "node": curve.nodes.get(peak.node), "omega": peak.angular_frequency,
            "frequency_hz": peak.angular_frequency / std::f64::consts::TAU,
            "amplitude": peak.amplitude, "level": peak.level,
            "error_estimate": point.map(|point| point.error_estimate), "resolved": point.and_then(resolved),
        })
    };
    curve.peaks.iter().map(peak).collect()
}

/// Where the curve turns back.
fn folds(index: usize, curve: &Curve) -> Vec<Value> {
    let fold = |fold: &stickslip::harmonic::Fold| {
        let amplitude: Map<String, Value> =
            curve.nodes.iter().cloned().zip(fold.amplitude.iter().map(|value| json!(value))).collect();
        json!({
            "curve": index, "omega": fold.angular_frequency,
            "frequency_hz": fold.angular_frequency / std::f64::consts::TAU,
            "level": fold.level, "amplitude": amplitude,
        })
    };
    curve.folds.iter().map(fold).collect()
}
