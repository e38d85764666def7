//! A periodic channel as a sum of harmonics, by least squares.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::IdentificationError;
use crate::numeric::fourier::coefficient_count;

/// A channel's harmonics.
#[derive(Debug, Clone, PartialEq)]
pub struct Harmonics {
    /// Coefficients `[a0, c1, s1, …]` in the channel's unit.
    pub coefficients: Vec<f64>,
    /// Standard error of each.
    pub errors: Vec<f64>,
    /// Standard deviation of what the harmonics leave.
    pub rest: f64,
}

/// Fits `count` harmonics of `frequency` (Hz) to `values` at `times` (s).
///
/// # Errors
/// Fewer samples than twice the coefficients, or times at which the harmonics cannot be told apart.
///
/// ```
/// use stickslip::identify::harmonics;
/// let times: Vec<f64> = (0..200).map(|k| 1e-3 * f64::from(k)).collect();
/// let values: Vec<f64> = times.iter().map(|t| 1.0 + 3.0 * (2.0 * std::f64::consts::TAU * 7.3 * t).sin()).collect();
/// let found = harmonics(&times, &values, 7.3, 3)?;
/// assert!((found.coefficients[0] - 1.0).abs() < 1e-9 && (found.coefficients[4] - 3.0).abs() < 1e-9);
/// # Ok::<(), stickslip::identify::IdentificationError>(())
/// ```
pub fn harmonics(
    times: &[f64],
    values: &[f64],
    frequency: f64,
    count: usize,
) -> Result<Harmonics, IdentificationError> {
    let unknowns = coefficient_count(count);
    if values.len() != times.len() || values.len() < 2 * unknowns {
        let message = format!("{} samples do not tell {count} harmonics", values.len());
        return Err(IdentificationError::Failed(message));
    }
    let start = times[0];
    let function = |time: f64, k: usize| {
        let phase = TAU * frequency * (time - start) * k.div_ceil(2) as f64;
        if k % 2 == 1 {
            phase.cos()
        } else if k == 0 {
            1.0
        } else {
            phase.sin()
        }
    };
    let matrix = DMatrix::from_fn(values.len(), unknowns, |i, k| function(times[i], k));
    let measured = DVector::from_column_slice(values);
    let factor = (matrix.transpose() * &matrix).cholesky();
    let apart =
        || IdentificationError::Failed(format!("the record is too short to tell {count} harmonics apart"));
    let factor = factor.ok_or_else(apart)?;
    let found = factor.solve(&(matrix.transpose() * &measured));
    let left = (&measured - &matrix * &found).norm_squared();
    let variance = left / (values.len() - unknowns) as f64;
    let inverse = factor.inverse();
    // Phases count from time zero, not from the first sample.
    let coefficients = shifted(found.as_slice(), -TAU * frequency * start);
    let errors = (0..unknowns).map(|k| (variance * inverse[(k, k)]).sqrt()).collect();
    Ok(Harmonics { coefficients, errors, rest: variance.sqrt() })
}

/// The coefficients of a signal that is `phase` (rad of the fundamental) ahead.
pub(super) fn shifted(coefficients: &[f64], phase: f64) -> Vec<f64> {
    let mut out = coefficients.to_vec();
    for (h, pair) in out[1..].chunks_exact_mut(2).enumerate() {
        let (sin, cos) = ((h + 1) as f64 * phase).sin_cos();
        (pair[0], pair[1]) = (pair[0] * cos + pair[1] * sin, pair[1] * cos - pair[0] * sin);
    }
    out
}
