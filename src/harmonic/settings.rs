//! How a period of the contact is computed, when a balance counts as solved, and how far apart the points of a curve are.

use super::HarmonicError;
use super::newton::problem::{HALVINGS, Stopping};

/// Samples of a period where the limit itself moves, or the load that it follows: the force is then right to a few parts in ten
/// thousand.
pub(crate) const SAMPLES_IN_MOTION: usize = 1024;

/// How a contact is carried over a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// From turning point to turning point: exact for piecewise-linear laws, and to quadrature's accuracy
    /// (about 1e-10 of the force) for laws that are smooth between reversals.
    #[default]
    Exact,
    /// At equally spaced samples of a period, of second order in their distance: an independent check.
    Sampled {
        /// Samples of a period, at least eight times the highest harmonic of the contact's displacement, which of a system in
        /// modal coordinates is twice that of the modes.
        samples: usize,
    },
}

impl Method {
    /// Samples of a period where the limit of friction moves, and the exact way has none either.
    pub(crate) fn samples_in_motion(self) -> usize {
        match self {
            Self::Exact => SAMPLES_IN_MOTION,
            Self::Sampled { samples } => samples,
        }
    }
}

/// Largest estimated truncation error of a point that counts as resolved where [`CurveSettings::truncation`]
/// asks for none: 1 % of the amplitude.
pub const UNRESOLVED: f64 = 0.01;

/// Asked again and again by work that takes long: whether it is to end with what it has.
#[derive(Debug, Clone, Copy)]
pub struct Interrupt(pub fn() -> bool);

impl PartialEq for Interrupt {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::fn_addr_eq(self.0, other.0)
    }
}

/// Discretisation, stopping rule and step control of responses.
///
/// ```
/// use stickslip::harmonic::{CurveSettings, Method};
/// // The same response by samples, as an independent check.
/// let check = CurveSettings { method: Method::Sampled { samples: 1024 }, ..CurveSettings::default() };
/// assert_eq!(check.harmonics, 21);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveSettings {
    /// Highest harmonic of the displacements, to start with where they adapt.
    pub harmonics: usize,
    /// Truncation error of the displacements accepted (fraction of the amplitude). With it the harmonics adapt
    /// between [`CurveSettings::harmonics`] and [`CurveSettings::max_harmonics`]; without it they stay.
    pub truncation: Option<f64>,
    /// Most harmonics an adapted point may have.
    pub max_harmonics: usize,
    /// How contacts are carried over a period.
    pub method: Method,
    /// Largest residual accepted, as a fraction of the largest displacement.
    pub tolerance: f64,
    /// Newton steps before a start is given up.
    pub max_iterations: usize,
    /// Whether the stability of every point is determined.
    pub stability: bool,
    /// Even harmonics and bias too where symmetry allows odd harmonics alone. By default the set is odd where
    /// all laws are odd and so is the excitation; such a set cannot see responses that break the symmetry
    /// (even harmonics born in a pitchfork bifurcation, as of the Duffing oscillator), only that
    /// the symmetric response has become unstable.
    pub all_harmonics: bool,
    /// Longest step, as a fraction of the range.
    pub max_step: f64,
    /// Points before a curve is given up.
    pub max_points: usize,
    /// Asked before every Newton step; where it says so, a curve ends with the points it has
    /// ([`Ending::Interrupted`](super::Ending::Interrupted)), and a single response with [`HarmonicError::Interrupted`].
    pub interrupt: Option<Interrupt>,
}

impl Default for CurveSettings {
    fn default() -> Self {
        Self {
            harmonics: 21,
            truncation: None,
            max_harmonics: 101,
            method: Method::Exact,
            tolerance: 1e-10,
            max_iterations: 40,
            stability: false,
            all_harmonics: false,
            max_step: 0.02,
            max_points: 20_000,
            interrupt: None,
        }
    }
}

impl CurveSettings {
    pub(crate) fn check(&self) -> Result<(), HarmonicError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if self.harmonics == 0 || self.max_iterations == 0 || self.max_points == 0 {
            return Err(HarmonicError::InvalidInput("harmonics, iterations and points must be at least 1"));
        }
        if !positive(self.tolerance) || !positive(self.max_step) {
            return Err(HarmonicError::InvalidInput("the tolerance and the longest step must be positive"));
        }
        if let Some(truncation) = self.truncation
            && (!positive(truncation) || self.max_harmonics < self.harmonics)
        {
            return Err(HarmonicError::InvalidInput(
                "the truncation error must be positive, and the most harmonics no fewer than the first",
            ));
        }
        if let Method::Sampled { samples } = self.method
            && samples < 8 * self.harmonics
        {
            return Err(HarmonicError::InvalidInput("fewer than 8 samples per harmonic"));
        }
        Ok(())
    }

    /// The stopping rule of a solution that may be anywhere.
    pub(crate) fn stopping(&self) -> Stopping {
        let (tolerance, max_iterations) = (self.tolerance, self.max_iterations);
        let reach = f64::INFINITY;
        Stopping { tolerance, max_iterations, reach, halvings: HALVINGS, interrupt: self.interrupt }
    }

    /// Whether the work is to end.
    pub(crate) fn interrupted(&self) -> bool {
        self.interrupt.is_some_and(|Interrupt(asked)| asked())
    }
}
