//! The noise as far as it is known: stated, from repeated periods, from repeated records, or taken from records in which
//! it was measured. Otherwise it is unknown.

use rayon::prelude::*;

use super::cycles::{Cycles, SAME, driver};
use super::seen::Seen;
use super::weighted_dataset::RecordResiduals;
use crate::data::{Channel, Dataset, Record, Regime};
use crate::diagnose::diagnosis::{Noise, NoiseSource};
use crate::fit::predict::{compared, white_noise};
use crate::model::Model;

/// The noise of every channel that `model` predicts of every record of `dataset`, as far as it is stated or
/// repeated periods or records show it.
pub fn noise_of(model: &Model, dataset: &Dataset) -> Vec<Noise> {
    let lane = |record| {
        let mut lane = RecordResiduals::empty(record, None);
        for channel in compared(model, record) {
            let start = lane.measured.len();
            lane.measured.extend_from_slice(&channel.values);
            lane.weights.extend(record.weights(channel));
            lane.channels.push((channel.name.as_str(), start..lane.measured.len()));
        }
        lane
    };
    measure(&dataset.records.iter().map(lane).collect::<Vec<_>>())
}

/// Noise of every compared channel of every record, in the order of `lanes`.
pub(in crate::diagnose) fn measure(lanes: &[RecordResiduals]) -> Vec<Noise> {
    let of_record = |(record, lane): (usize, &RecordResiduals)| {
        let of_channel = |(name, range): &(&str, std::ops::Range<usize>)| {
            let stated = lane.record.channel(name).and_then(|channel| lane.record.stated_noise(channel));
            let stated = stated.filter(|noise| *noise > 0.0);
            let (seen, source) = match stated {
                Some(noise) => (Some(Seen { deviation: noise, log_error: 0.0 }), NoiseSource::Stated),
                None => seen(lanes, record, name, &lane.measured[range.clone()]),
            };
            let (deviation, log_error) = (seen.map(|s| s.deviation), seen.map_or(0.0, |s| s.log_error));
            Noise { record, channel: (*name).to_owned(), deviation, log_error, source }
        };
        lane.channels.iter().map(of_channel).collect::<Vec<_>>()
    };
    let mut found: Vec<Noise> = lanes.par_iter().enumerate().flat_map_iter(of_record).collect();
    carry_over(lanes, &mut found);
    found
}

/// From the record itself, or from another of the same motion.
fn seen(lanes: &[RecordResiduals], record: usize, name: &str, values: &[f64]) -> (Option<Seen>, NoiseSource) {
    let whole = lanes[record].record;
    let Some(drive) = driver(whole) else { return (None, NoiseSource::Unknown) };
    // A structure goes on swinging when its excitation repeats already.
    let repeats = drive.quantity() == "displacement" || whole.regime == Regime::Steady;
    if let Some(cycles) = Cycles::of(drive).filter(|_| repeats)
        && cycles.inputs_repeat(lanes[record].record)
        && let Some(seen) = cycles.noise(values)
    {
        return (Some(seen), NoiseSource::Periods);
    }
    let repeats = lanes
        .iter()
        .enumerate()
        .filter(|(other, lane)| *other != record && is_repeat(lane.record, lanes[record].record));
    let differences: Vec<Vec<f64>> = repeats
        .filter_map(|(_, lane)| lane.record.channel(name))
        .map(|other| other.values.iter().zip(values).map(|(a, b)| a - b).collect::<Vec<_>>())
        // The same file twice says nothing of the noise.
        .filter(|apart| apart.iter().any(|difference| *difference != 0.0))
        .collect();
    let Some(one) = differences.first() else { return (None, NoiseSource::Unknown) };
    let square = |apart: &Vec<f64>| apart.iter().map(|x| x * x).sum::<f64>() / (2.0 * values.len() as f64);
    let mean = differences.iter().map(square).sum::<f64>() / differences.len() as f64;
    let mut seen = Seen::of(mean.sqrt(), one, values.len() / 10);
    // Few values, or what does not die away, are known no better than independent ones.
    seen.log_error = seen.log_error.max((2.0 * one.len() as f64).sqrt().recip());
    (Some(seen), NoiseSource::Repeats)
}

/// Two other inputs are: a measured load has its own noise.
const ALIKE: f64 = 0.02;

/// Whether two records are one experiment done twice: the same regime and sampling, drive and all other inputs.
fn is_repeat(a: &Record, b: &Record) -> bool {
    let sampling = match (a.sample_step(), b.sample_step()) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-3 * a,
        (None, None) => true,
        _ => false,
    };
    let others = |record: &Record| -> Vec<usize> {
        let is = |c: &Channel| c.name.starts_with("normal_") || c.quantity() == "excitation";
        (0..record.channels.len()).filter(|index| is(&record.channels[*index])).collect()
    };
    let inputs = |record: &Record, of: &Record| {
        others(record).into_iter().all(|index| {
            let input = &record.channels[index];
            of.channel(&input.name).is_some_and(|other| alike(&input.values, &other.values))
        })
    };
    let drives = match (driver(a), driver(b)) {
        (Some(a), Some(b)) => a.name == b.name && same(&a.values, &b.values),
        _ => false,
    };
    a.regime == b.regime && sampling && drives && inputs(a, b) && inputs(b, a)
}

/// Whether two motions are one, about their means: a sensor's zero is no part of a motion.
fn same(a: &[f64], b: &[f64]) -> bool {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let size: f64 = a.iter().map(|x| (x - mean_a).powi(2)).sum();
    let apart: f64 = a.iter().zip(b).map(|(x, y)| (x - mean_a - y + mean_b).powi(2)).sum();
    let shift = (mean_a - mean_b).powi(2) * a.len() as f64;
    a.len() == b.len() && apart < SAME * SAME * size && shift < 0.01 * size
}

/// Whether two inputs are one, their size included.
fn alike(a: &[f64], b: &[f64]) -> bool {
    let size: f64 = a.iter().map(|x| x * x).sum();
    let apart: f64 = a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum();
    a.len() == b.len() && (apart < ALIKE * ALIKE * size || apart == 0.0)
}

/// What the noise of a channel is proportional to from record to record.
const LAWS: [fn(&[f64]) -> f64; 3] = [|_| 1.0, root_mean_square, white_noise];

pub(in crate::diagnose) fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

/// Spread of the logarithm below which a law is taken to hold exactly, and single records' deviations from it
/// for their own uncertainty; or this many times that uncertainty, where noise with a long memory makes it larger.
const EXACT: f64 = 0.1;
const BY_CHANCE: f64 = 1.5;

/// Gives channels without a noise that of the same quantity elsewhere, by the law that holds best where the
/// noise was seen: one size, one fraction of the channel's root mean square, or one fraction of its high
/// frequencies. Where the law holds to within the standard error of the single estimates these are replaced by it. The
/// disagreement of the laws that hold as well, and their scatter, tell how well the noise of a record without an estimate of
/// its own is known.
fn carry_over(lanes: &[RecordResiduals], found: &mut [Noise]) {
    let values = |noise: &Noise| {
        let lane = &lanes[noise.record];
        let range =
            lane.channels.iter().find(|(name, _)| *name == noise.channel).map(|(_, range)| range.clone());
        &lane.measured[range.unwrap_or(0..0)]
    };
    let mut names: Vec<String> = found.iter().map(|noise| noise.channel.clone()).collect();
    names.sort();
    names.dedup();
    for name in names {
        let measured: Vec<(f64, [f64; 3])> = found
            .iter()
            .filter(|noise| noise.channel == name)
            .filter_map(|noise| Some((noise.deviation?, LAWS.map(|law| law(values(noise))))))
            .collect();
        if measured.is_empty() {
            continue;
        }
        let own = found.iter().filter(|noise| noise.channel == name && noise.deviation.is_some());
        let log_error = root_mean_square(&own.map(|noise| noise.log_error).collect::<Vec<_>>());
        let exact = EXACT.max(BY_CHANCE * log_error);
        let fits = (0..LAWS.len()).map(|law| {
            let logarithms: Vec<f64> =
                measured.iter().map(|(noise, sizes)| (noise / sizes[law]).ln()).collect();
            let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
            let variance =
                logarithms.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / logarithms.len() as f64;
            // The square of a deviation by few values is right on average; its logarithm is too small by as much.
            (law, mean + log_error * log_error, variance.sqrt())
        });
        let fits: Vec<(usize, f64, f64)> = fits.filter(|fit| fit.1.is_finite()).collect();
        let Some(&(law, mean, spread)) = fits.iter().min_by(|a, b| a.2.total_cmp(&b.2)) else { continue };
        for noise in found.iter_mut().filter(|noise| noise.channel == name) {
            let carried = mean.exp() * LAWS[law](values(noise));
            let usable = carried.is_finite() && carried > 0.0;
            match noise.source {
                NoiseSource::Unknown if usable => {
                    let alike = fits.iter().filter(|fit| fit.2 <= exact.max(spread));
                    let others = alike.map(|(law, mean, _)| mean.exp() * LAWS[*law](values(noise)));
                    let apart = others.map(|other| (other / carried).ln().abs()).filter(|x| x.is_finite());
                    noise.log_error = apart.fold(spread.hypot(log_error), f64::max);
                    (noise.deviation, noise.source) = (Some(carried), NoiseSource::Carried);
                }
                NoiseSource::Periods | NoiseSource::Repeats if usable && spread < exact => {
                    noise.deviation = Some(carried);
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::seen::samples::{coloured, normal};
    use super::*;

    /// The standard error of a deviation is its spread from record to record, white noise or not.
    #[test]
    fn the_standard_error_of_a_deviation_is_its_scatter() {
        for memory in [0.0, 0.8, 0.95] {
            let seen: Vec<Seen> = (0..200)
                .map(|seed| {
                    let apart = coloured(seed, memory, 400);
                    Seen::of(root_mean_square(&apart), &apart, 70)
                })
                .collect();
            let logarithms: Vec<f64> = seen.iter().map(|seen| seen.deviation.ln()).collect();
            let mean = logarithms.iter().sum::<f64>() / 200.0;
            let spread = (logarithms.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 200.0).sqrt();
            let log_error = root_mean_square(&seen.iter().map(|seen| seen.log_error).collect::<Vec<_>>());
            assert!(
                (log_error / spread - 1.0).abs() < 0.25,
                "memory {memory}: {log_error} instead of {spread}"
            );
        }
    }

    /// Few values tell a square that is right on average; what is carried over from several is, too.
    #[test]
    fn what_records_have_in_common_is_right_on_average() {
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let record = Record {
            name: "r".into(),
            regime: crate::data::Regime::FromRest,
            use_for: None,
            channels: vec![channel("force", "N", vec![0.0; 4])],
        };
        let mut lane = RecordResiduals::empty(&record, None);
        lane.measured = vec![1.0, -1.0, 1.0, -1.0];
        lane.channels.push(("force", 0..4));
        let lanes = vec![lane; 8];
        const FREEDOM: u64 = 12;
        let told = |seed: u64| {
            let mut noise = normal(seed);
            let mut deviation =
                || ((0..FREEDOM).map(|_| noise().powi(2)).sum::<f64>() / FREEDOM as f64).sqrt();
            let one = |record| Noise {
                record,
                channel: "force".to_owned(),
                deviation: Some(deviation()),
                log_error: (0.5 / FREEDOM as f64).sqrt(),
                source: NoiseSource::Periods,
            };
            let mut found: Vec<Noise> = (0..8).map(one).collect();
            carry_over(&lanes, &mut found);
            found.iter().map(|noise| noise.deviation.unwrap().powi(2)).sum::<f64>() / 8.0
        };
        let mean = (0..3000).map(told).sum::<f64>() / 3000.0;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
    }

    /// The noise of a channel that records of one `drive` show.
    fn noise(regime: Regime, drive: (&str, &[f64]), name: &'static str, shown: &[Vec<f64>]) -> Vec<Noise> {
        let channel = |name: &str, values: &[f64]| Channel {
            name: name.into(),
            unit: "",
            values: values.to_vec(),
            noise: None,
        };
        let record = |shown: &Vec<f64>| {
            let time: Vec<f64> = (0..shown.len()).map(|i| 1e-3 * i as f64).collect();
            let channels = vec![channel("time", &time), channel(drive.0, drive.1), channel(name, shown)];
            Record { name: "r".into(), regime, use_for: None, channels }
        };
        let records: Vec<Record> = shown.iter().map(record).collect();
        let lane = |(record, shown): (_, &Vec<f64>)| {
            let mut lane = RecordResiduals::empty(record, None);
            lane.measured.clone_from(shown);
            lane.channels.push((name, 0..shown.len()));
            lane
        };
        measure(&records.iter().zip(shown).map(lane).collect::<Vec<_>>())
    }

    #[test]
    fn a_structure_that_swings_in_from_rest_shows_no_noise_by_its_periods() {
        let mut noisy = normal(4);
        let angle = |i: i32| std::f64::consts::TAU * f64::from(i) / 50.0;
        let drive: Vec<f64> = (0..1000).map(|i| angle(i).sin()).collect();
        // Free vibration at another frequency, damped by half a percent, dies away beside what the excitation does.
        let free = |i: i32| (-0.005 * 1.3 * angle(i)).exp() * (1.3 * angle(i)).cos();
        let shown: Vec<f64> = (0..1000).map(|i| angle(i).cos() - free(i) + 0.01 * noisy()).collect();
        let of = |regime, shown| {
            noise(regime, ("excitation:m1", &drive), "acceleration:m1", &[shown]).swap_remove(0)
        };
        assert_eq!(of(Regime::FromRest, shown).source, NoiseSource::Unknown);
        let steady: Vec<f64> = (0..1000).map(|i| angle(i).cos() + 0.01 * noisy()).collect();
        let found = of(Regime::Steady, steady);
        assert_eq!(found.source, NoiseSource::Periods);
        assert!((found.deviation.unwrap() / 0.01).ln().abs() < 0.2, "{found:?}");
    }

    #[test]
    fn few_repeated_values_tell_no_exact_noise() {
        let mut noisy = normal(5);
        for seed in 0..20 {
            let ramp: Vec<f64> = (0..8).map(|i| f64::from(i * i + seed)).collect();
            let mut shown = || ramp.iter().map(|x| x + 0.1 * noisy()).collect();
            let pair = [shown(), shown()];
            for found in noise(Regime::FromRest, ("displacement", &ramp), "force", &pair) {
                assert_eq!(found.source, NoiseSource::Repeats);
                assert!(found.log_error >= 0.25, "{found:?}");
            }
        }
    }

    #[test]
    fn a_drift_is_no_noise_with_a_memory() {
        let drift: Vec<f64> = (0..400).map(|i| f64::from(i) / 400.0).collect();
        assert_eq!(Seen::of(0.5, &drift, 70).log_error, 0.0);
    }
}
