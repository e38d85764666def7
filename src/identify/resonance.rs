//! Frequency, damping and peak of one mode from a few points of its frequency response.

use nalgebra::{Complex, DMatrix, DVector};

use super::IdentificationError;
use crate::fit::{Difference, Interval, Options, Parameter, Scale, fit};

/// One mode near its resonance.
#[derive(Debug, Clone, PartialEq)]
pub struct ResonanceFit {
    /// Natural frequency (Hz).
    pub frequency: f64,
    /// Its 95 % interval, where the points tell one.
    pub frequency_interval: Option<Interval>,
    /// Damping ratio (1).
    pub damping_ratio: f64,
    /// Its 95 % interval, where the points tell one.
    pub damping_interval: Option<Interval>,
    /// Largest magnitude of the fitted response between the points, in their unit.
    pub peak: f64,
    /// What the fit leaves, root mean square over that of the points.
    pub error: f64,
    /// R and C of the fitted response, in the points' unit.
    pub parts: [f64; 2],
}

impl ResonanceFit {
    /// The fitted response at `frequency` (Hz).
    pub fn value(&self, frequency: f64) -> Complex<f64> {
        mode(frequency, self.frequency, self.damping_ratio) * self.parts[0] + Complex::from(self.parts[1])
    }
}

/// Fits `ω² R / (ω₁² − ω² + 2iζω₁ω) + C`, an accelerance of one mode beside the others' constant part, to complex `values` at
/// `frequencies` (Hz). R and C are real, as those of modes that move in phase: were they complex, they would take up what the
/// frequency does to a contact in a narrow band, and the resonance would not be where force and velocity are in phase.
///
/// # Errors
/// Fewer than four points, or points without a resonance.
///
/// ```
/// use nalgebra::Complex;
/// use stickslip::identify::resonance_of;
/// let frequencies: Vec<f64> = (0..9).map(|k| 50.0 + 0.125 * f64::from(k)).collect();
/// let value = |f: &f64| Complex::from(f * f) / Complex::new(50.4 * 50.4 - f * f, 2.0 * 0.01 * 50.4 * f);
/// let found = resonance_of(&frequencies, &frequencies.iter().map(value).collect::<Vec<_>>())?;
/// assert!((found.frequency - 50.4).abs() < 1e-6 && (found.damping_ratio - 0.01).abs() < 1e-6);
/// # Ok::<(), stickslip::identify::IdentificationError>(())
/// ```
pub fn resonance_of(
    frequencies: &[f64],
    values: &[Complex<f64>],
) -> Result<ResonanceFit, IdentificationError> {
    let usable = frequencies.len() == values.len() && values.len() >= 4;
    let largest = (0..values.len()).max_by(|a, b| values[*a].norm().total_cmp(&values[*b].norm()));
    let Some(largest) = largest.filter(|_| usable) else {
        return Err(IdentificationError::Failed(format!(
            "{} points do not tell a resonance: four do",
            values.len()
        )));
    };
    let (low, high) = frequencies.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(*f), h.max(*f)));
    let width = high - low;
    let size = values.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), IdentificationError> {
        let (rest, _) = projected(frequencies, values, p[0], p[1])?;
        out.iter_mut().zip(rest.iter()).for_each(|(o, r)| *o = r / size);
        Ok(())
    };
    let parameters = [
        Parameter {
            start: frequencies[largest],
            lower: low - width,
            upper: high + width,
            scale: Scale::Linear,
        },
        Parameter { start: 0.02, lower: 1e-5, upper: 1.0, scale: Scale::Logarithmic },
    ];
    let options =
        Options { starts: 5, difference: Difference::Central, difference_step: 1e-6, ..Options::default() };
    let found = fit(residual, 2 * values.len(), &parameters, &options)
        .map_err(|error| IdentificationError::Failed(format!("the resonance was not fitted: {error}")))?;
    let (frequency, damping_ratio) = (found.parameters[0], found.parameters[1]);
    let (_, parts) = projected(frequencies, values, frequency, damping_ratio)?;
    let model = |f: f64| mode(f, frequency, damping_ratio) * parts[0] + Complex::from(parts[1]);
    let between = (0..=400).map(|k| low + width * f64::from(k) / 400.0);
    let interval = |k: usize| found.uncertainty.interval.get(k).copied().flatten();
    Ok(ResonanceFit {
        frequency,
        frequency_interval: interval(0),
        damping_ratio,
        damping_interval: interval(1),
        peak: between.map(|f| model(f).norm()).fold(0.0, f64::max),
        error: found.residuals.iter().map(|r| r * r).sum::<f64>().sqrt(),
        parts,
    })
}

fn mode(f: f64, natural: f64, damping: f64) -> Complex<f64> {
    Complex::from(f * f) / Complex::new(natural * natural - f * f, 2.0 * damping * natural * f)
}

/// What the best residue and constant leave, real and imaginary parts; and both.
fn projected(
    frequencies: &[f64],
    values: &[Complex<f64>],
    natural: f64,
    damping: f64,
) -> Result<(Vec<f64>, [f64; 2]), IdentificationError> {
    let both =
        |values: Vec<Complex<f64>>| values.into_iter().flat_map(|value| [value.re, value.im]).collect();
    let mode: Vec<f64> = both(frequencies.iter().map(|f| mode(*f, natural, damping)).collect());
    let column = |i: usize, k: usize| if k == 0 { mode[i] } else { 1.0 - (i % 2) as f64 };
    let matrix = DMatrix::from_fn(mode.len(), 2, column);
    let right = DVector::from_vec(both(values.to_vec()));
    let solved = (matrix.transpose() * &matrix).lu().solve(&(matrix.transpose() * &right));
    let parts =
        solved.ok_or_else(|| IdentificationError::Failed("the points tell no resonance".to_owned()))?;
    let rest = right - matrix * &parts;
    Ok((rest.as_slice().to_vec(), [parts[0], parts[1]]))
}
