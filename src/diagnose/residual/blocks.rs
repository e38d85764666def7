//! Scores by blocks: the gain of one model over another on records that neither was fitted to, with its standard
//! error. Blocks are longer than the residual's correlation, so that they count as independent.

use std::ops::Range;

use crate::diagnose::measurements::weighted_dataset::{Scored, WeightedDataset, mean_square};
use crate::diagnose::search::select::{PASSING_FRACTION, PASSING_Z};

/// Correlation below which samples count as independent.
const INDEPENDENT: f64 = 0.2;
/// Shortest block (samples).
const SHORTEST: usize = 8;
/// Fewest blocks that a channel of a record is cut into, where it is long enough.
const FEWEST: usize = 10;

/// What one model gains over another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) struct Gain {
    /// The gain over its standard error.
    pub z: f64,
    /// Fraction of the squared error removed.
    pub fraction: f64,
}

impl Gain {
    /// Whether it is significant and large enough to matter.
    pub fn passes(&self) -> bool {
        self.z > PASSING_Z && self.fraction > PASSING_FRACTION
    }
}

/// Length of blocks (samples) for `residuals`, one slice per record: twice the lag at which their correlation
/// has died away.
pub(in crate::diagnose) fn length<'a>(residuals: impl Iterator<Item = &'a [f64]>) -> usize {
    let series: Vec<&[f64]> = residuals.collect();
    let longest = (typical(&series) / FEWEST).max(1);
    let product = |lag: usize| product_at_lag(&series, lag);
    let power = product(0);
    let mut lag = 1;
    while lag < longest && product(lag) > INDEPENDENT * power {
        lag += 1 + lag / 8;
    }
    (2 * lag).max(SHORTEST).min(longest.max(SHORTEST))
}

/// Sum over all series of the products of values `lag` samples apart.
fn product_at_lag(series: &[&[f64]], lag: usize) -> f64 {
    series
        .iter()
        .map(|one| one.iter().zip(one.get(lag..).unwrap_or(&[])).map(|(a, b)| a * b).sum::<f64>())
        .sum()
}

/// Middle one of the lengths: a single short record does not set the measure of all.
fn typical(series: &[&[f64]]) -> usize {
    let mut lengths: Vec<usize> = series.iter().map(|one| one.len()).collect();
    lengths.sort_unstable();
    lengths.get(lengths.len().saturating_sub(1) / 2).copied().unwrap_or(0)
}

/// How many samples in a row of `residuals` count as one: the sum of their correlation until it dies away.
pub(in crate::diagnose) fn correlation<'a>(residuals: impl Iterator<Item = &'a [f64]>) -> f64 {
    let series: Vec<&[f64]> = residuals.collect();
    let longest = typical(&series) / FEWEST;
    let product = |lag: usize| product_at_lag(&series, lag);
    let power = product(0);
    let mut sum = 1.0;
    for lag in 1..longest {
        let fraction = if power > 0.0 { product(lag) / power } else { 0.0 };
        if fraction < 0.05 {
            break;
        }
        sum += 2.0 * fraction;
    }
    sum
}

/// `range` cut into blocks of about `length`.
pub(in crate::diagnose) fn within(range: Range<usize>, length: usize) -> impl Iterator<Item = Range<usize>> {
    let count = (range.len() / length.max(1)).max(1);
    let total = range.len();
    (0..count).map(move |k| range.start + k * total / count..range.start + (k + 1) * total / count)
}

/// What `with` gains over `without`; both are scores of the same records in the same order.
///
/// Of a gain `old² − new² = Δ² + 2 Δ·new` with `Δ = old − new` only the second term is chance, where `new` is what is
/// left beside the effect: that an effect shows in one stretch of a record more than in another does not make it less certain.
pub(in crate::diagnose) fn gain(bench: &WeightedDataset, without: &[Scored], with: &[Scored]) -> Gain {
    let length = length(with.iter().map(|one| one.residuals.as_slice()));
    let (mut chances, mut before, mut total) = (Vec::new(), 0.0, 0.0);
    for (old, new) in without.iter().zip(with) {
        for (_, range) in &bench.lanes[old.record].channels {
            let chance = within(range.clone(), length).map(|block| {
                let pairs = old.residuals[block.clone()].iter().zip(&new.residuals[block]);
                let (mut squares, mut product) = ([0.0, 0.0], 0.0);
                for (old, new) in pairs {
                    squares = [squares[0] + old * old, squares[1] + new * new];
                    product += 2.0 * (old - new) * new;
                }
                before += squares[0];
                total += squares[0] - squares[1];
                product
            });
            chances.push(chance.collect::<Vec<_>>());
        }
    }
    if before == 0.0 {
        return Gain { z: 0.0, fraction: 0.0 };
    }
    // In data without noise, rounding is the uncertainty.
    let error = variance_of(&chances).sqrt().max(1e-9 * before);
    Gain { z: total / error, fraction: total / before }
}

/// Standard errors by which a mean square is lowered to its lower confidence bound.
const MARGIN: f64 = 2.0;

/// The least that the mean square of the residuals of `scored` would be if they were measured again: noise with a long
/// memory has few independent values in a record, and its mean square differs from record to record.
pub(in crate::diagnose) fn least_mean_square(bench: &WeightedDataset, scored: &[Scored]) -> f64 {
    let length = length(scored.iter().map(|one| one.residuals.as_slice()));
    let square = |block: &[f64]| block.iter().map(|residual| residual * residual).sum::<f64>();
    let strata = scored.iter().flat_map(|one| {
        let channels = bench.lanes[one.record].channels.iter();
        channels.map(|(_, range)| {
            within(range.clone(), length).map(|block| square(&one.residuals[block])).collect::<Vec<_>>()
        })
    });
    let error = variance_of(&strata.collect::<Vec<_>>()).sqrt();
    let count: usize = scored.iter().map(|one| one.residuals.len()).sum();
    mean_square(scored) - MARGIN * error / count.max(1) as f64
}

/// Blocks of a channel for which the significance of its mean is tested.
const STRATUM: usize = 8;

/// Variance of a sum of independent numbers, from their differences within each stratum. Strata of few numbers are
/// taken together; a single number is its own variance.
fn variance_of(strata: &[Vec<f64>]) -> f64 {
    let spread = |values: &[f64]| -> f64 {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        match values {
            [] => 0.0,
            [one] => one * one,
            _ => count * squares / (count - 1.0),
        }
    };
    let (mut few, mut variance) = (Vec::new(), 0.0);
    for stratum in strata {
        if stratum.len() < STRATUM {
            few.extend_from_slice(stratum);
        } else {
            variance += spread(stratum);
        }
    }
    variance + spread(&few)
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
    fn the_variance_of_a_sum_is_that_within_the_records() {
        let shaken =
            |mean: f64| -> Vec<f64> { (0..10).map(|i| mean + if i % 2 == 0 { 1.0 } else { -1.0 }).collect() };
        let variance = 2.0 * 10.0 * 10.0 / 9.0;
        for [a, b] in [[5.0, 0.0], [2.5, 2.5], [4.0, 1.0]] {
            assert!((variance_of(&[shaken(a), shaken(b)]) - variance).abs() < 1e-12, "{a} {b}");
        }
        // A single number is its own variance, beside others as well; two are judged by each other.
        assert_eq!(variance_of(&[vec![3.0]]), 9.0);
        assert!((variance_of(&[shaken(5.0), vec![3.0]]) - 0.5 * variance - 9.0).abs() < 1e-12);
        assert!((variance_of(&[vec![1.0], vec![3.0]]) - 4.0).abs() < 1e-12);
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
