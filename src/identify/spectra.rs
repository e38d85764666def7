//! Frequency response functions from random excitation: Welch's averages, H1, H2, coherence.

use nalgebra::Complex;
use realfft::RealFftPlanner;

use super::IdentificationError;

/// Fraction by which neighbouring segments overlap.
const OVERLAP: f64 = 0.5;

/// A frequency response function of one response.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// Frequencies (Hz), from the first line above zero to half the sampling frequency.
    pub frequencies: Vec<f64>,
    /// Response over force, noise in the response averaged out.
    pub h1: Vec<Complex<f64>>,
    /// The same, noise in the force averaged out.
    pub h2: Vec<Complex<f64>>,
    /// Part of the response's power that the force explains (1).
    pub coherence: Vec<f64>,
    /// Segments averaged, as if they did not overlap.
    pub averages: f64,
}

impl FrequencyResponse {
    /// Standard deviation of the magnitude of H1 over that magnitude, at every line.
    pub fn relative_error(&self) -> Vec<f64> {
        let error = |c: &f64| ((1.0 - c).max(0.0) / (2.0 * c.max(1e-12) * self.averages)).sqrt();
        self.coherence.iter().map(error).collect()
    }
}

/// The frequency response of `response` to `force`, sampled `rate` times a second, from segments of `length` samples under
/// Hann's window.
///
/// # Errors
/// Fewer samples than two segments, or channels of different lengths.
///
/// ```
/// use stickslip::identify::frequency_response_of;
/// // A response that is three times the force one sample ago.
/// let force: Vec<f64> = (0..4000).map(|k| f64::from((k * 7919 % 1009) as u16) - 504.0).collect();
/// let response: Vec<f64> = std::iter::once(0.0).chain(force.iter().map(|f| 3.0 * f)).take(4000).collect();
/// let found = frequency_response_of(&force, &response, 1000.0, 256)?;
/// assert!(found.h1.iter().all(|h| (h.norm() - 3.0).abs() < 0.2));
/// # Ok::<(), stickslip::identify::IdentificationError>(())
/// ```
pub fn frequency_response_of(
    force: &[f64],
    response: &[f64],
    rate: f64,
    length: usize,
) -> Result<FrequencyResponse, IdentificationError> {
    if force.len() != response.len() || length < 8 || force.len() < 2 * length {
        return Err(IdentificationError::Failed(format!(
            "{} samples are not two segments of {length}: a longer record or shorter segments are needed",
            force.len().min(response.len())
        )));
    }
    let window: Vec<f64> = (0..length)
        .map(|k| (std::f64::consts::PI * (k as f64 + 0.5) / length as f64).sin().powi(2))
        .collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let spectrum = |segment: &[f64]| {
        let mean = segment.iter().sum::<f64>() / length as f64;
        let mut input: Vec<f64> = segment.iter().zip(&window).map(|(x, w)| (x - mean) * w).collect();
        let mut output = transform.make_output_vec();
        // Lengths are those of the transform: it cannot fail.
        let _ = transform.process(&mut input, &mut output);
        output
    };
    let lines = length / 2 + 1;
    let (mut ff, mut xx, mut xf) = (vec![0.0; lines], vec![0.0; lines], vec![Complex::new(0.0, 0.0); lines]);
    let step = ((1.0 - OVERLAP) * length as f64).round().max(1.0) as usize;
    let starts: Vec<usize> = (0..=force.len() - length).step_by(step).collect();
    for start in &starts {
        let range = *start..start + length;
        let (f, x) = (spectrum(&force[range.clone()]), spectrum(&response[range]));
        for k in 0..lines {
            ff[k] += f[k].norm_sqr();
            xx[k] += x[k].norm_sqr();
            xf[k] += x[k] * f[k].conj();
        }
    }
    let kept = 1..lines;
    Ok(FrequencyResponse {
        frequencies: kept.clone().map(|k| k as f64 * rate / length as f64).collect(),
        h1: kept.clone().map(|k| xf[k] / ff[k]).collect(),
        h2: kept.clone().map(|k| xx[k] / xf[k].conj()).collect(),
        coherence: kept.map(|k| xf[k].norm_sqr() / (ff[k] * xx[k])).collect(),
        averages: independent(&window, step, starts.len()),
    })
}

/// How many independent averages `count` segments are worth that follow each other by `step` (Welch 1967).
fn independent(window: &[f64], step: usize, count: usize) -> f64 {
    let overlap =
        |lag: usize| -> f64 { window.iter().skip(lag).zip(window).map(|(a, b)| a * b).sum::<f64>() };
    let (whole, n) = (overlap(0), count as f64);
    let shared = |k: usize| (1.0 - k as f64 / n) * (overlap(k * step) / whole).powi(2);
    let lags = (1..count).take_while(|k| k * step < window.len());
    n / (1.0 + 2.0 * lags.map(shared).sum::<f64>())
}
