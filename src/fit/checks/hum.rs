//! A line at the frequency of the mains that the excitation does not make.

use super::{Fault, Finding, finding};
use crate::data::Record;
use crate::fit::residual::{drive, lines};

/// Frequencies of the mains (Hz), and how far they wander.
const MAINS: [f64; 2] = [50.0, 60.0];
const WANDERS: f64 = 0.2;
/// Lengths of the shortest line, in resolutions.
const BROAD: f64 = 0.5;
/// Amplitudes of both halves of a record differ by less: what rings does not stay.
const STEADY: f64 = 0.3;

pub(super) fn of(record: &Record, found: &mut Vec<Finding>) {
    let Some(step) = record.sample_step() else { return };
    for channel in &record.channels {
        if channel.quantity() == "time" || drive(record, channel).is_none_or(|one| one.name == channel.name) {
            continue;
        }
        let values = &channel.values;
        let resolution = 1.0 / (step * values.len() as f64);
        let is_mains = |frequency: f64| {
            MAINS.iter().any(|mains| (frequency - mains).abs() < WANDERS + BROAD * resolution)
        };
        let Some(line) = lines(record, channel).into_iter().find(|line| is_mains(line.frequency)) else {
            continue;
        };
        let [first, second] = [&values[..values.len() / 2], &values[values.len() / 2..]]
            .map(|half| amplitude(half, line.frequency * step));
        if (first - second).abs() < STEADY * first.max(second) {
            let (frequency, amplitude, unit) = (line.frequency, line.amplitude, channel.unit);
            found.push(finding(record, &channel.name, Fault::MainsHum { frequency, amplitude, unit }));
        }
    }
}

/// The larger amplitude of the lines at 50 and 60 Hz, whether the mains make it or not.
pub(super) fn at_mains(values: &[f64], step: f64) -> f64 {
    MAINS.iter().map(|mains| amplitude(values, mains * step)).fold(0.0, f64::max)
}

/// Amplitude of the sine of so many periods a sample, under a Hann window.
fn amplitude(values: &[f64], periods: f64) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let (mut along, mut across) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let window = 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / count).cos();
        let (sin, cos) = (std::f64::consts::TAU * periods * k as f64).sin_cos();
        along += window * (value - mean) * cos;
        across += window * (value - mean) * sin;
    }
    4.0 * along.hypot(across) / count
}
