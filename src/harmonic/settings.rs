//! How a period of the contact is computed, and when a beam's balance counts as solved.

use super::HarmonicError;

/// How a contact is carried over a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// From turning point to turning point: exact for piecewise-linear laws, and to quadrature's accuracy
    /// (about 1e-10 of the force) for laws that are smooth between reversals.
    #[default]
    Exact,
    /// At equally spaced samples of a period, of second order in their distance: an independent check.
    Sampled {
        /// Samples of a period, at least eight times the highest harmonic.
        samples: usize,
    },
}

/// Discretisation and stopping rule.
///
/// ```
/// use stickslip::harmonic::{Method, Settings};
/// // The same response by samples, as an independent check.
/// let check = Settings { method: Method::Sampled { samples: 1024 }, ..Settings::default() };
/// assert_eq!(check.harmonics, 7);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Highest harmonic H of the displacements, at least 1.
    pub harmonics: usize,
    /// How the contact is carried over a period. Its displacement has `2 H` harmonics.
    pub method: Method,
    /// Largest residual accepted, as a fraction of the contact's displacement.
    pub tolerance: f64,
    /// Newton steps before a start is given up.
    pub max_iterations: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { harmonics: 7, method: Method::Exact, tolerance: 1e-9, max_iterations: 40 }
    }
}

impl Settings {
    pub(super) fn check(&self) -> Result<(), HarmonicError> {
        if self.harmonics == 0 {
            return Err(HarmonicError::InvalidInput("there must be a harmonic at least"));
        }
        if let Method::Sampled { samples } = self.method
            && samples < 16 * self.harmonics
        {
            return Err(HarmonicError::InvalidInput(
                "fewer than 16 samples per harmonic, 8 for each of the contact's displacement",
            ));
        }
        if !(self.tolerance > 0.0 && self.max_iterations > 0) {
            return Err(HarmonicError::InvalidInput(
                "the tolerance and the number of iterations must be positive",
            ));
        }
        Ok(())
    }
}
