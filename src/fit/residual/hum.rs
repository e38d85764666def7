//! Lines of a residual's spectrum that stand alone, at the same frequency in several records, and are no harmonics of what
//! drives them.

use super::Compared;
use super::abscissae::drive;
use crate::data::Regime;
use crate::numeric::spectrum::hann_lines;

/// Lines on either side that a line must stand out of, and of those the ones that belong to it.
const AROUND: usize = 24;
const ITSELF: usize = 3;
/// Power over the median and over the largest around it. Of noise, the first exceeds 40 once in 10¹² lines.
const OVER: [f64; 2] = [40.0, 5.0];
/// Lines of a record at most.
const MOST: usize = 3;
/// Frequency of the excitation, in lines, from which its harmonics stand apart from each other: below it no line of a steady
/// state, which may resound in any of them, is told from them.
const APART: f64 = 6.0;
/// Amplitude over the largest from which a line drives.
const DRIVEN: f64 = 1e-2;
/// Distance of a frequency from another, in lines, at which the two are one.
const SAME: f64 = 1.5;

/// A line of the spectrum of a residual.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Name of the channel.
    pub channel: String,
    /// Frequency (Hz).
    pub frequency: f64,
    /// Amplitude in `unit`: the median of the records.
    pub amplitude: f64,
    /// Unit of the channel.
    pub unit: &'static str,
    /// Records that show it, of how many.
    pub records: [usize; 2],
}

/// A line of one record.
struct Found {
    record: usize,
    frequency: f64,
    amplitude: f64,
    /// Distance of two lines (Hz).
    resolution: f64,
}

/// Lines that two records show, or the only one.
pub(super) fn of(all: &[Compared], unit: &'static str) -> Vec<Line> {
    let mut found: Vec<Found> =
        all.iter().enumerate().flat_map(|(record, one)| of_record(one, record).unwrap_or_default()).collect();
    let mut lines = Vec::new();
    while !found.is_empty() {
        let like =
            |a: &Found, b: &Found| (a.frequency - b.frequency).abs() < SAME * a.resolution.max(b.resolution);
        let alike = |a: &&Found| found.iter().filter(|b| like(a, b)).count();
        let Some(first) = found.iter().max_by_key(alike) else { break };
        let (same, others): (Vec<usize>, Vec<usize>) =
            (0..found.len()).partition(|k| like(first, &found[*k]));
        let mut records: Vec<usize> = same.iter().map(|k| found[*k].record).collect();
        records.dedup();
        if records.len() >= all.len().min(2) {
            let weight = |k: &usize| found[*k].resolution.powi(-2);
            let weights: f64 = same.iter().map(weight).sum();
            let frequency = same.iter().map(|k| weight(k) * found[*k].frequency).sum::<f64>() / weights;
            let mut amplitudes: Vec<f64> = same.iter().map(|k| found[*k].amplitude).collect();
            amplitudes.sort_by(f64::total_cmp);
            let amplitude = amplitudes[amplitudes.len() / 2];
            let records = [records.len(), all.len()];
            lines.push(Line { channel: all[0].name.to_owned(), frequency, amplitude, unit, records });
        }
        let mut place = 0;
        found.retain(|_| {
            place += 1;
            others.contains(&(place - 1))
        });
    }
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    lines
}

fn of_record(one: &Compared, record: usize) -> Option<Vec<Found>> {
    let step = one.record.sample_step()?;
    let lines = amplitudes(&one.lacks)?;
    let resolution = 1.0 / (step * one.lacks.len() as f64);
    let driven = one.record.channel(one.name).and_then(|channel| drive(one.record, channel));
    let driven = driven.and_then(|channel| amplitudes(&channel.values)).unwrap_or_default();
    let largest = driven.iter().copied().fold(0.0, f64::max);
    let fundamental = fundamental(&driven, largest);
    let apart = fundamental.is_none_or(|first| first >= APART);
    if !apart && one.record.regime == Regime::Steady {
        return None;
    }
    let is_driven = |k: usize| {
        let near = driven.get(k - ITSELF..=(k + ITSELF).min(driven.len().saturating_sub(1)));
        let in_it = near.is_some_and(|near| near.iter().any(|x| *x > DRIVEN * largest));
        in_it || apart && fundamental.is_some_and(|first| is_harmonic(peak(&lines, k).0, first))
    };
    let mut found: Vec<Found> = (ITSELF + 1..lines.len().saturating_sub(ITSELF + 1))
        .filter(|&k| stands_alone(&lines, k) && !is_driven(k))
        .map(|k| {
            let (place, amplitude) = peak(&lines, k);
            Found { record, frequency: place * resolution, amplitude, resolution }
        })
        .collect();
    found.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    found.truncate(MOST);
    Some(found)
}

/// Place of the line of which what drives has harmonics: the lowest that stands alone, if the largest is a harmonic of it, as
/// with several tones; else the largest. `None` where nothing drives.
fn fundamental(driven: &[f64], largest: f64) -> Option<f64> {
    let top = driven.iter().position(|x| *x == largest).filter(|_| largest > 0.0)?;
    let is_tone = |k: &usize| driven[*k] > DRIVEN * largest && stands_alone(driven, *k);
    let lowest = (ITSELF + 1..top.saturating_sub(ITSELF)).find(is_tone).map(|k| peak(driven, k).0);
    let top = peak(driven, top).0;
    let common = lowest.filter(|lowest| is_harmonic(top, *lowest));
    Some(common.unwrap_or(top))
}

/// Whether the line at `place` is a harmonic of that at `first`.
fn is_harmonic(place: f64, first: f64) -> bool {
    (place - (place / first).round() * first).abs() < SAME
}

/// Whether line `k` is a peak far above all around it.
fn stands_alone(lines: &[f64], k: usize) -> bool {
    let range = k.saturating_sub(AROUND).max(1)..(k + AROUND + 1).min(lines.len());
    let own = k - ITSELF..=k + ITSELF;
    if lines[own.clone()].iter().any(|x| *x > lines[k]) {
        return false;
    }
    let mut around: Vec<f64> = range.filter(|i| !own.contains(i)).map(|i| lines[i].powi(2)).collect();
    around.sort_by(f64::total_cmp);
    let (Some(largest), power) = (around.last(), lines[k].powi(2)) else { return false };
    power > OVER[0] * around[around.len() / 2] && power > OVER[1] * largest
}

/// Place and height of the sine that makes a peak at line `k`, under a Hann window.
fn peak(lines: &[f64], k: usize) -> (f64, f64) {
    let at = |i: usize| lines.get(i).copied().unwrap_or(0.0);
    let (before, here, after) = (at(k.wrapping_sub(1)), at(k), at(k + 1));
    // The ratio of two lines of one sine is (1 + d)/(2 − d), d towards the larger.
    let (side, sign) = if after >= before { (after, 1.0) } else { (before, -1.0) };
    let ratio = side / here;
    let d = ((2.0 * ratio - 1.0) / (ratio + 1.0)).clamp(-0.5, 0.5);
    let angle = std::f64::consts::PI * d;
    let sinc = if d.abs() < 1e-9 { 1.0 } else { angle.sin() / angle };
    (k as f64 + sign * d, here * (1.0 - d * d) / sinc)
}

/// Amplitudes of the lines from 0 to the Nyquist frequency, the mean removed, under a Hann window; `None` where there are few.
fn amplitudes(values: &[f64]) -> Option<Vec<f64>> {
    let lines = (values.len() >= 4 * AROUND).then(|| hann_lines(values))??;
    Some(lines.iter().map(|line| line.norm()).collect())
}
