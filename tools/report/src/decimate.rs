//! Fewer points for a plot without losing what it must show.

use std::ops::Range;

/// Indices of at most about `limit` samples that keep, in every stretch of the record, the smallest
/// and the largest value of each of `columns`; first and last sample always. All indices where the
/// record is short enough. Non-finite values are never an extreme.
pub fn keep_extremes(columns: &[&[f64]], length: usize, limit: usize) -> Vec<usize> {
    if length <= limit || columns.is_empty() {
        return (0..length).collect();
    }
    let buckets = (limit / (2 * columns.len())).max(1);
    let mut kept = vec![0, length - 1];
    for bucket in 0..buckets {
        let range = bucket * length / buckets..(bucket + 1) * length / buckets;
        for column in columns {
            let finite = || range.clone().filter(|&i| column.get(i).is_some_and(|v| v.is_finite()));
            kept.extend(finite().min_by(|&a, &b| column[a].total_cmp(&column[b])));
            kept.extend(finite().max_by(|&a, &b| column[a].total_cmp(&column[b])));
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Samples per cycle of `motion`, from its upward crossings of the middle with a dead band of a tenth
/// of its range on either side against noise; `None` with fewer than two cycles.
pub fn samples_per_cycle(motion: &[f64]) -> Option<usize> {
    let finite = || motion.iter().copied().filter(|v| v.is_finite());
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let (middle, band) = (0.5 * (low + high), 0.1 * (high - low));
    let (mut below, mut crossings, mut first, mut last) = (false, 0_usize, 0, 0);
    for (i, &value) in motion.iter().enumerate() {
        if value < middle - band {
            below = true;
        } else if below && value > middle + band {
            below = false;
            crossings += 1;
            if crossings == 1 {
                first = i;
            }
            last = i;
        }
    }
    (crossings >= 3).then(|| (last - first) / (crossings - 1)).filter(|&samples| samples > 0)
}

/// The stretch of about `cycles` cycles of `motion` in which `residual` has the largest mean square,
/// and every how many samples to draw it so that it has at most `limit` points. The whole record
/// where it is short or has no cycles.
pub fn worst_cycles(motion: &[f64], residual: &[f64], cycles: usize, limit: usize) -> (Range<usize>, usize) {
    let length = motion.len().min(residual.len());
    let whole = (0..length, length.div_ceil(limit.max(1)).max(1));
    if length <= limit {
        return whole;
    }
    let Some(period) = samples_per_cycle(&motion[..length]) else { return whole };
    let width = (cycles * period + 1).min(length);
    let mut sums = Vec::with_capacity(length + 1);
    sums.push(0.0);
    for value in &residual[..length] {
        let square = if value.is_finite() { value * value } else { 0.0 };
        sums.push(sums[sums.len() - 1] + square);
    }
    let start = (0..=length - width)
        .step_by((period / 4).max(1))
        .max_by(|&a, &b| (sums[a + width] - sums[a]).total_cmp(&(sums[b + width] - sums[b])))
        .unwrap_or(0);
    (start..start + width, width.div_ceil(limit.max(1)).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn decimation_keeps_the_global_extremes_and_the_limit() {
        let mut values: Vec<f64> = (0..15_000).map(|i| (f64::from(i) * 0.01).sin()).collect();
        values[7_777] = 9.0;
        values[3_210] = -9.0;
        values[12] = f64::NAN;
        let kept = keep_extremes(&[&values], values.len(), 2_000);
        assert!(kept.len() <= 2_002);
        for index in [0, 3_210, 7_777, 14_999] {
            assert!(kept.contains(&index), "{index}");
        }
        assert!(!kept.contains(&12));
        assert!(kept.is_sorted());
    }

    #[test]
    fn a_short_record_is_kept_whole() {
        assert_eq!(keep_extremes(&[&[1.0, 2.0]], 2, 2_000), [0, 1]);
        assert_eq!(keep_extremes(&[], 3, 2_000), [0, 1, 2]);
        assert!(keep_extremes(&[&[]], 0, 2_000).is_empty());
    }

    #[test]
    fn the_cycles_shown_are_those_with_the_largest_residual() {
        let motion: Vec<f64> = (0..20_000).map(|i| (TAU * f64::from(i) / 500.0).sin()).collect();
        let residual: Vec<f64> =
            (0..20_000).map(|i| if (12_000..12_500).contains(&i) { 1.0 } else { 0.1 }).collect();
        let (range, stride) = worst_cycles(&motion, &residual, 3, 1_000);
        assert!(range.start <= 12_000 && range.end >= 12_500, "{range:?}");
        assert!((1_495..=1_506).contains(&range.len()), "{range:?}");
        assert_eq!(stride, 2);
    }

    #[test]
    fn motion_without_cycles_is_shown_whole() {
        let motion: Vec<f64> = (0..9_000).map(f64::from).collect();
        assert_eq!(worst_cycles(&motion, &motion, 3, 1_000), (0..9_000, 9));
        assert_eq!(worst_cycles(&[], &[], 3, 1_000), (0..0, 1));
    }
}
