//! The noise as far as it is known: stated, from repeated periods, from repeated records, or taken from records in which
//! it was measured. Otherwise it is unknown.

use super::tone;
use super::weighted_dataset::RecordResiduals;
use crate::data::{Channel, Dataset, Record};
use crate::diagnose::diagnosis::{Noise, NoiseSource};
use crate::fit::predict::{Motion, compared, period, white_noise};
use crate::model::Model;

/// The channel that drives a record: the displacement of a contact, the first excitation of a structure.
pub(in crate::diagnose) fn driver(record: &Record) -> Option<&Channel> {
    let named = |name: &str| record.channels.iter().find(|channel| channel.quantity() == name);
    named("excitation").or_else(|| named("displacement")).or_else(|| named("amplitude"))
}

/// The noise of every channel that `model` predicts of every record of `dataset`, as far as it is stated or
/// repeated periods or records show it.
pub fn noise_of(model: &Model, dataset: &Dataset) -> Vec<Noise> {
    let lane = |record| {
        let mut lane = RecordResiduals::empty(record, None);
        for channel in compared(model, record) {
            let start = lane.measured.len();
            lane.measured.extend_from_slice(&channel.values);
            lane.channels.push((channel.name.as_str(), start..lane.measured.len()));
        }
        lane
    };
    measure(&dataset.records.iter().map(lane).collect::<Vec<_>>())
}

/// Noise of every compared channel of every record, in the order of `lanes`.
pub(in crate::diagnose) fn measure(lanes: &[RecordResiduals]) -> Vec<Noise> {
    let (mut found, mut errors_of_log) = (Vec::new(), Vec::new());
    for (record, lane) in lanes.iter().enumerate() {
        for (name, range) in &lane.channels {
            let stated =
                lane.record.channel(name).and_then(|channel| channel.noise).filter(|noise| *noise > 0.0);
            let (seen, source) = match stated {
                Some(noise) => (Some(Seen { deviation: noise, log_error: 0.0 }), NoiseSource::Stated),
                None => seen(lanes, record, name, &lane.measured[range.clone()]),
            };
            let deviation = seen.map(|seen| seen.deviation);
            found.push(Noise { record, channel: (*name).to_owned(), deviation, source });
            errors_of_log.push(seen.map_or(0.0, |seen| seen.log_error));
        }
    }
    carry_over(lanes, &mut found, &errors_of_log);
    found
}

/// A standard deviation that was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seen {
    deviation: f64,
    /// Standard error of its logarithm.
    log_error: f64,
}

impl Seen {
    /// From differences between samples that only noise makes different. Correlated noise has fewer independent
    /// values than samples.
    fn of(deviation: f64, differences: &[f64], longest: usize) -> Self {
        let product = |lag: usize| -> f64 {
            let pairs = differences.iter().zip(differences.get(lag..).unwrap_or(&[]));
            pairs.map(|(a, b)| a * b).sum()
        };
        let power = product(0);
        let correlations =
            (1..longest).map(|lag| product(lag) / power).take_while(|fraction| *fraction > DEAD);
        let (mut lags, mut together) = (0, 1.0);
        for fraction in correlations {
            lags += 1;
            together += 2.0 * fraction * fraction;
        }
        // What does not die away is a drift, and no noise.
        let is_noise = power > 0.0 && lags + 1 < longest;
        let log_error = if is_noise { (together / (2.0 * differences.len() as f64)).sqrt() } else { 0.0 };
        Self { deviation, log_error }
    }
}

/// Correlation of noise below which it has died away.
const DEAD: f64 = 0.1;

/// From the record itself, or from another of the same motion.
fn seen(lanes: &[RecordResiduals], record: usize, name: &str, values: &[f64]) -> (Option<Seen>, NoiseSource) {
    let Some(drive) = driver(lanes[record].record) else { return (None, NoiseSource::Unknown) };
    if let Some(period) = period(&drive.values)
        && inputs_repeat(lanes[record].record, period)
        && let Some(deviation) = from_periods(values, period)
    {
        let lag = period.round() as usize;
        let apart: Vec<f64> = values.iter().zip(&values[lag..]).map(|(a, b)| b - a).collect();
        return (Some(Seen::of(deviation, &apart, lag / 2)), NoiseSource::Periods);
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
    (Some(Seen::of(mean.sqrt(), one, values.len() / 10)), NoiseSource::Repeats)
}

/// Whether the other inputs repeat with the drive: a normal load that swings at its own frequency makes periods
/// differ that are no noise.
fn inputs_repeat(record: &Record, period: f64) -> bool {
    let others =
        record.channels.iter().filter(|c| c.name.starts_with("normal_") || c.quantity() == "excitation");
    others.into_iter().all(|channel| {
        let motion = Motion::even(&channel.values, 1.0).values;
        let lag = period.round() as usize;
        let mean = motion.iter().sum::<f64>() / motion.len() as f64;
        let variance = motion.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / motion.len() as f64;
        let pairs = motion.get(lag..).unwrap_or(&[]);
        let change =
            pairs.iter().zip(&motion).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / pairs.len().max(1) as f64;
        // What hardly varies at all varies by its noise.
        change < 0.02 * variance || variance < 1e-3 * mean * mean
    })
}

/// Two motions are one when they differ by less than this fraction of their size.
const SAME: f64 = 0.01;
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

/// Fraction of a variance between two periods below which that of their second halves tells that the start was still felt
/// in the first: chance does not make so much of half a period.
const FORGOTTEN: f64 = 0.25;

/// The standard deviation between periods of `period` samples. A drift that is linear over three periods
/// (wear) is taken off where it shows, and so is a tone.
fn from_periods(values: &[f64], period: f64) -> Option<f64> {
    let count = values.len() as f64;
    let whole = period.floor();
    let part = period - whole;
    let lag = whole as usize;
    // The value a period earlier lies between two samples, whose noise is averaged.
    let earlier = |index: usize, periods: usize| -> f64 {
        let back = periods as f64 * period;
        let (whole, part) = (back.floor() as usize, back - back.floor());
        let near = values[index - whole];
        if part > 1e-9 && index > whole {
            (1.0 - part) * near + part * values[index - whole - 1]
        } else {
            near
        }
    };
    let kept = |part: f64| (1.0 - part).powi(2) + part * part;
    if count < 1.5 * period || lag == 0 {
        return None;
    }
    let first = lag + 1;
    let over = |from: usize| -> Option<f64> {
        if from + lag / 2 >= values.len() {
            return None;
        }
        let square: f64 = (from..values.len()).map(|i| (values[i] - earlier(i, 1)).powi(2)).sum();
        Some(square / (values.len() - from) as f64 / (1.0 + kept(part)))
    };
    let second = (2.0 * period).ceil() as usize + 1;
    let thrice = (values.len() > second + lag / 2).then(|| {
        let square: f64 =
            (second..values.len()).map(|i| (values[i] - 2.0 * earlier(i, 1) + earlier(i, 2)).powi(2)).sum();
        let part_2 = 2.0 * period - (2.0 * period).floor();
        square / (values.len() - second) as f64 / (1.0 + 4.0 * kept(part) + kept(part_2))
    });
    // Later periods have forgotten the start; second differences do not see a drift.
    let mut variance = over(first)?;
    // Of two periods alone the first remembers how it began, which the second half of it hardly does.
    if over(second).is_none()
        && let Some(late) = over(values.len().saturating_sub(lag / 2 + 1))
        && late < FORGOTTEN * variance
    {
        variance = late;
    }
    for other in [over(second), thrice].into_iter().flatten() {
        if other < 0.8 * variance {
            variance = other;
        }
    }
    // What repeats at another frequency is no noise.
    for from in [first, second] {
        let apart: Vec<f64> = (from..values.len()).map(|i| values[i] - earlier(i, 1)).collect();
        if let Some(beside) = tone::variance_beside(&apart) {
            variance = variance.min(beside / (1.0 + kept(part)));
        }
    }
    (variance > 0.0 && variance.is_finite()).then(|| variance.sqrt())
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
/// frequencies. Where the law holds to within the standard error of the single estimates these are replaced by it.
fn carry_over(lanes: &[RecordResiduals], found: &mut [Noise], errors_of_log: &[f64]) {
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
        let own = found
            .iter()
            .zip(errors_of_log)
            .filter(|(noise, _)| noise.channel == name && noise.deviation.is_some());
        let log_error = root_mean_square(&own.map(|(_, log_error)| *log_error).collect::<Vec<_>>());
        let exact = EXACT.max(BY_CHANCE * log_error);
        let fits = (0..LAWS.len()).map(|law| {
            let logarithms: Vec<f64> =
                measured.iter().map(|(noise, sizes)| (noise / sizes[law]).ln()).collect();
            let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
            let variance =
                logarithms.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / logarithms.len() as f64;
            (law, mean, variance.sqrt())
        });
        let Some((law, mean, spread)) =
            fits.filter(|fit| fit.1.is_finite()).min_by(|a, b| a.2.total_cmp(&b.2))
        else {
            continue;
        };
        for noise in found.iter_mut().filter(|noise| noise.channel == name) {
            let carried = mean.exp() * LAWS[law](values(noise));
            let usable = carried.is_finite() && carried > 0.0;
            match noise.source {
                NoiseSource::Unknown if usable => {
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
    use super::*;

    const DEVIATION: f64 = 0.01;

    /// Normal numbers (the sum of twelve uniform ones), the same in every run.
    fn normal(seed: u64) -> impl FnMut() -> f64 {
        // A fork, since the numbers of neighbouring seeds resemble each other.
        let mut numbers = fastrand::Rng::with_seed(seed).fork();
        move || (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0
    }

    /// Two periods of a sine with white noise, on which `start` lies.
    fn two_periods(start: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut noise = normal(7);
        let value = |i: usize| (std::f64::consts::TAU * i as f64 / 600.0).sin() + start(i as f64 / 600.0);
        (0..1200).map(|i| value(i) + DEVIATION * noise()).collect()
    }

    /// The standard error of a deviation is its spread from record to record, white noise or not.
    #[test]
    fn the_standard_error_of_a_deviation_is_its_scatter() {
        for memory in [0.0_f64, 0.8, 0.95] {
            let seen: Vec<Seen> = (0..200)
                .map(|seed| {
                    let mut noise = normal(seed);
                    let mut last = noise();
                    let mut next = || {
                        last = memory * last + (1.0 - memory * memory).sqrt() * noise();
                        last
                    };
                    let apart: Vec<f64> = (0..400).map(|_| next()).collect();
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

    #[test]
    fn a_drift_is_no_noise_with_a_memory() {
        let drift: Vec<f64> = (0..400).map(|i| f64::from(i) / 400.0).collect();
        assert_eq!(Seen::of(0.5, &drift, 70).log_error, 0.0);
    }

    /// Two periods' difference is the noise, and the start that the first one still remembers is not.
    #[test]
    fn of_two_periods_the_start_of_the_first_is_no_noise() {
        for start in [0.0, 0.1, 1.0] {
            let values = two_periods(|periods| if periods < 0.4 { start } else { 0.0 });
            let found = from_periods(&values, 600.0).unwrap();
            assert!((found / DEVIATION - 1.0).abs() < 0.1, "a start of {start}: {found}");
        }
        // A difference that lasts is none of the start.
        let found =
            from_periods(&two_periods(|periods| if periods < 1.0 { 0.1 } else { 0.0 }), 600.0).unwrap();
        assert!(found > 3.0 * DEVIATION, "{found}");
    }
}
