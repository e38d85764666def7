//! Why a test was not made.

use crate::harmonic::HarmonicError;
use crate::model::AssemblyError;
use crate::time::{IntegrationError, SystemError};

/// Why a test was not made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The model or the plan asks for what there is not.
    #[error("{0}")]
    Input(String),
    /// The beam cannot be what the numbers say.
    #[error(transparent)]
    Model(#[from] AssemblyError),
    /// The beam cannot be integrated.
    #[error(transparent)]
    System(#[from] SystemError),
    /// There is no steady state, or it was not found.
    #[error(transparent)]
    Steady(#[from] HarmonicError),
    /// The motion in time could not be followed.
    #[error(transparent)]
    Motion(#[from] IntegrationError),
    /// One of these, in a record.
    #[error("{record}: {error}")]
    Record {
        /// Its name.
        record: String,
        /// What is wrong.
        error: Box<RigError>,
    },
    /// The caller ended the tests.
    #[error("interrupted")]
    Interrupted,
}

impl RigError {
    pub(super) fn of_record(self, record: &str) -> Self {
        match self {
            Self::Interrupted => Self::Interrupted,
            error => Self::Record { record: record.to_owned(), error: Box::new(error) },
        }
    }
}
