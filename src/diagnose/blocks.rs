//! Scores block by block: what one model gains over another on records that neither was fitted to, with its
//! doubt. Blocks are longer than the residual's correlation, so that they count as independent.

use std::ops::Range;

use super::bench::{Bench, Scored};
use super::select::{PASSING_SHARE, PASSING_Z};

/// Correlation below which samples count as independent.
const INDEPENDENT: f64 = 0.2;
/// Shortest block (samples).
const SHORTEST: usize = 8;
/// Fewest blocks that a channel of a record is cut into, where it is long enough.
const FEWEST: usize = 10;

/// What one model gains over another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gain {
    /// Mean gain of the blocks over its standard error.
    pub z: f64,
    /// Share of the squared error removed.
    pub share: f64,
}

impl Gain {
    /// Whether it is beyond doubt and worth having.
    pub fn passes(&self) -> bool {
        self.z > PASSING_Z && self.share > PASSING_SHARE
    }
}

/// Length of blocks (samples) for `residuals`, one slice per record: twice the lag at which their correlation
/// has died away.
pub(super) fn length<'a>(residuals: impl Iterator<Item = &'a [f64]>) -> usize {
    let series: Vec<&[f64]> = residuals.collect();
    let shortest = series.iter().map(|one| one.len()).min().unwrap_or(0);
    let longest = (shortest / FEWEST).max(1);
    let product = |lag: usize| -> f64 {
        series
            .iter()
            .map(|one| one.iter().zip(one.get(lag..).unwrap_or(&[])).map(|(a, b)| a * b).sum::<f64>())
            .sum()
    };
    let power = product(0);
    let mut lag = 1;
    while lag < longest && product(lag) > INDEPENDENT * power {
        lag += 1 + lag / 8;
    }
    (2 * lag).max(SHORTEST).min(longest.max(SHORTEST))
}

/// How many samples in a row of `residuals` count as one: the sum of their correlation until it dies away.
pub(super) fn correlation<'a>(residuals: impl Iterator<Item = &'a [f64]>) -> f64 {
    let series: Vec<&[f64]> = residuals.collect();
    let longest = series.iter().map(|one| one.len()).min().unwrap_or(0) / FEWEST;
    let product = |lag: usize| -> f64 {
        series
            .iter()
            .map(|one| one.iter().zip(one.get(lag..).unwrap_or(&[])).map(|(a, b)| a * b).sum::<f64>())
            .sum()
    };
    let power = product(0);
    let mut sum = 1.0;
    for lag in 1..longest {
        let share = if power > 0.0 { product(lag) / power } else { 0.0 };
        if share < 0.05 {
            break;
        }
        sum += 2.0 * share;
    }
    sum
}

/// `range` cut into blocks of about `length`.
pub(super) fn within(range: Range<usize>, length: usize) -> impl Iterator<Item = Range<usize>> {
    let count = (range.len() / length.max(1)).max(1);
    let total = range.len();
    (0..count).map(move |k| range.start + k * total / count..range.start + (k + 1) * total / count)
}

/// What `with` gains over `without`; both are scores of the same records in the same order. What is left to chance
/// in a gain is the residual of the better model: its correlation sets the blocks.
pub(super) fn gain(bench: &Bench, without: &[Scored], with: &[Scored]) -> Gain {
    let length = length(with.iter().map(|one| one.residuals.as_slice()));
    let square =
        |residuals: &[f64], block: &Range<usize>| residuals[block.clone()].iter().map(|r| r * r).sum::<f64>();
    let (mut gains, mut before) = (Vec::new(), 0.0);
    for (old, new) in without.iter().zip(with) {
        for (_, range) in &bench.lanes[old.record].channels {
            let gained = within(range.clone(), length).map(|block| {
                let (old, new) = (square(&old.residuals, &block), square(&new.residuals, &block));
                before += old;
                old - new
            });
            gains.push(gained.collect::<Vec<_>>());
        }
    }
    let total: f64 = gains.iter().flatten().sum();
    let share = if before > 0.0 { total / before } else { 0.0 };
    Gain { z: z_of(&gains), share }
}

/// Blocks of a channel from which its own mean is told from chance.
const STRATUM: usize = 8;

/// Sum of independent numbers over its standard error, which is that of their differences within each stratum: that
/// an effect shows in one record more than in another (at a higher speed, say) is no doubt of it. Strata of few
/// numbers are taken together; zero for fewer than two.
fn z_of(strata: &[Vec<f64>]) -> f64 {
    let spread = |values: &[f64]| -> f64 {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        if count < 2.0 { 0.0 } else { count * squares / (count - 1.0) }
    };
    let (mut few, mut variance) = (Vec::new(), 0.0);
    for stratum in strata {
        if stratum.len() < STRATUM {
            few.extend_from_slice(stratum);
        } else {
            variance += spread(stratum);
        }
    }
    if few.len() == 1 {
        return 0.0;
    }
    variance += if few.is_empty() { 0.0 } else { spread(&few) };
    let total: f64 = strata.iter().flatten().sum();
    if variance > 0.0 { total / variance.sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_longer_than_the_correlation() {
        // A square wave of 40 samples is correlated over about ten.
        let slow: Vec<f64> = (0..2000).map(|i| if (i / 20) % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let chosen = length([slow.as_slice()].into_iter());
        assert!((12..40).contains(&chosen), "{chosen}");
        let quick: Vec<f64> = (0..2000).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert_eq!(length([quick.as_slice()].into_iter()), SHORTEST);
    }

    #[test]
    fn what_shows_in_one_record_only_is_no_doubt_of_it() {
        let shaken =
            |mean: f64| -> Vec<f64> { (0..10).map(|i| mean + if i % 2 == 0 { 1.0 } else { -1.0 }).collect() };
        // Both spread by the same: the sum over the root of the sum of the variances.
        let variance = 2.0 * 10.0 * 10.0 / 9.0;
        for [a, b] in [[5.0, 0.0], [2.5, 2.5], [4.0, 1.0]] {
            let z = z_of(&[shaken(a), shaken(b)]);
            assert!((z - 50.0 / f64::sqrt(variance)).abs() < 1e-12, "{a} {b}: {z}");
        }
        assert!(z_of(&[shaken(0.0), shaken(0.0)]).abs() < 1e-12);
        // A single number, or single numbers of several records, are judged by each other alone.
        assert_eq!(z_of(&[vec![3.0]]), 0.0);
        assert!((z_of(&[vec![1.0], vec![3.0]]) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn blocks_cover_a_range_once() {
        for (range, size) in [(0..100, 7), (5..6, 10), (3..40, 37), (0..10, 1)] {
            let blocks: Vec<_> = within(range.clone(), size).collect();
            assert_eq!((blocks[0].start, blocks[blocks.len() - 1].end), (range.start, range.end));
            assert!(blocks.windows(2).all(|pair| pair[0].end == pair[1].start));
        }
    }
}
