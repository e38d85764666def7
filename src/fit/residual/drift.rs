//! What changes along a record or from record to record: how much larger the measurement is than its prediction.

use super::{Compared, Hint};
use crate::fit::student_quantile;

/// Fewest records that show a change along each, and from one to the next.
const FEWEST: [usize; 2] = [3, 6];
/// Root mean square of one half over that of the other beyond which its level changes, too.
const LEVEL: f64 = 1.5;
/// Probability of a change where nothing drifts, and the smallest that is worth a word.
const CHANCE: f64 = 0.005;
const SMALLEST: f64 = 0.01;

/// What drifts in their channel.
pub(super) fn of(all: &[Compared]) -> Vec<Hint> {
    let halves: Vec<f64> = all.iter().filter_map(along).collect();
    let gains: Vec<f64> = all.iter().filter_map(|one| gain(one, 0..one.lacks.len())).collect();
    let mut found = Vec::new();
    if let Some(change) = mean(&halves).filter(|change| change.abs() > SMALLEST) {
        found.push(Hint::Drift { channel: all[0].name.to_owned(), change });
    }
    if let Some(change) = over_records(&gains).filter(|change| change.abs() > SMALLEST) {
        found.push(Hint::DriftOverRecords { channel: all[0].name.to_owned(), change });
    }
    found
}

/// Of measured minus predicted on predicted, by least squares.
fn gain(one: &Compared, range: std::ops::Range<usize>) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for i in range {
        product += one.lacks[i] * one.predicted[i];
        square += one.predicted[i].powi(2);
    }
    (square > 0.0).then(|| product / square)
}

/// Change of the gain from the first half of a record to the second, where both are as loud.
fn along(one: &Compared) -> Option<f64> {
    let (half, count) = (one.lacks.len() / 2, one.lacks.len());
    let power = |range: std::ops::Range<usize>| one.predicted[range].iter().map(|x| x * x).sum::<f64>();
    let ratio = (power(0..half) / power(half..count)).sqrt();
    let steady = ratio < LEVEL && ratio > 1.0 / LEVEL;
    steady.then_some(gain(one, half..count)? - gain(one, 0..half)?)
}

/// The mean where it is not zero by Student's test.
fn mean(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let above = || student_quantile(1.0 - 0.5 * CHANCE, values.len() - 1) * (variance / count).sqrt();
    (values.len() >= FEWEST[0] && mean.abs() > above()).then_some(mean)
}

/// The change along the straight line through values in their order, where its slope is not zero by Student's test.
fn over_records(values: &[f64]) -> Option<f64> {
    let n = values.len();
    if n < FEWEST[1] {
        return None;
    }
    let (middle, mean) = (0.5 * (n as f64 - 1.0), values.iter().sum::<f64>() / n as f64);
    let spread: f64 = (0..n).map(|i| (i as f64 - middle).powi(2)).sum();
    let slope =
        values.iter().enumerate().map(|(i, y)| (i as f64 - middle) * (y - mean)).sum::<f64>() / spread;
    let left = |(i, y): (usize, &f64)| (y - mean - slope * (i as f64 - middle)).powi(2);
    let variance = values.iter().enumerate().map(left).sum::<f64>() / (n as f64 - 2.0) / spread;
    let above = student_quantile(1.0 - 0.5 * CHANCE, n - 2) * variance.sqrt();
    (slope.abs() > above).then_some(slope * (n as f64 - 1.0))
}
