//! Spectra of records that are no whole number of periods.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

/// Lines from 0 to the Nyquist frequency, the mean removed, under a Hann window; a sine of amplitude 1 at a line is one of
/// height 1. `None` of fewer than two values.
pub(crate) fn hann_lines(values: &[f64]) -> Option<Vec<Complex<f64>>> {
    let count = values.len();
    if count < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count as f64;
    let window = |k: usize| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / count as f64).cos();
    let mut input: Vec<f64> =
        values.iter().enumerate().map(|(k, value)| (value - mean) * window(k)).collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(count);
    let mut lines = transform.make_output_vec();
    transform.process(&mut input, &mut lines).ok()?;
    // The window's mean is a half.
    lines.iter_mut().for_each(|line| *line *= 4.0 / count as f64);
    Some(lines)
}
