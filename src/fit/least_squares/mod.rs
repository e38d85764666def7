//! Bounded nonlinear least squares and the uncertainty of what it finds.
//!
//! [`fit`] minimises `½ Σ r²` over parameters within bounds, from one or several deterministic starts,
//! by the trust-region-reflective method (Branch, Coleman & Li 1999) with finite-difference Jacobians.
//! An evaluation that fails (a solver did not converge, a law refused a parameter) is a rejected step,
//! not the end of the fit. `trust_region` is the one file that knows the optimisation crate.

mod coordinate;
mod gauss_newton;
mod options;
mod outcome;
mod problem;
mod trust_region;
mod uncertainty;

pub use crate::vocabulary::Scale;
pub(crate) use coordinate::Coordinate;
pub(crate) use gauss_newton::{Limits, SumOfSquares, Sums, minimise};
pub use options::{Difference, InterruptHook, Options, Parameter, Progress, ProgressHook};
pub use outcome::{Ending, Fit, FitError};
pub use trust_region::fit;
pub use uncertainty::{Interval, Uncertainty, student_quantile};
