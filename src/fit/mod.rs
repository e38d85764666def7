//! Bounded nonlinear least squares and the uncertainty of what it finds.
//!
//! [`fit`] minimises `½ Σ r²` over parameters within bounds, from one or several deterministic starts,
//! by the trust-region-reflective method (Branch, Coleman & Li 1999) with finite-difference Jacobians.
//! An evaluation that fails (a solver did not converge, a law refused a parameter) is a rejected step,
//! not the end of the fit. `least_squares` is the one file that knows the optimisation crate.

mod gauss_newton;
mod least_squares;
mod problem;
mod uncertainty;

pub(crate) use gauss_newton::{Limits, SumOfSquares, Sums, minimise};
pub use least_squares::fit;
pub(crate) use problem::Coordinate;
pub use uncertainty::{Interval, Uncertainty, student_quantile};

/// In which measure a parameter is stepped and its interval is symmetric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// As it is.
    #[default]
    Linear,
    /// By its logarithm: positive parameters known by order of magnitude.
    Logarithmic,
}

/// One parameter of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Where the first start begins; moved into the bounds.
    pub start: f64,
    /// Smallest value; −∞ for none. A logarithmic parameter needs a positive one.
    pub lower: f64,
    /// Largest value; +∞ for none. Equal bounds hold the parameter.
    pub upper: f64,
    /// Its measure.
    pub scale: Scale,
}

/// How derivatives are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Difference {
    /// One evaluation per parameter, first order.
    #[default]
    Forward,
    /// Two evaluations per parameter, second order.
    Central,
}

/// What a caller sees while a fit runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Which start, from 0.
    pub start: usize,
    /// How many there are.
    pub starts: usize,
    /// Accepted steps in this start.
    pub iteration: usize,
    /// Root mean square of the residuals there.
    pub root_mean_square: f64,
    /// Evaluations of the residual so far, all starts together.
    pub evaluations: usize,
}

/// Called after every accepted step.
pub type ProgressHook<'a> = &'a (dyn Fn(&Progress) + Sync);

/// Asked before every evaluation; `true` ends the fit with the best point so far.
pub type InterruptHook<'a> = &'a (dyn Fn() -> bool + Sync);

/// How a fit is run.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Number of starts, at least 1. Further ones are spread evenly over the bounds (or one unit of
    /// the scale around the start where there is no bound), the same in every run.
    pub starts: usize,
    /// Accepted steps per start.
    pub max_iterations: usize,
    /// Relative change of the sum of squares, and of the parameters, that counts as none.
    pub tolerance: f64,
    /// Step of the finite differences, in shares of the parameter's range or value (of its logarithm's
    /// unit for a logarithmic one). It should be well above the solver's own error.
    pub difference_step: f64,
    /// How derivatives are taken.
    pub difference: Difference,
    /// Level of the intervals, between 0 and 1.
    pub confidence: f64,
    /// Called after every accepted step.
    pub progress: Option<ProgressHook<'a>>,
    /// Asked before every evaluation.
    pub interrupt: Option<InterruptHook<'a>>,
}

impl std::fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("starts", &self.starts)
            .field("max_iterations", &self.max_iterations)
            .field("tolerance", &self.tolerance)
            .field("difference_step", &self.difference_step)
            .field("difference", &self.difference)
            .field("confidence", &self.confidence)
            .finish_non_exhaustive()
    }
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            starts: 1,
            max_iterations: 100,
            tolerance: 1e-9,
            difference_step: 1e-5,
            difference: Difference::Forward,
            confidence: 0.95,
            progress: None,
            interrupt: None,
        }
    }
}

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
    /// ∂residual/∂parameter there, row-major, one row per residual; columns of held parameters are zero.
    /// Empty when the fit was interrupted before it was known.
    pub jacobian: Vec<f64>,
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
