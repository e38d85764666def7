//! An identification for programs.

use serde_json::{Map, Value, json};
use stickslip::fit::Interval;
use stickslip::identify::{
    ContactPeriod, ContactRecord, IdentifiedLaw, IdentifiedParameter, Level, LinearRecord,
};

use super::{IdentificationReport, name_of, words};

/// Standard errors of a 95 % interval.
const WIDE: f64 = 1.96;

/// The identification under the schema `stickslip.identification/1`; numbers in SI units, those that are not told `null`.
///
/// `force_interval`, `displacement_interval` and `velocity_interval` are half-widths of 95 % intervals, root mean square over
/// the period, without the mean. `error` is normalised by the root mean square of the identified force without its mean.
pub fn identification_json(report: &IdentificationReport) -> Value {
    let found = report.found;
    let conditioning = found.inversion.as_ref().map(|inversion| inversion.conditioning);
    let records: Vec<Value> =
        report.periods().map(|(record, period)| one_record(record, period, conditioning)).collect();
    let names = |places: &[usize]| places.iter().map(|k| found.records[*k].name.clone()).collect::<Vec<_>>();
    let laws: Vec<Value> = found
        .laws
        .iter()
        .map(|law| {
            let errors = found.records.iter().zip(&law.errors);
            json!({
                "law": name_of(law),
                "fitted_records": names(&found.fitted),
                "parameters": parameters(law),
                "error": errors.map(|(record, error)| (record.name.clone(), json!(error))).collect::<Map<_, _>>(),
            })
        })
        .collect();
    let chain = found.inversion.as_ref().map(|inversion| {
        let gain = |[log, deviation]: [f64; 2]| {
            json!({ "value": log.exp(), "low": (log - WIDE * deviation).exp(), "high": (log + WIDE * deviation).exp() })
        };
        let mass = |[mass, deviation]: [f64; 2]| {
            json!({ "value": mass, "low": mass - WIDE * deviation, "high": mass + WIDE * deviation })
        };
        json!({
            "excitation_gain": gain(inversion.excitation_gain),
            "sensor_gains": inversion.sensor_gains.iter().copied().map(gain).collect::<Vec<_>>(),
            "sensor_masses": inversion.sensor_masses.iter().copied().map(mass).collect::<Vec<_>>(),
            "misfit": inversion.misfit,
        })
    });
    let reasons = found.unidentified.iter().map(|one| (one.name.to_owned(), json!(one.reason)));
    let skipped = found.skipped.iter().map(|(file, reason)| json!({ "file": file, "reason": reason }));
    json!({
        "schema": "stickslip.identification/1",
        "method": "receptance-inversion",
        "records": records,
        "laws": laws,
        "failed_laws": found.failed_laws.iter().map(|(law, reason)| json!({ "law": law, "reason": reason })).collect::<Vec<_>>(),
        "best": report.best().map(name_of),
        "range": found.range,
        "unidentified": found.unidentified.iter().map(|one| one.name).collect::<Vec<_>>(),
        "unidentified_reasons": reasons.collect::<Map<_, _>>(),
        "beam": found.beam,
        "measuring_chain": chain,
        "levels": found.levels.iter().map(level).collect::<Vec<_>>(),
        "linear": found.linear.iter().map(linear).collect::<Vec<_>>(),
        "skipped": skipped.collect::<Vec<_>>(),
        "warnings": found.warnings,
        "notes": report.notes,
    })
}

fn one_record(record: &ContactRecord, period: &ContactPeriod, conditioning: Option<f64>) -> Value {
    let mean = WIDE * period.covariance[(0, 0)].sqrt();
    json!({
        "file": record.name, "frequency": record.frequency, "force_interval": record.intervals[0],
        "displacement_interval": record.intervals[1], "velocity_interval": record.intervals[2],
        "conditioning": conditioning, "amplitude": record.amplitude, "excitation": record.force,
        "harmonics": record.harmonics, "unexplained": period.unexplained,
        "mean_force": { "value": period.force[0], "low": period.force[0] - mean, "high": period.force[0] + mean },
        "two_modes": record.published.as_ref().map(|published| {
            json!({ "difference": published.difference, "conditioning": published.conditioning })
        }),
        "warnings": record.warnings,
    })
}

fn parameters(law: &IdentifiedLaw) -> Map<String, Value> {
    let one = |parameter: &IdentifiedParameter| {
        let [low, high] = parameter.interval.map(|end| end.is_finite().then_some(end));
        let value = json!({ "value": parameter.value, "low": low, "high": high, "unit": parameter.unit });
        (parameter.name.to_owned(), value)
    };
    law.parameters.iter().map(one).collect()
}

fn level(level: &Level) -> Value {
    let ends = |interval: &Interval| json!([interval.low, interval.high]);
    json!({
        "amplitude": level.amplitude, "frequency": level.frequency,
        "frequency_interval": level.frequency_interval.as_ref().map(ends),
        "damping_ratio": level.damping_ratio, "peak": level.peak,
        "rotational_stiffness": level.rotational_stiffness.as_ref().ok(),
        "source": words::source(&level.source),
    })
}

fn linear(record: &LinearRecord) -> Value {
    let modes = record.poles.iter().enumerate().map(|(k, pole)| {
        json!({
            "frequency": pole.frequency, "damping_ratio": pole.damping_ratio, "model": record.model.get(k),
            "residues": pole.residues.iter().map(|residue| [residue.re, residue.im]).collect::<Vec<_>>(),
        })
    });
    json!({
        "file": record.name, "rotational_stiffness": record.rotational_stiffness,
        "sensors": record.responses.iter().map(|(at, _)| at).collect::<Vec<_>>(), "modes": modes.collect::<Vec<_>>(),
    })
}
