//! What can go wrong, as data.

use thiserror::Error;

/// Why a [`System`](crate::system::System) cannot be integrated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SystemError {
    /// A list does not have one entry per coordinate (for `shortening`, per pair), or a place lies outside.
    #[error("{field} has {found} entries, expected {expected}")]
    Length {
        /// Which list.
        field: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries present.
        found: usize,
    },
    /// NaN, an infinity, or a negative frequency, damping ratio, stiffness or flexibility.
    #[error("{field} holds {value}, which is not a legal value")]
    Value {
        /// Where.
        field: String,
        /// The value.
        value: f64,
    },
    /// A matrix is not symmetric.
    #[error("{field} is not symmetric in {row} and {column}")]
    Asymmetric {
        /// Which matrix.
        field: &'static str,
        /// First coordinate, from 0.
        row: usize,
        /// Second coordinate, from 0.
        column: usize,
    },
    /// The mass matrix is not positive definite.
    #[error("the mass matrix is not positive definite: a degree of freedom has no mass")]
    MassNotPositive,
    /// Drives and sensors act at linear ports; ports of a system that is not modal are linear.
    #[error("a port that shortens is driven or read, or the system is not modal")]
    NotLinear,
    /// The integrator has no contacts in two directions at once.
    #[error("a contact in two directions at once cannot be integrated")]
    TwoDirections,
    /// The integrator has no masses that move with ports; equal steps have no more than one such element, and no forces from
    /// outside.
    #[error("masses that move with ports, or forces from outside, cannot be integrated")]
    InertiaAtPorts,
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
    /// The motion does not belong to this system.
    #[error("the motion has {found} numbers, this system needs {expected}")]
    MotionLength {
        /// Numbers needed.
        expected: usize,
        /// Numbers present.
        found: usize,
    },
    /// One input per driven port, law and outside force is needed.
    #[error("{found} inputs for {expected} driven ports, laws and outside forces")]
    Inputs {
        /// Inputs of the system.
        expected: usize,
        /// Inputs given.
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
    /// In equal steps the motion is no longer finite.
    #[error("the motion grows without bound, {time:?} s after the start of the communication step")]
    Unbounded {
        /// Time since the start of the communication step (s).
        time: f64,
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
