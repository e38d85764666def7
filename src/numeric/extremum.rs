//! Largest magnitude of a trigonometric polynomial.

use std::f64::consts::TAU;

/// Finds where signals of up to a number of harmonics are largest; keeps the functions on a grid.
#[derive(Debug, Clone, Default)]
pub(crate) struct Extremum {
    harmonics: usize,
    samples: usize,
    /// `cos θ_k, sin θ_k` of the grid's half period, function after function.
    grid: Vec<f64>,
    even: Vec<f64>,
    odd: Vec<f64>,
    values: Vec<f64>,
}

/// Value and first two derivatives by the phase.
fn jet(coefficients: &[f64], phase: f64) -> [f64; 3] {
    let (sin, cos) = phase.sin_cos();
    let (mut c, mut s) = (1.0, 0.0);
    let mut sums = [coefficients.first().copied().unwrap_or(0.0), 0.0, 0.0];
    for (k, pair) in coefficients.get(1..).unwrap_or(&[]).chunks_exact(2).enumerate() {
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
        let h = (k + 1) as f64;
        let value = pair[0] * c + pair[1] * s;
        sums[0] += value;
        sums[1] += h * (pair[1] * c - pair[0] * s);
        sums[2] -= h * h * value;
    }
    sums
}

/// Value of the signal `[a0, c1, s1, …]` at a phase (rad), by one evaluation of sine and cosine.
pub(crate) fn value_at(coefficients: &[f64], phase: f64) -> f64 {
    jet(coefficients, phase)[0]
}

impl Extremum {
    fn reserve(&mut self, harmonics: usize) {
        if self.harmonics == harmonics && self.samples > 0 {
            return;
        }
        self.harmonics = harmonics;
        self.samples = (4 * harmonics).next_power_of_two().max(16);
        let half = self.samples / 2;
        self.grid.clear();
        for h in 1..=harmonics {
            let phase = |k: usize| TAU * ((h * k) % self.samples) as f64 / self.samples as f64;
            self.grid.extend((0..half).map(|k| phase(k).cos()));
            self.grid.extend((0..half).map(|k| phase(k).sin()));
        }
        self.even = vec![0.0; half];
        self.odd = vec![0.0; half];
        self.values = vec![0.0; self.samples];
    }

    /// Phase (rad) and magnitude where the signal `[a0, c1, s1, …]` is largest.
    pub fn of(&mut self, coefficients: &[f64]) -> (f64, f64) {
        let harmonics = coefficients.len() / 2;
        self.reserve(harmonics);
        self.sample(coefficients);
        let n = self.samples;
        let step = TAU / n as f64;
        let best = self.values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if best == 0.0 || !best.is_finite() {
            return (0.0, best);
        }
        // Between samples the signal is higher by no more than ½ |x''| (step/2)².
        let pairs = coefficients.get(1..).unwrap_or(&[]).chunks_exact(2).enumerate();
        let curvature: f64 = pairs.map(|(k, p)| ((k + 1) * (k + 1)) as f64 * (p[0].abs() + p[1].abs())).sum();
        let floor = best - 0.125 * curvature * step * step;
        let mut found = (0.0, 0.0);
        for k in 0..n {
            let here = self.values[k].abs();
            let (left, right) = (self.values[(k + n - 1) % n], self.values[(k + 1) % n]);
            if here >= floor && here >= left.abs() && here > right.abs() {
                let candidate = climb(coefficients, k as f64 * step, step);
                if candidate.1 > found.1 * (1.0 + 1e-14) {
                    found = candidate;
                }
            }
        }
        if found.1 < best {
            let k = self.values.iter().position(|x| x.abs() == best).unwrap_or(0);
            found = (k as f64 * step, best);
        }
        found
    }

    /// Phase where the signal has its known largest `magnitude`; near `guess`, if it is there.
    pub fn phase_of(&mut self, coefficients: &[f64], magnitude: f64, guess: f64) -> f64 {
        const REACH: f64 = 0.2;
        let (phase, found) = climb(coefficients, guess, REACH);
        if (found - magnitude).abs() <= 1e-12 * magnitude { phase } else { self.of(coefficients).0 }
    }

    /// Values on the grid: harmonics even and odd in half a period share the sums.
    fn sample(&mut self, coefficients: &[f64]) {
        let half = self.samples / 2;
        self.even.fill(coefficients.first().copied().unwrap_or(0.0));
        self.odd.fill(0.0);
        for (m, c) in coefficients.iter().enumerate().skip(1) {
            if *c != 0.0 {
                let target = if m.div_ceil(2) % 2 == 0 { &mut self.even } else { &mut self.odd };
                let function = &self.grid[(m - 1) * half..m * half];
                target.iter_mut().zip(function).for_each(|(t, f)| *t += c * f);
            }
        }
        let (first, second) = self.values.split_at_mut(half);
        for (k, (even, odd)) in self.even.iter().zip(&self.odd).enumerate() {
            first[k] = even + odd;
            second[k] = even - odd;
        }
    }
}

/// Newton's method on the slope from the highest sample, kept within a step of it.
fn climb(coefficients: &[f64], start: f64, step: f64) -> (f64, f64) {
    let mut phase = start;
    let mut value = jet(coefficients, phase);
    for _ in 0..12 {
        // On the way up the magnitude's second derivative is negative; where it is not, go along the slope.
        let bent = value[2] * value[0] < 0.0;
        let ahead = if bent { -value[1] / value[2] } else { 0.25 * step * (value[1] * value[0]).signum() };
        let next = (phase + ahead).clamp(start - step, start + step);
        let moved = (next - phase).abs();
        phase = next;
        value = jet(coefficients, phase);
        if moved < 1e-9 {
            break;
        }
    }
    (phase, value[0].abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_magnitude_is_no_less_than_any_value() {
        let mut extremum = Extremum::default();
        let mut numbers = fastrand::Rng::with_seed(1);
        let mut random = || numbers.f64() - 0.5;
        for harmonics in [1, 3, 7, 20] {
            for _ in 0..20 {
                let coefficients: Vec<f64> =
                    (0..2 * harmonics + 1).map(|m| random() / (1.0 + (m / 2) as f64)).collect();
                let (phase, magnitude) = extremum.of(&coefficients);
                assert!((value_at(&coefficients, phase).abs() - magnitude).abs() < 1e-14);
                let fine = (0..20_000).map(|k| value_at(&coefficients, TAU * k as f64 / 2e4).abs());
                let sampled = fine.fold(0.0, f64::max);
                assert!(magnitude >= sampled * (1.0 - 1e-14), "{harmonics}: {magnitude} {sampled}");
                assert!(magnitude <= sampled * (1.0 + 1e-4), "{harmonics}: {magnitude} {sampled}");
            }
        }
    }

    #[test]
    fn a_single_harmonic_peaks_at_its_phase() {
        let (phase, magnitude) = Extremum::default().of(&[0.0, 3.0, 4.0]);
        assert!((magnitude - 5.0).abs() < 1e-14);
        assert!((phase.tan() - 4.0 / 3.0).abs() < 1e-8);
        assert_eq!(Extremum::default().of(&[-2.0]).1, 2.0);
        // A guess leads there from near and from afar, to one of the two.
        for guess in [0.9, 2.4, 5.0] {
            let phase = Extremum::default().phase_of(&[0.0, 3.0, 4.0], 5.0, guess);
            assert!((phase.tan() - 4.0 / 3.0).abs() < 1e-8, "{guess}");
        }
    }
}
