//! The result of a fit.

use super::uncertainty::Uncertainty;

/// Why a fit ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The gradient vanished, or neither sum of squares nor parameters changed any more.
    Converged,
    /// The step limit was reached.
    StepLimit,
    /// No step reduced the sum of squares any more, without the gradient having vanished: noisy
    /// residuals, or failures all around.
    Stalled,
    /// The caller's interrupt hook asked for it.
    Interrupted,
}

/// The best point found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Parameters, in the caller's order and units.
    pub parameters: Vec<f64>,
    /// Residuals there.
    pub residuals: Vec<f64>,
    /// Their root mean square.
    pub root_mean_square: f64,
    /// ∂residual/∂parameter there, a column of all residuals for each parameter; those of held parameters are zero.
    /// Empty when the fit was interrupted before it was known.
    pub jacobian: Vec<Vec<f64>>,
    /// Standard errors and intervals.
    pub uncertainty: Uncertainty,
    /// Root mean square at the end of every start, in order; `None` where the start failed.
    pub starts: Vec<Option<f64>>,
    /// Which start won.
    pub best_start: usize,
    /// Evaluations of the residual, all starts together.
    pub evaluations: usize,
    /// How many of them failed.
    pub failures: usize,
    /// Why the winning start ended.
    pub ending: Ending,
}

/// Why there is no fit. `E` is the residual's own error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError<E> {
    /// The arguments make no sense together.
    #[error("{0}")]
    InvalidInput(&'static str),
    /// Parameter `index` has no room between its bounds, or values its scale cannot take.
    #[error("parameter {index}: {what}")]
    InvalidParameter {
        /// Which one.
        index: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// No start could be evaluated.
    #[error("none of the starts could be evaluated")]
    NoStart {
        /// What the residual said at the first start; `None` if it returned values that are not finite.
        first: Option<E>,
    },
    /// Interrupted before any point was evaluated.
    #[error("interrupted")]
    Interrupted,
}
