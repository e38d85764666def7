//! Harmonic balance: periodic responses of structures with contacts.
//!
//! Displacements are sums of harmonics, bias and even harmonics included where symmetry does not exclude
//! them (the end of a bending beam moves inwards twice per cycle). A contact is one map from the
//! coefficients of its displacement to those of its force (`cycle`). Linear structures (`condensed`) and
//! the modal beam (`balance`) are condensed to the displacements of their contacts; Newton's method with
//! conditions on top (`problem`) solves what remains, and arc length continues it (`continuation`).
//!
//! Coefficients are laid out `[a0, c1, s1, …, cH, sH]` per mode, mode after mode; see [`fourier`].

pub(crate) mod about;
mod assembly;
mod balance;
mod bracket;
mod condensed;
mod condition;
mod contact_cycle;
mod continuation;
mod curve;
mod cycle;
mod elimination;
mod extremum;
mod factors;
mod follow;
mod forced;
pub mod fourier;
mod frequency_response;
mod guess;
mod implicit;
mod krylov;
mod landmarks;
mod measured;
mod modal;
mod modes;
mod parameter;
mod periods;
mod problem;
mod resonance;
mod set;
pub mod stability;
mod start;
pub(crate) mod steady;
mod system;
mod tracker;
mod tracking;
mod transfer;
mod unit;
mod variation;

pub use assembly::{Assembly, AttachedContact, Body, Control, CurveSettings, UNRESOLVED};
pub use contact_cycle::{ContactCycle, ContactMapping, CycleSummary, contact_cycle};
pub use curve::{Contacting, Curve, Ending, Fold, Peak, Point};
pub use forced::{ForcedResponse, forced_response};
pub use frequency_response::{frequency_response, level_response, periodic_response};
pub use modes::{ModePoint, ModeRange, NonlinearMode, nonlinear_mode};
pub use parameter::{ContactAt, OwnedContact, Varied, VariedCurve, parameter_response};
pub use periods::{common_periods, excited_harmonics, whole_periods};
pub use resonance::{Resonance, backbone, phase_resonance};
pub use set::HarmonicSet;
pub use tracking::{Followed, Tracked, TrackedCurve, Tracking, track_levels, track_parameter};

use crate::contact::{ContactLaw, LawError};
use crate::system::StructureError;

/// A contact law under the constant normal load it has on the beam.
#[derive(Debug, Clone, Copy)]
pub struct ContactOnBeam<'a> {
    /// The law.
    pub law: &'a dyn ContactLaw,
    /// Normal load (N).
    pub normal_load: f64,
}

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Highest harmonic H of the displacements, at least 1.
    pub harmonics: usize,
    /// How the contact is carried over a period. Its displacement has `2 H` harmonics.
    pub method: Method,
    /// Largest residual accepted, as share of the contact's displacement.
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
    fn check(&self) -> Result<(), HarmonicError> {
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

/// Why no periodic response was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HarmonicError {
    /// The arguments make no sense together.
    #[error("{0}")]
    InvalidInput(&'static str),
    /// Newton's method stopped short of the tolerance.
    #[error("no balance after {iterations} steps: the residual is {residual:.1e} of the largest term")]
    NotConverged {
        /// Largest residual as share of the largest term.
        residual: f64,
        /// Newton steps made.
        iterations: usize,
    },
    /// The contact did not settle to a periodic state under the displacement tried.
    #[error("the contact did not become periodic within {cycles} cycles")]
    ContactNotPeriodic {
        /// Cycles marched.
        cycles: usize,
    },
    /// A contact could not be made for a value of the parameter.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The structure cannot be condensed to its contacts.
    #[error(transparent)]
    Structure(#[from] StructureError),
}

impl HarmonicError {
    /// Whether a shorter step may succeed where this one failed.
    fn is_of_the_step(&self) -> bool {
        matches!(self, Self::NotConverged { .. } | Self::ContactNotPeriodic { .. })
    }
}
