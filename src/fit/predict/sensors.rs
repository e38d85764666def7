//! What faulty sensors show of a prediction.

use std::f64::consts::TAU;

use nalgebra::Complex;
use realfft::RealFftPlanner;

use crate::data::{Channel, Record, Regime};
use crate::effects::SensorFault;
use crate::model::Model;

/// The fault of `channel` under `model`, if it has one.
pub(crate) fn fault(model: &Model, channel: &Channel) -> Option<SensorFault> {
    if model.effects.is_empty() {
        return None;
    }
    model.changes().sensors.into_iter().find(|fault| fault.channel == channel.name)
}

/// Turns the true motion `values` of `channel` into what the model's faulty sensors show of it.
///
/// A steady record is late by the phases of its harmonics. Elsewhere a delay is linear between samples, and the first
/// and the last value last. With `delayed` false the values are late already.
pub(crate) fn apply(model: &Model, record: &Record, channel: &Channel, delayed: bool, values: &mut [f64]) {
    let Some(fault) = fault(model, channel) else { return };
    if delayed
        && fault.delay != 0.0
        && let Some(step) = record.sample_step()
    {
        delay(values, fault.delay / step, record.regime == Regime::Steady);
    }
    for value in values {
        *value = fault.gain * *value + fault.bias;
    }
}

/// Moves `values` later by `samples`, which need not be whole.
fn delay(values: &mut [f64], samples: f64, periodic: bool) {
    if periodic {
        turn(values, samples);
        return;
    }
    let original = values.to_vec();
    let last = original.len() as i64 - 1;
    let (whole, part) = (samples.floor(), samples - samples.floor());
    let at = |index: i64| original[index.clamp(0, last) as usize];
    for (index, value) in values.iter_mut().enumerate() {
        let index = index as i64 - whole as i64;
        *value = (1.0 - part) * at(index) + part * at(index - 1);
    }
}

/// As [`delay`], of values that the first follows: every line of their spectrum keeps its size.
fn turn(values: &mut [f64], samples: f64) {
    let count = values.len();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (planner.plan_fft_forward(count), planner.plan_fft_inverse(count));
    let mut spectrum = forward.make_output_vec();
    if count < 2 || forward.process(values, &mut spectrum).is_err() {
        return;
    }
    for (line, value) in spectrum.iter_mut().enumerate() {
        *value *= Complex::from_polar(1.0 / count as f64, -TAU * line as f64 * samples / count as f64);
    }
    // What lies at half the sampling rate has no phase.
    spectrum[0].im = 0.0;
    if count.is_multiple_of(2) {
        spectrum[count / 2].im = 0.0;
    }
    let mut moved = inverse.make_output_vec();
    if inverse.process(&mut spectrum, &mut moved).is_ok() {
        values.copy_from_slice(&moved);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::delay;

    #[test]
    fn a_late_line_lies_lower_by_its_slope() {
        for samples in [0.0, 0.3, 2.0, 2.75, -1.5] {
            let mut values: Vec<f64> = (0..20).map(f64::from).collect();
            delay(&mut values, samples, false);
            for (index, value) in values.iter().enumerate().skip(4).take(12) {
                assert!((value - (index as f64 - samples)).abs() < 1e-12, "{samples}: {value}");
            }
        }
    }

    #[test]
    fn a_periodic_record_comes_round() {
        let mut values = vec![0.0, 1.0, 2.0, 3.0];
        delay(&mut values, 1.0, true);
        for (value, expected) in values.iter().zip([3.0, 0.0, 1.0, 2.0]) {
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
        }
    }

    #[test]
    fn a_late_wave_of_a_periodic_record_keeps_its_height() {
        for (count, samples) in [(64, 0.37), (63, -2.6)] {
            let wave = |at: f64| 0.4 + (TAU * 9.0 * at / f64::from(count)).cos();
            let mut values: Vec<f64> = (0..count).map(|index| wave(f64::from(index))).collect();
            delay(&mut values, samples, true);
            for (index, value) in (0..).zip(&values) {
                assert!((value - wave(f64::from(index) - samples)).abs() < 1e-12, "{index}: {value}");
            }
        }
    }
}
