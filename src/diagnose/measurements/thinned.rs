//! Long records of a contact alone with fewer samples, for the many refits of the search: a contact's force
//! follows the path of the motion, which a sample far below every turn of it shows as well as all do.

use super::cycles::driver;
use crate::data::{Channel, Dataset, Record, Regime};
use crate::fit::predict::{Motion, white_noise};
use crate::model::{Model, Structure};

/// Records up to this many samples stay as they are.
const LONG: usize = 2048;
/// Fewest samples that are left of a longer one.
const LEFT: usize = 1000;
/// Largest error of the motion between the samples kept, as a fraction of its root mean square.
const STRAIGHT: f64 = 1e-3;

/// `dataset` with its long records thinned; `None` where none can be.
pub(in crate::diagnose) fn of(model: &Model, dataset: &Dataset) -> Option<Dataset> {
    if model.structure != Structure::Prescribed {
        return None;
    }
    let strides: Vec<usize> = dataset.records.iter().map(stride).collect();
    if strides.iter().all(|stride| *stride == 1) {
        return None;
    }
    let records = dataset.records.iter().zip(strides).map(|(record, stride)| every(record, stride)).collect();
    Some(Dataset { title: dataset.title.clone(), records })
}

/// One sample of how many is kept: the fewest between which the motion is straight. Whole periods stay whole
/// periods only with all their samples.
fn stride(record: &Record) -> usize {
    let Some(drive) = driver(record).filter(|drive| drive.values.len() > LONG) else { return 1 };
    if record.regime == Regime::Steady || record.regime.is_table() || record.sample_step().is_none() {
        return 1;
    }
    let motion = Motion::even(&drive.values, 1.0).values;
    let mean = motion.iter().sum::<f64>() / motion.len() as f64;
    let size = (motion.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / motion.len() as f64).sqrt();
    let allowed = (STRAIGHT * size).max(1.5 * white_noise(&drive.values));
    (2..=motion.len() / LEFT).rev().find(|stride| bend(&motion, *stride) < allowed).unwrap_or(1)
}

/// Root mean square distance of `values` from the straight lines between every `stride`-th of them.
fn bend(values: &[f64], stride: usize) -> f64 {
    let (mut square, mut count) = (0.0, 0);
    for line in values.windows(stride + 1).step_by(stride) {
        for (k, value) in line.iter().enumerate() {
            let fraction = k as f64 / stride as f64;
            square += (value - (1.0 - fraction) * line[0] - fraction * line[stride]).powi(2);
            count += 1;
        }
    }
    (square / f64::from(count.max(1))).sqrt()
}

fn every(record: &Record, stride: usize) -> Record {
    let channel = |channel: &Channel| Channel {
        values: channel.values.iter().copied().step_by(stride).collect(),
        ..channel.clone()
    };
    Record { channels: record.channels.iter().map(channel).collect(), ..record.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn record(count: usize, period: f64, regime: Regime) -> Record {
        let channel =
            |name: &str, values: Vec<f64>| Channel { name: name.into(), unit: "m", values, noise: None };
        let wave = (0..count).map(|i| (TAU * i as f64 / period).sin()).collect();
        let time = (0..count).map(|i| i as f64 * 1e-3).collect();
        let channels = vec![channel("time", time), channel("displacement", wave)];
        Record { name: "r".into(), regime, use_for: None, channels }
    }

    #[test]
    fn only_what_is_long_and_slow_is_thinned() {
        for (count, period, regime, expected) in [
            (1200, 400.0, Regime::FromRest, 1),
            (7000, 1000.0, Regime::UnknownInitialState, 7),
            (7000, 1000.0, Regime::Steady, 1),
            // Ten samples a period are too few already.
            (7000, 10.0, Regime::FromRest, 1),
        ] {
            assert_eq!(stride(&record(count, period, regime)), expected, "{count} {period} {regime:?}");
        }
    }

    #[test]
    fn the_samples_kept_are_those_of_the_record() {
        let long = record(7001, 1000.0, Regime::FromRest);
        let short = every(&long, 7);
        for (long, short) in long.channels.iter().zip(&short.channels) {
            assert!(short.values.iter().enumerate().all(|(i, value)| *value == long.values[7 * i]));
            assert_eq!(short.values.len(), 1001);
        }
    }
}
