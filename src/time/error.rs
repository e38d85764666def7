//! What can go wrong, as data.

use thiserror::Error;

/// Why a [`ModalBeam`](crate::system::ModalBeam) cannot be integrated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BeamError {
    /// A list does not have one entry per mode (or, for `shortening`, per pair of modes).
    #[error("{field} has {found} entries, expected {expected}")]
    Length {
        /// Field of the beam.
        field: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries present.
        found: usize,
    },
    /// NaN, an infinity, or a negative frequency, damping ratio or flexibility.
    #[error("{field} holds {value}, which is not a legal value")]
    Value {
        /// Field of the beam.
        field: &'static str,
        /// The value.
        value: f64,
    },
    /// `shortening` is not symmetric.
    #[error("shortening is not symmetric in modes {row} and {column}")]
    Asymmetric {
        /// First mode, from 0.
        row: usize,
        /// Second mode, from 0.
        column: usize,
    },
}

/// Why a communication step failed. The state is then unchanged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum IntegrationError {
    /// An input or a setting is not a legal number.
    #[error("{name} is {value}, which is not a legal value")]
    Input {
        /// Which one.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// The motion does not belong to this beam and contact law.
    #[error("the motion has {found} numbers, this beam with this contact needs {expected}")]
    MotionLength {
        /// Numbers needed.
        expected: usize,
        /// Numbers present.
        found: usize,
    },
    /// As many forces are needed as the beam has contact points.
    #[error("{found} forces for {expected} contact points")]
    ContactPoints {
        /// Contact points of the beam.
        expected: usize,
        /// Forces given.
        found: usize,
    },
    /// The motion holds NaN or infinities.
    #[error("the motion's number {index} is not finite")]
    MotionNotFinite {
        /// Position in the flat state.
        index: usize,
    },
    /// The tolerance cannot be met with any step that makes progress.
    #[error("the step size fell to {step:?} s at {time:?} s after the start of the communication step")]
    StepTooSmall {
        /// Time since the start of the communication step (s).
        time: f64,
        /// The step refused (s).
        step: f64,
    },
    /// More steps than [`Settings::step_limit`](super::Settings) were needed.
    #[error("{limit} steps were not enough; stopped at {time:?} s after the start of the communication step")]
    TooManySteps {
        /// The limit.
        limit: usize,
        /// Time since the start of the communication step (s).
        time: f64,
    },
}
