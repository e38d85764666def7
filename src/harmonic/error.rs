//! Why there is no periodic response.

use crate::contact::LawError;
use crate::system::StructureError;
use crate::time::OscillatorError;

/// Why no periodic response was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HarmonicError {
    /// The caller asked for the end ([`CurveSettings::interrupt`](super::CurveSettings::interrupt)).
    #[error("interrupted")]
    Interrupted,
    /// The arguments make no sense together.
    #[error("{0}")]
    InvalidInput(&'static str),
    /// Newton's method stopped short of the tolerance.
    #[error(
        "harmonic balance failed: after {iterations} Newton steps the residual is {residual:.1e} of the largest term"
    )]
    NotConverged {
        /// Largest residual as a fraction of the largest term.
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
    /// The model cannot take a value of the parameter.
    #[error("{0}")]
    Model(String),
    /// A contact could not be made for a value of the parameter.
    #[error(transparent)]
    Law(#[from] LawError),
    /// Multipliers cannot be computed.
    #[error(transparent)]
    Multipliers(#[from] OscillatorError),
    /// The structure cannot be condensed to its contacts.
    #[error(transparent)]
    Structure(#[from] StructureError),
}

impl HarmonicError {
    /// Whether a shorter step may succeed where this one failed.
    pub(super) fn is_of_the_step(&self) -> bool {
        matches!(self, Self::NotConverged { .. } | Self::ContactNotPeriodic { .. })
    }
}
