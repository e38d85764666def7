//! What faulty sensors show of a prediction.

use crate::effects::SensorFault;
use crate::measure::{Channel, Record, Regime};
use crate::model::Model;

/// The fault of `channel` under `model`, if it has one.
pub(super) fn fault(model: &Model, channel: &Channel) -> Option<SensorFault> {
    if model.effects.is_empty() {
        return None;
    }
    model.changes().sensors.into_iter().find(|fault| fault.channel == channel.name)
}

/// Turns the true motion `values` of `channel` into what the model's faulty sensors show of it.
///
/// A delay is linear between samples. A steady record is periodic; elsewhere the first and the last value
/// last. With `delayed` false the values are late already.
pub(super) fn apply(model: &Model, record: &Record, channel: &Channel, delayed: bool, values: &mut [f64]) {
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
    let original = values.to_vec();
    let last = original.len() as i64 - 1;
    let (whole, part) = (samples.floor(), samples - samples.floor());
    let at = |index: i64| {
        let index = if periodic { index.rem_euclid(last + 1) } else { index.clamp(0, last) };
        original[index as usize]
    };
    for (index, value) in values.iter_mut().enumerate() {
        let index = index as i64 - whole as i64;
        *value = (1.0 - part) * at(index) + part * at(index - 1);
    }
}

#[cfg(test)]
mod tests {
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
        assert_eq!(values, [3.0, 0.0, 1.0, 2.0]);
    }
}
