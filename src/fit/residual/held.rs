//! Samples that repeat each other while noise is around them: a channel that is at its end, or one that is lost.

use super::{Compared, Hint};
use crate::fit::predict::white_noise;

/// Equal samples in a row that are no chance.
const RUN: usize = 3;
/// Fewest samples held at the ends of a channel.
const CLIPPED: usize = 10;
/// Size of a residual within a run, over the median of all, from which the run is no rest.
const OFF: f64 = 6.0;
/// White noise over the channel's largest value below which samples may well be equal.
const QUIET: f64 = 1e-4;

/// Equal samples in a row of a record.
struct Run {
    value: f64,
    length: usize,
    /// Whether nothing in its record lies beyond it.
    at_end: bool,
    /// The largest residual within it.
    off: f64,
}

/// What is held in their channel.
pub(super) fn of(all: &[Compared], unit: &'static str) -> Vec<Hint> {
    let noisy: Vec<&Compared> = all.iter().filter(|one| is_noisy(one)).collect();
    let runs: Vec<Run> = noisy.iter().flat_map(|one| runs(one)).collect();
    let samples = noisy.iter().map(|one| one.measured.len()).sum::<usize>().max(1);
    let mut sizes: Vec<f64> = noisy.iter().flat_map(|one| one.lacks.iter().map(|x| x.abs())).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let count = |of: &[&Run]| of.iter().map(|run| run.length).sum::<usize>();
    let ends: Vec<&Run> = runs.iter().filter(|run| run.at_end && run.value != 0.0).collect();
    let within: Vec<&Run> = runs.iter().filter(|run| !run.at_end || run.value == 0.0).collect();
    let mut found = Vec::new();
    // Of a coarse channel samples repeat each other everywhere.
    if count(&ends) >= CLIPPED && count(&ends) > 5 * count(&within) {
        let mut levels: Vec<f64> = ends.iter().map(|run| run.value).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        let fraction = count(&ends) as f64 / samples as f64;
        let outer = [levels[0], levels[levels.len() - 1]];
        let levels = if levels.len() > 1 { outer.to_vec() } else { levels };
        found.push(Hint::Clipping { channel: (all[0].name.to_owned(), unit), levels, fraction });
    }
    let lost: Vec<&Run> = within.into_iter().filter(|run| run.off > OFF * median).collect();
    if lost.len() > 1 {
        found.push(Hint::DropOuts {
            channel: all[0].name.to_owned(),
            count: lost.len(),
            samples: count(&lost),
            zero: lost.iter().all(|run| run.value == 0.0),
        });
    }
    found
}

/// Whether noise would keep samples from repeating each other.
fn is_noisy(one: &Compared) -> bool {
    let largest = one.measured.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    white_noise(&one.lacks) > QUIET * largest
}

fn runs(one: &Compared) -> Vec<Run> {
    let low = one.measured.iter().copied().fold(f64::INFINITY, f64::min);
    let high = one.measured.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mut runs, mut start) = (Vec::new(), 0);
    while start < one.measured.len() {
        let value = one.measured[start];
        let length = one.measured[start..].iter().take_while(|x| **x == value).count();
        if length >= RUN {
            let off = one.lacks[start..start + length].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            runs.push(Run { value, length, at_end: value == low || value == high, off });
        }
        start += length;
    }
    runs
}
