//! What can go wrong, as data.

use thiserror::Error;

/// Why the motion of a lumped oscillator was not computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OscillatorError {
    /// An argument is not a legal number.
    #[error("{name} is {value}, which is not a legal value")]
    Input {
        /// Which one.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// A list does not have the length that the structure or its contacts ask for.
    #[error("{name} has {found} entries, expected {expected}")]
    Length {
        /// Which one.
        name: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries present.
        found: usize,
    },
    /// An entry of the structure is not finite, or lies outside its matrix.
    #[error("the structure's {field} holds an entry that is not finite or out of place")]
    Structure {
        /// Which part.
        field: &'static str,
    },
    /// The mass matrix is not symmetric positive definite.
    #[error("the mass matrix is not positive definite: a degree of freedom has no mass")]
    MassNotPositive,
    /// The law of a contact is not piecewise linear.
    #[error("the law of contact {contact} is not piecewise linear")]
    NotPiecewiseLinear {
        /// Which contact, from 0.
        contact: usize,
    },
    /// More steps than allowed: events follow each other without end, or the stretch is too long.
    #[error("{limit} steps were not enough; stopped at {time:?} s")]
    TooManySteps {
        /// The limit.
        limit: usize,
        /// Time reached (s).
        time: f64,
    },
    /// The tolerance cannot be met with any step that makes progress.
    #[error("the step size fell to {step:?} s at {time:?} s")]
    StepTooSmall {
        /// Time reached (s).
        time: f64,
        /// The step refused (s).
        step: f64,
    },
    /// The motion grew beyond what numbers can hold.
    #[error("the motion is not finite at {time:?} s")]
    Diverged {
        /// Time reached (s).
        time: f64,
    },
    /// No periodic motion was found.
    #[error("no periodic motion after {iterations} periods: it misses by {mismatch:.1e} of its size")]
    NotPeriodic {
        /// Periods computed.
        iterations: usize,
        /// Largest change over a period as a fraction of the largest displacement and velocity.
        mismatch: f64,
    },
}
