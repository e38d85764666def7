//! Single samples and runs of them: outliers, clipping, drop-outs, and values of too few digits.

use super::{Fault, Finding, finding, largest, quantile};
use crate::data::{Channel, Record};
use crate::fit::predict::white_noise;

/// Neighbours on either side of a sample.
const AROUND: usize = 3;
/// Distance of an outlier from its neighbours over their range, where it is a power of ten off, and otherwise.
const OUT: [f64; 2] = [4.0, 20.0];
/// Standard deviations of noise that no sample of a record is off by.
const CERTAIN: f64 = 12.0;
/// More outliers than this are no accidents.
const FEW: usize = 5;
/// Relative distance from a power of ten.
const NEAR: f64 = 0.1;
/// Equal samples in a row that are no chance in noise.
const RUN: usize = 3;
/// Fewest samples held at an end.
const CLIPPED: usize = 10;
/// White noise over the channel's largest value below which samples may well be equal.
const QUIET: f64 = 1e-4;
/// A step over the standard deviation that is too coarse, and fewest values that are no levels of a switch.
const COARSE: f64 = 0.02;
const LEVELS: usize = 8;

pub(super) fn of(record: &Record, found: &mut Vec<Finding>) {
    for channel in &record.channels {
        let values = &channel.values;
        if channel.quantity() == "time" || values.len() < 4 * AROUND {
            continue;
        }
        let size = Size::of(values);
        let mut add = |fault| found.push(finding(record, &channel.name, fault));
        outliers(channel, &size).into_iter().for_each(&mut add);
        held(channel, &size).into_iter().for_each(&mut add);
        let deviation = standard_deviation(values);
        if size.distinct >= LEVELS && size.step > COARSE * deviation {
            add(Fault::Quantisation { fraction: size.step / deviation });
        }
    }
}

/// What a channel's values are like.
struct Size {
    /// Standard deviation of the white noise.
    noise: f64,
    largest: f64,
    /// Range of nearly all values.
    range: f64,
    /// How far values change from sample to sample, of nearly all.
    change: f64,
    /// Smallest distance of two values, and number of different values.
    step: f64,
    distinct: usize,
}

impl Size {
    fn of(values: &[f64]) -> Self {
        let largest = largest(values);
        let changes: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        // Numbers that differ by rounding are equal.
        sorted.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * largest);
        let step = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        Self {
            noise: white_noise(&moving(values)),
            largest,
            range: quantile(values, 0.99) - quantile(values, 0.01),
            change: quantile(&changes, 0.99),
            step: if step.is_finite() { step } else { 0.0 },
            distinct: sorted.len(),
        }
    }
}

/// The samples outside of runs of equal ones: what is held has no noise.
fn moving(values: &[f64]) -> Vec<f64> {
    values.chunk_by(|a, b| a == b).filter(|run| run.len() < RUN).flatten().copied().collect()
}

fn standard_deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// The first sample that stands alone, and how many there are.
fn outliers(channel: &Channel, size: &Size) -> Option<Fault> {
    let values = &channel.values;
    let least = (CERTAIN * size.noise).max(0.05 * size.range).max(3.0 * size.step);
    let stands_alone = |i: &usize| {
        let around = (i - AROUND..=i + AROUND).filter(|k| k != i).map(|k| values[k]);
        let (low, high) =
            around.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let off = (low - values[*i]).max(values[*i] - high);
        let power = (values[*i] / expected(values, *i)).log10();
        let of_ten =
            power.is_finite() && power.round() != 0.0 && (power - power.round()).abs() < NEAR.ln_1p();
        // Among equal samples it is these that were not measured.
        high > low && off > least && off > OUT[usize::from(!of_ten)] * (high - low)
    };
    let alone: Vec<usize> = (AROUND..values.len() - AROUND).filter(stands_alone).collect();
    let &sample = alone.first().filter(|_| alone.len() <= FEW)?;
    let (value, expected) = (values[sample], expected(values, sample));
    Some(Fault::Outlier { sample, value, expected, unit: channel.unit, count: alone.len() })
}

/// What a cubic through the neighbours says of sample `i`.
fn expected(values: &[f64], i: usize) -> f64 {
    (4.0 * (values[i - 1] + values[i + 1]) - values[i - 2] - values[i + 2]) / 6.0
}

/// Runs of equal samples in a channel whose noise would keep them from being equal.
fn held(channel: &Channel, size: &Size) -> Vec<Fault> {
    if size.noise < QUIET * size.largest || size.noise < 0.5 * size.step {
        return Vec::new();
    }
    let values = &channel.values;
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mut at_ends, mut within, mut level) = (0, Vec::new(), f64::NAN);
    let mut start = 0;
    for run in values.chunk_by(|a, b| a == b) {
        let (value, length) = (run[0], run.len());
        if length >= RUN && (value == low || value == high) && value != 0.0 {
            at_ends += length;
            level = value;
        } else if length >= RUN {
            within.push((start, length));
        }
        start += length;
    }
    let count = |runs: &[(usize, usize)]| runs.iter().map(|(_, length)| length).sum::<usize>();
    let mut found = Vec::new();
    // Of a coarse channel samples repeat each other everywhere.
    if at_ends >= CLIPPED && at_ends > 5 * count(&within) {
        let fraction = at_ends as f64 / values.len() as f64;
        found.push(Fault::Clipping { level, unit: channel.unit, fraction });
    }
    let jump = (CERTAIN * size.noise).max(3.0 * size.change);
    let lost: Vec<(usize, usize)> =
        within.into_iter().filter(|(start, length)| jumps(values, *start, *length) > jump).collect();
    if let Some((first, _)) = lost.first()
        && (lost.len() > 1 || count(&lost) > RUN + 1)
    {
        let zero = lost.iter().all(|(start, _)| values[*start] == 0.0);
        found.push(Fault::DropOuts { count: lost.len(), first: *first, zero });
    }
    found
}

/// How far values jump where a run begins or ends.
fn jumps(values: &[f64], start: usize, length: usize) -> f64 {
    let jump = |place: Option<&f64>| place.map_or(0.0, |beside| (beside - values[start]).abs());
    let before = start.checked_sub(1).and_then(|place| values.get(place));
    jump(before).max(jump(values.get(start + length)))
}
