//! Smooth motions from noisy samples: what drives a simulation must not bring the sensor's noise with it.
//!
//! Local cubics (Savitzky & Golay 1964) of the width with the least mean square error, what they flatten and what noise they
//! leave together (Mallows 1973): a wider one would make amplitudes too small, and whatever is fitted to them too
//! large. Samples without noise stay as they are.

use std::f64::consts::PI;

/// Half-widths tried (samples), widest last.
const HALF_WIDTHS: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// A measured motion and its rate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Motion {
    /// Values with the noise reduced.
    pub values: Vec<f64>,
    /// Time derivative (unit/s).
    pub rates: Vec<f64>,
}

/// Standard deviation of white noise on smooth `values`, from fourth differences and their median, so that
/// single corners do not count. Coloured noise is underestimated; values without noise have none.
pub(crate) fn white_noise(values: &[f64]) -> f64 {
    of_differences(values, 4, 1, 0.5).unwrap_or(0.0)
}

/// Standard deviation that white noise would have to make the fourth differences of `values` over so many samples; `None`
/// where they are not those of noise.
pub(crate) fn noise_over(values: &[f64], spacing: usize) -> Option<f64> {
    of_differences(values, 4, spacing, 0.9 * sign_changes(4))
}

/// As [`white_noise`], on `values` of a few samples a period, too, whose own fourth differences hide it: from the first higher
/// ones that change their sign as those of noise do.
pub(crate) fn white_noise_of_few(values: &[f64]) -> f64 {
    let higher = |order: &usize| of_differences(values, *order, 1, 0.9 * sign_changes(*order));
    of_differences(values, 4, 1, 0.5).or_else(|| [6, 8, 10, 12].iter().find_map(higher)).unwrap_or(0.0)
}

/// Part of the differences of white noise that have another sign than their neighbour: the correlation of the two is
/// −d/(d + 1) for those of order d.
fn sign_changes(order: usize) -> f64 {
    (-(order as f64) / (order + 1) as f64).acos() / PI
}

/// Standard deviation of white noise from the median of differences of an even `order` over `spacing` samples; `None` where no
/// more than the part `least` of them change their sign: those of noise do nearly every time, those of a smooth curve twice a
/// period.
fn of_differences(values: &[f64], order: usize, spacing: usize, least: f64) -> Option<f64> {
    let mut differences = values.to_vec();
    for _ in 0..order {
        let left = differences.len().saturating_sub(spacing);
        (0..left).for_each(|k| differences[k] = differences[k + spacing] - differences[k]);
        differences.truncate(left);
    }
    let neighbours = differences.iter().zip(differences.iter().skip(spacing));
    let changes = neighbours.filter(|(one, next)| *one * *next < 0.0).count();
    if changes as f64 <= least * differences.len() as f64 {
        return None;
    }
    differences.iter_mut().for_each(|difference| *difference = difference.abs());
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    // The median of a normal variable's magnitude is 0.6745 σ; squares of binomial coefficients add to the middle one.
    let squares: f64 = (1..=order).map(|k| (order + k) as f64 / k as f64).product();
    Some(*median / 0.674_489_75 / squares.sqrt())
}

/// How a motion goes on outside of its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Outside {
    /// It stood still before, and goes on at the rate that it has at the end.
    StillBefore,
    /// At the rate that it has at the end.
    Straight,
    /// As so many samples later or earlier.
    Periodic(f64),
}

impl Motion {
    /// What was there at `place(index)` (in samples, not always whole) for each of the samples, which are `step` seconds
    /// apart.
    pub fn at(&self, place: impl Fn(usize) -> f64, step: f64, outside: Outside) -> Self {
        let last = self.values.len().saturating_sub(1) as f64;
        let at = |index: usize| {
            let mut place = place(index);
            if let Outside::Periodic(period) = outside {
                // A whole period from the nearer end: where noise was smoothed, ends are smoothed least.
                place += if place < 0.0 { period } else { 0.0 };
                place -= if place > last { period } else { 0.0 };
            }
            let inside = place.clamp(0.0, last);
            if outside == Outside::StillBefore && place < 0.0 {
                return (self.values[0], 0.0);
            }
            let (value, rate) = self.between(inside, step);
            (value + rate * (place - inside) * step, rate)
        };
        let (values, rates) = (0..self.values.len()).map(at).unzip();
        Self { values, rates }
    }

    /// Value and rate at a place between two samples: Hermite's cubic, and a line between the rates.
    fn between(&self, place: f64, step: f64) -> (f64, f64) {
        let left = place as usize;
        let right = (left + 1).min(self.values.len() - 1);
        let t = place - left as f64;
        let [a, b] = [left, right].map(|index| (self.values[index], self.rates[index]));
        let change = b.0 - a.0;
        let bends = [step * a.1 - change, change - step * b.1];
        let value = a.0 + t * change + t * (1.0 - t) * ((1.0 - t) * bends[0] + t * bends[1]);
        (value, (1.0 - t) * a.1 + t * b.1)
    }

    /// From evenly spaced samples every `step` seconds.
    pub fn even(values: &[f64], step: f64) -> Self {
        let half = half_width(values);
        let smoothed = if half > 1 { values_smoothed(values, half) } else { values.to_vec() };
        Self { values: smoothed, rates: rates(values, half, step) }
    }

    /// From samples at any times: as they are, with central differences.
    pub fn uneven(values: &[f64], time: &[f64]) -> Self {
        let last = values.len().saturating_sub(1);
        let rate = |index: usize| {
            let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
            let span = time[after] - time[before];
            if span > 0.0 { (values[after] - values[before]) / span } else { 0.0 }
        };
        Self { values: values.to_vec(), rates: (0..values.len()).map(rate).collect() }
    }
}

/// Evenly spaced `values` read at `place(index)` (in samples, not always whole) for each of them.
///
/// Between samples on the cubic through the four nearest (Lagrange): a sine of `n` samples per period is read to
/// (3/128) (2π/n)⁴ of its amplitude, 2e-4 at 20 samples, where straight lines err by (2π/n)²/8, 1e-2, and would make
/// the reading smaller than the sine. Before the first sample the first value lasts; beyond the last two the line
/// through them goes on.
pub(crate) fn read_at(values: &[f64], place: impl Fn(usize) -> f64) -> Vec<f64> {
    let Some(last) = values.len().checked_sub(1) else { return Vec::new() };
    let at = |index: usize| {
        let place = place(index).max(0.0);
        if last < 3 || place >= last as f64 {
            let left = (place as usize).min(last.saturating_sub(1));
            let change = values[(left + 1).min(last)] - values[left];
            return values[left] + (place - left as f64) * change;
        }
        let first = (place as usize).saturating_sub(1).min(last - 3);
        let t = place - first as f64;
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| values[first + k]);
        let outer = (t - 1.0) * (t - 2.0) * (t * d - (t - 3.0) * a) / 6.0;
        outer + t * (t - 3.0) * ((t - 2.0) * b - (t - 1.0) * c) / 2.0
    };
    (0..values.len()).map(at).collect()
}

/// The window with the least mean square error.
fn half_width(values: &[f64]) -> usize {
    let noise = white_noise(values);
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    if noise <= 1e-12 * largest {
        return HALF_WIDTHS[0];
    }
    // As they are, the samples err by their noise.
    let mut best = (HALF_WIDTHS[0], noise * noise);
    for half in HALF_WIDTHS.into_iter().skip(1).take_while(|half| values.len() >= 4 * half) {
        let smoothed = values_smoothed(values, half);
        let inner = half..values.len() - half;
        let change =
            inner.clone().map(|i| (values[i] - smoothed[i]).powi(2)).sum::<f64>() / inner.len() as f64;
        // A smoothed value keeps this fraction of its own sample's noise, and of its variance.
        let (s0, s2, s4, _) = moments(half);
        let kept = s4 / (s0 * s4 - s2 * s2);
        let error = change - noise * noise * (1.0 - 2.0 * kept);
        if error < best.1 {
            best = (half, error);
        }
    }
    best.0
}

/// Sums of the powers 0, 2, 4, 6 of −half..=half.
type Moments = (f64, f64, f64, f64);

fn moments(half: usize) -> Moments {
    let n = half as f64;
    let squares = n * (n + 1.0) * (2.0 * n + 1.0) / 3.0;
    let fourth = squares * (3.0 * n * n + 3.0 * n - 1.0) / 5.0;
    let sixth = squares * (3.0 * n.powi(4) + 6.0 * n.powi(3) - 3.0 * n + 1.0) / 7.0;
    (2.0 * n + 1.0, squares, fourth, sixth)
}

fn values_smoothed(values: &[f64], half: usize) -> Vec<f64> {
    let weight = |(s0, s2, s4, _): Moments, k: f64| (s4 - s2 * k * k) / (s0 * s4 - s2 * s2);
    local_cubics(values, half, 1.0, weight, |index| values[index])
}

fn rates(values: &[f64], half: usize, step: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let weight = |(_, s2, s4, s6): Moments, k: f64| k * (s6 - s4 * k * k) / (s2 * s6 - s4 * s4) / step;
    local_cubics(values, half, -1.0, weight, |index| {
        let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
        (values[after] - values[before]) / (step * (after - before).max(1) as f64)
    })
}

/// What a local cubic says at every sample: the sum of its neighbours so many samples away, those before it times `sign`, under
/// their `weight`. Narrower towards the ends, where there is nothing on one side, and what `few` says where no cubic fits.
fn local_cubics(
    values: &[f64],
    half: usize,
    sign: f64,
    weight: impl Fn(Moments, f64) -> f64,
    few: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let count = values.len();
    let at_end = |index: usize| {
        let half = half.min(index).min(count - 1 - index);
        if half < 2 {
            return few(index);
        }
        let moments = moments(half);
        let pair = |k: usize| weight(moments, k as f64) * (values[index + k] + sign * values[index - k]);
        weight(moments, 0.0) * values[index] + (1..=half).map(pair).sum::<f64>()
    };
    if half < 2 || count <= 2 * half {
        return (0..count).map(at_end).collect();
    }
    let moments = moments(half);
    let middle = weight(moments, 0.0);
    let mut found: Vec<f64> = values.iter().map(|value| middle * value).collect();
    for k in 1..=half {
        let weight = weight(moments, k as f64);
        let neighbours = values[half + k..].iter().zip(&values[half - k..]);
        for (found, (after, before)) in found[half..count - half].iter_mut().zip(neighbours) {
            *found += weight * (after + sign * before);
        }
    }
    (0..half).chain(count - half..count).for_each(|index| found[index] = at_end(index));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn noise(index: usize) -> f64 {
        // Sum of uniform numbers from a hash: near enough to a normal variable of deviation one.
        let hash = |salt: u64| {
            let mut x =
                (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ salt.wrapping_mul(0xbf58_476d_1ce4_e5b9);
            x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (x ^ (x >> 31)) as f64 / u64::MAX as f64
        };
        (1..=12).map(hash).sum::<f64>() - 6.0
    }

    #[test]
    fn moments_are_the_sums_of_even_powers() {
        for half in 0..=HALF_WIDTHS[HALF_WIDTHS.len() - 1] {
            let sum = |power: i32| (1..=half).map(|k| 2.0 * (k as f64).powi(power)).sum::<f64>();
            assert_eq!(moments(half), (1.0 + sum(0), sum(2), sum(4), sum(6)), "{half}");
        }
    }

    #[test]
    fn a_cubic_is_its_own_smoothing_and_keeps_its_rate() {
        let cubic = |x: f64| 1.0 + 2.0 * x - 0.3 * x * x + 0.01 * x * x * x;
        let values: Vec<f64> = (0..40).map(|i| cubic(i as f64 * 0.5)).collect();
        let smoothed = values_smoothed(&values, 4);
        let rates = rates(&values, 4, 0.5);
        for i in 4..36 {
            let x = i as f64 * 0.5;
            assert!((smoothed[i] - values[i]).abs() < 1e-10);
            assert!((rates[i] - (2.0 - 0.6 * x + 0.03 * x * x)).abs() < 1e-10);
        }
    }

    #[test]
    fn noise_is_measured_on_a_sine_and_taken_off() {
        let clean = |i: usize| (TAU * i as f64 / 400.0).sin();
        let noisy: Vec<f64> = (0..1200).map(|i| clean(i) + 0.01 * noise(i)).collect();
        assert!((white_noise(&noisy) / 0.01 - 1.0).abs() < 0.1);
        let motion = Motion::even(&noisy, 1.0);
        let rms =
            |values: &mut dyn Iterator<Item = f64>| (values.map(|x| x * x).sum::<f64>() / 1200.0).sqrt();
        assert!(rms(&mut (0..1200).map(|i| motion.values[i] - clean(i))) < 0.005);
        let rate = |i: usize| TAU / 400.0 * (TAU * i as f64 / 400.0).cos();
        let plain = rms(&mut (1..1199).map(|i| 0.5 * (noisy[i + 1] - noisy[i - 1]) - rate(i)));
        assert!(rms(&mut (40..1160).map(|i| motion.rates[i] - rate(i))) < 0.05 * plain);
    }

    #[test]
    fn noise_is_measured_on_what_few_samples_describe() {
        for samples in [8.0, 12.0, 16.0, 40.0] {
            for size in [3e-3, 3e-4] {
                let wave = |i: usize| (TAU * i as f64 / samples).sin() + 0.3 * (TAU * i as f64 / 90.0).cos();
                let noisy: Vec<f64> = (0..2400).map(|i| wave(i) + size * noise(i)).collect();
                let found = white_noise_of_few(&noisy) / size;
                assert!((0.9..1.3).contains(&found), "{samples} {size}: {found}");
            }
            let clean: Vec<f64> = (0..2400).map(|i| (TAU * i as f64 / samples).sin()).collect();
            assert!(white_noise_of_few(&clean) < 1e-12, "{samples}");
        }
        // What fills a half of the band is no noise.
        let tones =
            |i: usize| (1..60).map(|k| (TAU * k as f64 / 240.0 * i as f64 + (k * k) as f64).sin()).sum();
        assert_eq!(white_noise_of_few(&(0..2400).map(tones).collect::<Vec<f64>>()), 0.0);
    }

    #[test]
    fn smoothing_takes_less_off_an_amplitude_than_a_third_of_the_noise() {
        for (samples, size) in
            [(30, 0.01), (60, 0.03), (60, 0.003), (100, 0.03), (200, 0.01), (200, 0.001), (400, 0.01)]
        {
            let clean = |i: usize| (TAU * i as f64 / f64::from(samples)).sin();
            let noisy: Vec<f64> = (0..2400).map(|i| clean(i) + size * noise(i)).collect();
            let motion = Motion::even(&noisy, 1.0);
            let along = |values: &[f64]| (0..2400).map(|i| values[i] * clean(i)).sum::<f64>() / 1200.0;
            // Of the same noise, so that only what smoothing does is seen.
            let lost = along(&noisy) - along(&motion.values);
            assert!(lost.abs() < size / 3.0, "{samples} {size}: {}", lost / size);
        }
    }

    #[test]
    fn earlier_is_the_past_of_a_motion_before_its_first_sample_too() {
        let angle = |i: f64| TAU * i / 100.0 + 0.3;
        let sine = Motion {
            values: (0..250).map(|i| angle(f64::from(i)).sin()).collect(),
            rates: (0..250).map(|i| TAU / 100.0 * angle(f64::from(i)).cos() / 0.5).collect(),
        };
        for samples in [0.0, 0.4, 7.3, -12.8] {
            let earlier = sine.at(|index| index as f64 - samples, 0.5, Outside::Periodic(100.0));
            for (i, (value, rate)) in earlier.values.iter().zip(&earlier.rates).enumerate() {
                let exact = angle(i as f64 - samples);
                assert!((value - exact.sin()).abs() < 1e-6, "{samples} {i}");
                assert!((rate - TAU / 50.0 * exact.cos()).abs() < 1e-4, "{samples} {i}");
            }
        }
        let line = Motion { values: (0..9).map(|i| 2.0 + 3.0 * f64::from(i)).collect(), rates: vec![6.0; 9] };
        let straight = line.at(|index| index as f64 - 2.5, 0.5, Outside::Straight);
        assert!(straight.values.iter().enumerate().all(|(i, v)| (v - 3.0 * i as f64 + 5.5).abs() < 1e-12));
        let still = line.at(|index| index as f64 - 2.5, 0.5, Outside::StillBefore);
        assert_eq!((still.values[1], still.rates[1]), (2.0, 0.0));
    }

    #[test]
    fn between_samples_a_cubic_is_exact_and_a_sine_errs_with_the_fourth_power_of_the_step() {
        let cubic = |x: f64| 1.0 - x + 0.4 * x * x - 0.02 * x * x * x;
        let values: Vec<f64> = (0..12).map(|i| cubic(f64::from(i))).collect();
        for (i, value) in read_at(&values, |index| 0.9 * index as f64 + 0.05).iter().enumerate() {
            assert!((value - cubic(0.9 * i as f64 + 0.05)).abs() < 1e-12, "{i}: {value}");
        }
        for n in [20.0, 80.0] {
            let wave = |x: f64| (TAU * x / n).sin();
            let values: Vec<f64> = (0..200).map(|i| wave(f64::from(i))).collect();
            let read = read_at(&values, |index| (index as f64 + 0.5).clamp(1.0, 198.0));
            let error = |i: usize| (read[i] - wave(i as f64 + 0.5)).abs();
            let largest = (1..197).map(error).fold(0.0, f64::max);
            let bound = 3.0 / 128.0 * (TAU / n).powi(4);
            assert!((0.9 * bound..=bound).contains(&largest), "{n}: {largest} {bound}");
        }
    }

    #[test]
    fn outside_of_the_record_the_first_value_lasts_and_the_last_two_go_on() {
        let values: Vec<f64> = (0..9).map(|i| f64::from(i * i)).collect();
        let read = read_at(&values, |index| 2.0 * index as f64 - 5.0);
        assert_eq!(read, [0.0, 0.0, 0.0, 1.0, 9.0, 25.0, 49.0, 79.0, 109.0]);
        assert_eq!(read_at(&[3.0], |_| 7.0), [3.0]);
    }

    #[test]
    fn corners_without_noise_stay() {
        let triangle: Vec<f64> = (0..200).map(|i| (i % 40_i32 - 20).abs() as f64).collect();
        assert_eq!(Motion::even(&triangle, 1.0).values, triangle);
    }
}
