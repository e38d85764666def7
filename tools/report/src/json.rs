//! A comparison as JSON.

use serde_json::{Map, Value, json};
use stickslip::data::{Record, Regime, Use};
use stickslip::diagnose::{Comparison, Noise, NoiseSource, RecordResult, Stage, StepGain};
use stickslip::fit::ring_down::{Level, RingDown};

use crate::comparison::{fitted, floors, summary};
use crate::explorer::Harmonics;
use crate::tables;

/// The comparison without its arrays, schema `stickslip.comparison/1`.
///
/// ```json
/// {"schema": "stickslip.comparison/1", "title": "...", "verdict": "...",
///  "error": {"baseline": 0.41, "refitted": 0.38, "noise_floor": 0.02}, "against_noise": {"ratio": 19.0, "verdict": "more-than-noise"},
///  "gains": [{"stage": "refitted", "before": 0.41, "after": 0.38}],
///  "skipped": [{"file": "open.csv", "reason": "..."}],
///  "checks": [{"file": "r0.csv", "channel": "force", "fault": "reversed-sign", "message": "..."}],
///  "rms": {"channel": "frequency", "unit": "Hz", "baseline": 1.8, "refitted": 0.1},
///  "stages": [{"name": "baseline", "error": 0.41, "evaluations": 0,
///    "parameters": {"contact.normal_load": {"value": 162.0, "unit": "N", "fitted": true, "fitted_from": 150.0,
///      "low": 160.0, "high": 164.0, "at_bound": false, "unseen": false,
///      "correlated": [{"with": "contact.friction_coefficient", "correlation": -0.99}]}},
///    "records": [{"file": "r0.csv", "regime": "from-rest", "use": "fit", "error": 0.4, "failure": null,
///      "channels": {"force": {"unit": "N", "error": 0.4, "rms": 31.0}}}]}],
///  "steps": [{"from": "Jenkins", "to": "Valanis", "parameters": [2, 3], "f": 8.1, "chance": 0.036, "aicc": -2.3}],
/// "noise": [{"file": "r0.csv", "channel": "force", "deviation": 0.5, "source": "periods", "error": 0.01}],
///  "ring_downs": [{"file": "decay.csv", "channel": "acceleration:x=0.55", "levels": [{"time": 0.1, "amplitude": 31.0,
///    "frequency": {"value": 50.1, "low": 50.0, "high": 50.2}, "damping_ratio": {...}}]}],
///  "harmonics": [{"file": "r0.csv", "channel": "force", "fundamental": 10.0, "errors": [[0.0, 0.3]]}]}
/// ```
///
/// `refitted` is the last stage. Units are SI (Hz for frequencies). Numbers that are not finite, and
/// errors of records without a prediction, are `null`. `rms` is over the records that every stage
/// predicts, and `null` where the records do not all share one channel. `error` is over the same records; the others are in
/// `skipped`.
pub fn json(comparison: &Comparison, noise: &[Noise]) -> Value {
    let summary = summary::summarise(comparison);
    let skipped = summary
        .skipped
        .iter()
        .map(|(record, reason)| json!({ "file": comparison.records[*record].name, "reason": reason }));
    let gains =
        comparison.stages.windows(2).zip(summary.normalised.windows(2)).map(
            |(stages, errors)| json!({ "stage": stages[1].name, "before": errors[0], "after": errors[1] }),
        );
    let rms = summary.common.as_ref().map(|common| {
        json!({
            "channel": common.name, "unit": common.unit,
            "baseline": summary.errors.first(), "refitted": summary.errors.last(),
        })
    });
    json!({
        "schema": "stickslip.comparison/1",
        "title": comparison.title,
        "verdict": floors::with_noise(&summary.verdict, comparison, &summary, noise).replace('\u{a0}', " "),
        "against_noise": floors::to_json(comparison, &summary, noise),
        "gains": gains.collect::<Vec<_>>(),
        "notes": summary.notes.iter().map(|note| note.replace('\u{a0}', " ")).collect::<Vec<_>>(),
        "skipped": skipped.collect::<Vec<_>>(),
        "checks": crate::comparison::findings::to_json(&comparison.findings),
        "error": { "baseline": summary.normalised.first(), "refitted": summary.normalised.last(),
            "noise_floor": floors::total(comparison, noise) },
        "rms": rms,
        "stages": comparison.stages.iter().map(|one| stage(comparison, one)).collect::<Vec<_>>(),
        "steps": comparison.steps().iter().map(|one| step(comparison, one)).collect::<Vec<_>>(),
        "noise": noise.iter().map(|one| self::noise(comparison, one)).collect::<Vec<_>>(),
        "ring_downs": comparison.ring_downs.iter().map(ring_down).collect::<Vec<_>>(),
        "harmonics": tables::all_harmonics(comparison).iter().map(|one| harmonics(comparison, one)).collect::<Vec<_>>(),
    })
}

/// Standard deviation of a channel's noise, and the normalised error that it alone would leave.
fn noise(comparison: &Comparison, noise: &Noise) -> Value {
    let record = comparison.records.get(noise.record);
    let fraction = record.and_then(|_| {
        floors::fraction(comparison, std::slice::from_ref(noise), noise.record, &noise.channel)
    });
    json!({
        "file": record.map(|record| &record.name), "channel": noise.channel, "deviation": noise.deviation,
        "source": source(noise.source), "error": fraction,
    })
}

/// What a step gains where the values are few.
fn step(comparison: &Comparison, step: &StepGain) -> Value {
    let [from, to] = step.stages.map(|index| &comparison.stages[index].name);
    json!({
        "from": from, "to": to, "parameters": step.parameters, "f": step.ratio, "chance": step.p_value,
        "aicc": step.criterion,
    })
}

/// The levels of a free decay, with 95 % intervals.
fn ring_down(ring_down: &RingDown) -> Value {
    let number = |value: f64, half: f64| json!({ "value": value, "low": value - half, "high": value + half });
    let level = |level: &Level| {
        json!({
            "time": level.time, "amplitude": level.amplitude,
            "frequency": number(level.frequency, level.frequency_interval),
            "damping_ratio": number(level.damping_ratio, level.damping_interval),
        })
    };
    json!({
        "file": ring_down.record, "channel": ring_down.channel,
        "levels": ring_down.levels.iter().map(level).collect::<Vec<_>>(),
    })
}

/// How the noise of a channel is known.
pub(crate) fn source(source: NoiseSource) -> &'static str {
    match source {
        NoiseSource::Stated => "stated",
        NoiseSource::Periods => "periods",
        NoiseSource::Repeats => "repeats",
        NoiseSource::Carried => "carried",
        NoiseSource::Unknown => "unknown",
    }
}

/// The residual by harmonic, from the mean on, over the channel's standard deviation, stage by stage.
fn harmonics(comparison: &Comparison, harmonics: &Harmonics) -> Value {
    json!({
        "file": comparison.records[harmonics.record].name, "channel": harmonics.channel,
        "fundamental": harmonics.fundamental, "errors": harmonics.residuals,
    })
}

fn stage(comparison: &Comparison, stage: &Stage) -> Value {
    let parameters: Map<String, Value> = stage
        .parameters
        .iter()
        .map(|parameter| (parameter.path.clone(), fitted::to_json(parameter)))
        .collect();
    let records =
        comparison.records.iter().zip(&stage.records).map(|(measured, result)| record(measured, result));
    json!({
        "name": stage.name, "error": stage.error, "evaluations": stage.evaluations,
        "parameters": parameters, "records": records.collect::<Vec<_>>(),
    })
}

fn record(measured: &Record, result: &RecordResult) -> Value {
    let channels: Map<String, Value> = result
        .channels
        .iter()
        .map(|channel| {
            let value = json!({ "unit": channel.unit, "error": channel.error, "rms": channel.rms });
            (channel.name.clone(), value)
        })
        .collect();
    let error = result.failure.is_none().then_some(result.error);
    json!({
        "file": measured.name, "regime": regime(measured.regime), "use": measured.use_for.map(use_for),
        "error": error, "failure": result.failure, "channels": channels,
    })
}

/// As a dataset file spells it.
fn regime(regime: Regime) -> &'static str {
    match regime {
        Regime::FromRest => "from-rest",
        Regime::Steady => "steady",
        Regime::UnknownInitialState => "unknown-initial-state",
        Regime::Backbone => "backbone",
        Regime::SteppedSine => "stepped-sine",
    }
}

/// As a dataset file spells it.
fn use_for(use_for: Use) -> &'static str {
    match use_for {
        Use::Fit => "fit",
        Use::Select => "select",
        Use::Confirm => "confirm",
    }
}
