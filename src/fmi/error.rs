//! Why an instance refuses a call, as data.

use super::snapshot::SnapshotError;
use super::stage::Stage;

/// Why an instance refuses a call. It is then as before the call, except after [`Error::Step`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No variable has this value reference.
    #[error("no variable has the value reference {reference}; the largest is {largest}")]
    UnknownReference {
        /// What was asked for.
        reference: u32,
        /// The last row of the table.
        largest: usize,
    },
    /// A variable of another type.
    #[error("{name} is {is}, not {asked}")]
    WrongType {
        /// The variable.
        name: String,
        /// Its type.
        is: &'static str,
        /// The type asked for.
        asked: &'static str,
    },
    /// Not now, or never.
    #[error("{name} cannot be set: {reason}")]
    NotSettable {
        /// The variable.
        name: String,
        /// Why.
        reason: &'static str,
    },
    /// Outside the bounds, infinite or not a number.
    #[error("{name} = {value:?} is refused; it must be {bounds}")]
    Value {
        /// The variable.
        name: String,
        /// What was given.
        value: f64,
        /// What is allowed.
        bounds: String,
    },
    /// A call for importers that integrate, to an instance for co-simulation.
    #[error("a function of model exchange, which this instance is not for: it is for co-simulation")]
    Interface,
    /// The model file cannot be read.
    #[error("the model: {0}")]
    Model(String),
    /// The parameters do not make a model; the text begins with the name of one of them.
    #[error("{0}")]
    Parameters(String),
    /// A derivative with respect to time of an order that this library does not know.
    #[error("{name}: derivative of order {order}; orders from 1 to {highest} are known")]
    DerivativeOrder {
        /// The variable.
        name: String,
        /// What was asked for.
        order: i32,
        /// The highest known.
        highest: u32,
    },
    /// A derivative with respect to time that is infinite, not a number, or beyond all bounds.
    #[error(
        "{name}: a derivative of {value:?} is refused; it must be a finite number, at most {most:e} in magnitude"
    )]
    DerivativeValue {
        /// The variable.
        name: String,
        /// What was given.
        value: f64,
        /// What is allowed.
        most: f64,
    },
    /// A derivative of something that has none, or by something by which none is known.
    #[error("{name} has no such derivative: {reason}")]
    NoDerivative {
        /// The variable.
        name: String,
        /// Why.
        reason: &'static str,
    },
    /// A derivative that cannot be computed.
    #[error("the derivative could not be computed: {0}")]
    Derivative(String),
    /// An argument of a call other than a variable's value.
    #[error("{argument} = {value:?} is refused; it must be {allowed}")]
    Argument {
        /// Its name.
        argument: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
    /// Two arrays of different lengths.
    #[error("{references} value references, but {values} values or orders")]
    Lengths {
        /// Number of value references.
        references: usize,
        /// Number of values.
        values: usize,
    },
    /// Out of order.
    #[error("not allowed in stage {0:?}")]
    Stage(Stage),
    /// A step could not be computed. The instance is in [`Stage::StepFailed`] at the step's beginning.
    #[error("the step from {time:?} s could not be computed: {reason}")]
    Step {
        /// Beginning of the step (s).
        time: f64,
        /// Why.
        reason: String,
    },
    /// A saved state cannot be set.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
}
