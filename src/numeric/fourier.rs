//! Fourier coefficients of periodic signals.
//!
//! A signal with harmonics `0..=H` is the slice `[a0, c1, s1, …, cH, sH]` of `2H + 1` numbers:
//! `x(θ) = a0 + Σ c_h cos hθ + s_h sin hθ` with the phase `θ = Ω t`.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};
use realfft::{ComplexToReal, RealFftPlanner};

/// Number of coefficients of a signal with harmonics `0..=harmonics`.
pub const fn coefficient_count(harmonics: usize) -> usize {
    2 * harmonics + 1
}

/// Value of the signal at `phase` (rad).
pub fn value(coefficients: &[f64], phase: f64) -> f64 {
    harmonics_of(coefficients).fold(coefficients.first().copied().unwrap_or(0.0), |sum, (h, c, s)| {
        let (sin, cos) = (h * phase).sin_cos();
        sum + c * cos + s * sin
    })
}

/// Coefficients of the signal's time derivative of order `order`, for the fundamental angular frequency
/// `angular_frequency` (rad/s).
pub fn time_derivative(coefficients: &[f64], order: usize, angular_frequency: f64) -> Vec<f64> {
    let mut derivative = coefficients.to_vec();
    for _ in 0..order {
        let before = derivative.clone();
        differentiate(&before, &mut derivative);
        derivative.iter_mut().for_each(|value| *value *= angular_frequency);
    }
    derivative
}

/// Coefficients `0..=harmonics` of equally spaced `samples` that span `periods` whole periods (the
/// sample after the last would repeat the first). Fitting and projecting are the same on such a grid
/// as long as `harmonics · periods < samples.len() / 2`; harmonics beyond that come out as zero.
pub fn from_samples(samples: &[f64], periods: usize, harmonics: usize) -> Vec<f64> {
    let mut coefficients = vec![0.0; coefficient_count(harmonics)];
    let count = samples.len();
    if count == 0 {
        return coefficients;
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(count);
    let (mut input, mut spectrum) = (samples.to_vec(), transform.make_output_vec());
    // Lengths are those of the transform: it cannot fail.
    let _ = transform.process(&mut input, &mut spectrum);
    let fraction = 1.0 / count as f64;
    coefficients[0] = fraction * spectrum[0].re;
    let seen = (1..=harmonics).take_while(|h| 2 * h * periods < count);
    for (h, pair) in seen.zip(coefficients[1..].chunks_exact_mut(2)) {
        let line = spectrum[h * periods];
        (pair[0], pair[1]) = (2.0 * fraction * line.re, -2.0 * fraction * line.im);
    }
    coefficients
}

/// Appends to `out` the equally spaced samples of the signal over `periods` whole periods, as many as `inverse`, a
/// transform planned once, makes. Of harmonics above half the samples of a period they show the alias.
pub(crate) fn to_samples(
    coefficients: &[f64],
    periods: usize,
    inverse: &dyn ComplexToReal<f64>,
    out: &mut Vec<f64>,
) {
    let count = inverse.len();
    let mut spectrum = inverse.make_input_vec();
    spectrum[0].re = coefficients.first().copied().unwrap_or(0.0);
    for (h, c, s) in harmonics_of(coefficients) {
        let line = (h as usize * periods) % count;
        match line.min(count - line) {
            // A sine has no value at any sample.
            low if low == 0 || 2 * low == count => spectrum[low].re += c,
            low if low == line => spectrum[low] += Complex::new(0.5 * c, -0.5 * s),
            low => spectrum[low] += Complex::new(0.5 * c, 0.5 * s),
        }
    }
    let start = out.len();
    out.resize(start + count, 0.0);
    // Lengths are those of the transform and the lines without a phase are real: nothing can fail.
    let _ = inverse.process(&mut spectrum, &mut out[start..]);
}

/// Sine and cosine at `count` equal steps round the circle.
fn circle(count: usize) -> Vec<(f64, f64)> {
    (0..count).map(|k| (TAU * k as f64 / count as f64).sin_cos()).collect()
}

/// `(h, c_h, s_h)` for `h ≥ 1`.
fn harmonics_of(coefficients: &[f64]) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
    let pairs = coefficients.get(1..).unwrap_or(&[]).chunks_exact(2);
    pairs.enumerate().map(|(k, pair)| ((k + 1) as f64, pair[0], pair[1]))
}

/// Work of a force over one cycle, `∮ T u' dθ = π Σ h (T_c,h u_s,h − T_s,h u_c,h)`, exact for whatever
/// harmonics both signals have.
pub(crate) fn work_per_cycle(force: &[f64], displacement: &[f64]) -> f64 {
    let pairs = harmonics_of(force).zip(harmonics_of(displacement));
    std::f64::consts::PI * pairs.map(|((h, tc, ts), (_, uc, us))| h * (tc * us - ts * uc)).sum::<f64>()
}

/// The functions `1, cos θ, sin θ, …` on an equally spaced grid of one period.
#[derive(Debug, Clone)]
pub(crate) struct Basis {
    /// `(2H+1) × N`: column `k` holds every function at sample `k`.
    pub at_samples: DMatrix<f64>,
    /// `N × (2H+1)`: `xᵀ · projection` are the coefficients of the samples `x`.
    pub projection: DMatrix<f64>,
}

impl Basis {
    pub fn new(harmonics: usize, samples: usize) -> Self {
        let count = coefficient_count(harmonics);
        let circle = circle(samples);
        let mut at_samples = DMatrix::zeros(count, samples);
        let mut projection = DMatrix::zeros(samples, count);
        for k in 0..samples {
            at_samples[(0, k)] = 1.0;
            projection[(k, 0)] = 1.0 / samples as f64;
            for h in 1..=harmonics {
                let (sin, cos) = circle[(h * k) % samples];
                at_samples[(2 * h - 1, k)] = cos;
                at_samples[(2 * h, k)] = sin;
                projection[(k, 2 * h - 1)] = 2.0 * cos / samples as f64;
                projection[(k, 2 * h)] = 2.0 * sin / samples as f64;
            }
        }
        Self { at_samples, projection }
    }

    /// The functions at sample `k`.
    pub fn functions(&self, k: usize) -> &[f64] {
        let count = self.at_samples.nrows();
        &self.at_samples.as_slice()[k * count..(k + 1) * count]
    }

    /// Values of the signal at every sample.
    pub fn evaluate(&self, coefficients: &[f64], out: &mut [f64]) {
        for (k, x) in out.iter_mut().enumerate() {
            *x = dot(self.functions(k), coefficients);
        }
    }

    /// Coefficients of the samples.
    pub fn project(&self, samples: &[f64], out: &mut [f64]) {
        let count = samples.len();
        for (c, column) in out.iter_mut().zip(self.projection.as_slice().chunks_exact(count)) {
            *c = dot(column, samples);
        }
    }
}

/// Writes `∂x/∂θ`.
pub(crate) fn differentiate(coefficients: &[f64], out: &mut [f64]) {
    out[0] = 0.0;
    for h in 1..=coefficients.len() / 2 {
        out[2 * h - 1] = h as f64 * coefficients[2 * h];
        out[2 * h] = -(h as f64) * coefficients[2 * h - 1];
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_inverts_evaluation() {
        let coefficients = [0.3, -1.0, 2.0, 0.5, -0.7];
        let basis = Basis::new(2, 16);
        let mut samples = [0.0; 16];
        basis.evaluate(&coefficients, &mut samples);
        let mut back = [0.0; 5];
        basis.project(&samples, &mut back);
        for (a, b) in coefficients.iter().zip(&back) {
            assert!((a - b).abs() < 1e-15);
        }
        let twice: Vec<f64> = samples.iter().chain(&samples).copied().collect();
        for (a, b) in coefficients.iter().zip(from_samples(&twice, 2, 2)) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    #[test]
    fn samples_are_those_of_the_signal_and_its_aliases() {
        let coefficients = [0.3, -1.0, 2.0, 0.5, -0.7, 0.2, 0.9, -0.4, 1.1, 0.6, -0.8];
        for (count, periods) in [(64, 3), (15, 3), (8, 2), (9, 1), (5, 1), (4, 2), (2, 1), (1, 1)] {
            let inverse = RealFftPlanner::new().plan_fft_inverse(count);
            let mut samples = vec![7.0];
            to_samples(&coefficients, periods, &*inverse, &mut samples);
            assert_eq!(samples.len(), 1 + count);
            for (k, sample) in samples[1..].iter().enumerate() {
                let there = value(&coefficients, TAU * (periods * k) as f64 / count as f64);
                assert!((sample - there).abs() < 1e-13, "{count} {periods} {k}: {sample} {there}");
            }
        }
    }

    #[test]
    fn work_per_cycle_is_the_enclosed_area() {
        // Restoring force with a part in phase with velocity: T = k u + c u', area π c U² per harmonic.
        let displacement = [0.0, 0.0, 2.0];
        let force = [0.5, 0.25 * 2.0, 7.0 * 2.0];
        assert!((work_per_cycle(&force, &displacement) - std::f64::consts::PI * 0.25 * 4.0).abs() < 1e-14);
    }
}
