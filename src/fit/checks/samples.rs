//! Single samples and runs of them: outliers, clipping, drop-outs, and values of too few digits.

use std::collections::BTreeSet;

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
/// Distance of an error code from all other values over their range: an impact reaches this far beyond the rest of a record, but does not
/// return to the very same number.
const CODE: f64 = 10.0;
/// Fraction of the samples that may read a code: what stands there longer is a state of the machine.
const CODED: f64 = 0.1;
/// Zeros in motion that are no chance.
const ZEROS: usize = 3;
/// Ratio of the samples before and after a lost one: more is a motion that passes through zero.
const ALIKE: f64 = 2.0;
/// Equal samples in a row that noise of a step never makes, wherever they are: each repeats the one before with a chance of 0.4.
const LONG: usize = 20;
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
        let coded = codes(channel);
        let kept: Vec<f64> = (0..values.len()).filter(|k| !coded.contains(k)).map(|k| values[k]).collect();
        let size = Size::of(&kept);
        let zeros = lost_zeros(values, &size);
        let mut add = |fault| found.push(finding(record, &channel.name, fault));
        outliers(channel, &size, &coded, &zeros).into_iter().for_each(&mut add);
        held(channel, &size, &coded, zeros).into_iter().for_each(&mut add);
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
        // A lost sample that reads zero makes two changes that are none.
        let changes = values.windows(2).filter(|pair| pair[0] != 0.0 && pair[1] != 0.0);
        let changes: Vec<f64> = changes.map(|pair| (pair[1] - pair[0]).abs()).collect();
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

/// Samples that read what a logger writes for an error or an overload: the least or the largest value, far beyond all others.
fn codes(channel: &Channel) -> BTreeSet<usize> {
    let values = &channel.values;
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let inner = values.iter().filter(|value| **value > low && **value < high);
    let [least, most] = inner.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| {
        [least.min(*value), most.max(*value)]
    });
    let far = CODE * (most - least);
    let mut all = BTreeSet::new();
    for (code, distance) in [(low, least - low), (high, high - most)] {
        let places: Vec<usize> = (0..values.len()).filter(|k| values[*k] == code).collect();
        // One sample has neighbours to be judged by, except at the ends; that of an excitation may be the blow of a hammer.
        let at_end = |k: usize| k < AROUND || k + AROUND >= values.len();
        let told = match places[..] {
            [one] => at_end(one) && channel.quantity() != "excitation",
            _ => places.len() as f64 <= CODED * values.len() as f64,
        };
        if far > 0.0 && distance > far && told {
            all.extend(places);
        }
    }
    all
}

/// The first sample that stands alone or is one of the `coded`, and how many there are.
fn outliers(
    channel: &Channel,
    size: &Size,
    coded: &BTreeSet<usize>,
    zeros: &[(usize, usize)],
) -> Option<Fault> {
    let values = &channel.values;
    let least = (CERTAIN * size.noise).max(0.05 * size.range).max(3.0 * size.step);
    let stands_alone = |i: &usize| {
        let around = (i - AROUND..=i + AROUND).filter(|k| k != i).map(|k| values[k]);
        let (low, high) =
            around.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let off = (low - values[*i]).max(values[*i] - high);
        let power = (values[*i] / cubic(values, *i)).log10();
        let of_ten =
            power.is_finite() && power.round() != 0.0 && (power - power.round()).abs() < NEAR.ln_1p();
        // Among equal samples it is these that were not measured.
        high > low && off > least && off > OUT[usize::from(!of_ten)] * (high - low)
    };
    let is_zero = |i: &usize| zeros.iter().any(|(start, length)| (*start..start + length).contains(i));
    let alone: Vec<usize> = (AROUND..values.len() - AROUND)
        .filter(|i| !coded.contains(i) && !is_zero(i) && stands_alone(i))
        .collect();
    let kept = |k: &usize| !coded.contains(k);
    let beside = |k: usize| {
        let [before, after] = [(0..k).rev().find(kept), (k + 1..values.len()).find(kept)];
        let both: Vec<f64> = [before, after].into_iter().flatten().map(|k| values[k]).collect();
        both.iter().sum::<f64>() / both.len() as f64
    };
    let mut all = coded.clone();
    all.extend(alone.iter().filter(|_| alone.len() <= FEW));
    let &sample = all.first()?;
    let expected = if coded.is_empty() { cubic(values, sample) } else { beside(sample) };
    Some(Fault::Outlier { sample, value: values[sample], expected, unit: channel.unit, count: all.len() })
}

/// Start and length of runs of zeros, too short to be held, between samples that are far from zero and like each other; none where they may
/// be chance.
fn lost_zeros(values: &[f64], size: &Size) -> Vec<(usize, usize)> {
    let far = (CERTAIN * size.noise).max(3.0 * size.change).max(0.05 * size.range);
    let (mut lost, mut start) = (Vec::new(), 0);
    for run in values.chunk_by(|a, b| a == b) {
        let next = start + run.len();
        if run[0] == 0.0 && run.len() < RUN && start > 0 && next < values.len() {
            let (before, after) = (values[start - 1], values[next]);
            let ratio = before / after;
            if before.abs().min(after.abs()) > far && (1.0 / ALIKE..ALIKE).contains(&ratio) {
                lost.push((start, run.len()));
            }
        }
        start = next;
    }
    if lost.len() >= ZEROS { lost } else { Vec::new() }
}

/// What a cubic through the neighbours says of sample `i`.
fn cubic(values: &[f64], i: usize) -> f64 {
    (4.0 * (values[i - 1] + values[i + 1]) - values[i - 2] - values[i + 2]) / 6.0
}

/// Runs of equal samples in a channel whose noise would keep them from being equal, and `zeros` that were lost.
fn held(channel: &Channel, size: &Size, coded: &BTreeSet<usize>, zeros: Vec<(usize, usize)>) -> Vec<Fault> {
    let values = &channel.values;
    let mut found = Vec::new();
    let mut lost = zeros;
    if size.noise >= QUIET * size.largest && size.noise >= 0.5 * size.step {
        let (fault, within) = runs(channel, coded);
        found.extend(fault);
        let jump = (CERTAIN * size.noise).max(3.0 * size.change);
        let moves = ["displacement", "velocity", "acceleration"].contains(&channel.quantity());
        let is_lost = |(start, length): &(usize, usize)| {
            let inside = *start > 0 && start + length < values.len();
            let never = moves && inside && *length >= LONG && size.noise > size.step;
            never || jumps(values, *start, *length) > jump
        };
        let runs: Vec<(usize, usize)> = within.into_iter().filter(is_lost).collect();
        if runs.len() > 1 || count(&runs) > RUN + 1 {
            lost.extend(runs);
        }
    }
    if let Some(first) = lost.iter().map(|(start, _)| *start).min() {
        let zero = lost.iter().all(|(start, _)| values[*start] == 0.0);
        found.push(Fault::DropOuts { count: lost.len(), first, zero });
    }
    found
}

fn count(runs: &[(usize, usize)]) -> usize {
    runs.iter().map(|(_, length)| length).sum()
}

/// Whether the channel is clipped, and start and length of the runs that are not at its ends.
fn runs(channel: &Channel, coded: &BTreeSet<usize>) -> (Option<Fault>, Vec<(usize, usize)>) {
    let values = &channel.values;
    let kept = (0..values.len()).filter(|k| !coded.contains(k)).map(|k| values[k]);
    let (low, high) =
        kept.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let (mut at_ends, mut within, mut level) = (0, Vec::new(), f64::NAN);
    let mut start = 0;
    for run in values.chunk_by(|a, b| a == b) {
        let (value, length) = (run[0], run.len());
        if coded.contains(&start) {
            // Told as outliers.
        } else if length >= RUN && (value == low || value == high) && value != 0.0 {
            at_ends += length;
            level = value;
        } else if length >= RUN {
            within.push((start, length));
        }
        start += length;
    }
    // Of a coarse channel samples repeat each other everywhere.
    let clipped = at_ends >= CLIPPED && at_ends > 5 * count(&within);
    let fraction = at_ends as f64 / values.len() as f64;
    (clipped.then_some(Fault::Clipping { level, unit: channel.unit, fraction }), within)
}

/// How far values jump where a run begins or ends.
fn jumps(values: &[f64], start: usize, length: usize) -> f64 {
    let jump = |place: Option<&f64>| place.map_or(0.0, |beside| (beside - values[start]).abs());
    let before = start.checked_sub(1).and_then(|place| values.get(place));
    jump(before).max(jump(values.get(start + length)))
}
