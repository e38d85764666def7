//! Steady records in which a beam's contact, under the model, moves beyond the table of its measured law.

use std::f64::consts::TAU;

use crate::data::{Dataset, Record, Regime};
use crate::fit::checks::{BEYOND, range_of};
use crate::fit::predict::ObservedSimulation;
use crate::model::{Model, Structure};
use crate::numeric::fourier::value;

/// Steps of a period in which the ends of a motion are looked for.
const STEPS: usize = 512;

/// A sentence for each of them.
pub(super) fn notes(model: &Model, dataset: &Dataset) -> Vec<String> {
    let (Structure::Beam(_), Some(contact)) = (&model.structure, &model.contact) else { return Vec::new() };
    let Some(range) = range_of(contact, contact.normal_load) else { return Vec::new() };
    let steady = dataset.records.iter().filter(|record| record.regime == Regime::Steady);
    let note = |record: &Record| {
        let moved = moved(model, record)?;
        (moved > BEYOND * range).then(|| {
            format!(
                "in {} the contact moves by ± {:.3} µm, the table of the measured law ends at {:.3} µm: what is foretold beyond \
                 is the force at its end, which nobody has measured",
                record.name,
                1e6 * moved,
                1e6 * range
            )
        })
    };
    steady.filter_map(note).collect()
}

/// Half of what lies between the largest and the smallest displacement of the contact (m); `None` where the record
/// cannot be solved.
fn moved(model: &Model, record: &Record) -> Option<f64> {
    let mut simulation = ObservedSimulation::new(model, record).ok()?;
    let nuisances = simulation.settle(model).ok()?;
    simulation.linearise(model, &nuisances, &[], &mut Vec::new(), &mut Vec::new()).ok()?;
    let coefficients = simulation.solution()?.contact();
    let at = |k: usize| value(coefficients, TAU * k as f64 / STEPS as f64);
    let (low, high) = (0..STEPS)
        .map(at)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)));
    Some(0.5 * (high - low))
}
