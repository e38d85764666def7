//! Detection limits: the smallest size of an effect that would have been found in these data.

use super::candidates::Candidate;
use super::select::{PASSING_FRACTION, PASSING_Z};
use crate::diagnose::diagnosis::Detectable;

/// What a change is seen against.
pub(in crate::diagnose) struct Noise {
    /// Samples of the fitted records.
    pub samples: usize,
    /// Mean square of the weighted residuals.
    pub chi_square: f64,
}

/// How many times a change of this square sum (of weighted residuals) must be taken to pass: its
/// estimate must lie three standard errors off zero and it must make three percent of the squared error.
/// `variance` is that of the residuals' product with the change. As in the intervals of parameters, the larger
/// counts of the standard errors with and without the residuals' correlation.
pub(in crate::diagnose) fn multiple(square: f64, variance: f64, noise: &Noise) -> f64 {
    let error = (noise.chi_square / square).sqrt().max(variance.sqrt() / square);
    let fraction = (PASSING_FRACTION * noise.samples as f64 * noise.chi_square / square).sqrt();
    (PASSING_Z * error).max(fraction)
}

/// Notes the size for the effect, the smallest where it can be at several places.
pub(in crate::diagnose) fn smaller(found: &mut Vec<Detectable>, candidate: &Candidate, size: Option<f64>) {
    let parameter = candidate.effect.parameters[0].quantity;
    match found.iter_mut().find(|known| known.effect == candidate.effect.id) {
        Some(known) => {
            known.value = match (known.value, size) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            }
        }
        None => found.push(Detectable {
            effect: candidate.effect.id,
            parameter: parameter.name,
            value: size,
            unit: parameter.unit,
        }),
    }
}
