//! Bounded nonlinear least squares and the uncertainty of what it finds.
//!
//! [`fit`] minimises `½ Σ r²` over parameters within bounds, from one or several deterministic starts: parameters
//! become coordinates of size one (`coordinate`), the residual a sum of squares with derivatives by differences
//! (`problem`), which Levenberg's and Marquardt's method minimises (`levenberg_marquardt`). An evaluation that fails (a
//! solver did not converge, a law refused a parameter) is a rejected step, not the end of the fit. Joint fits to
//! many records, which have derivatives of their own, use the same method. `revive` starts again with parameters that no
//! longer change the residual, `uncertainty` gives intervals.

mod coordinate;
mod levenberg_marquardt;
mod options;
mod outcome;
mod problem;
mod revive;
mod starts;
mod uncertainty;

pub use crate::numeric::student::student_quantile;
pub use crate::vocabulary::Scale;
pub(crate) use coordinate::Coordinate;
pub(crate) use levenberg_marquardt::{Limits, SumOfSquares, Sums, minimise};
pub use options::{Difference, InterruptHook, Options, Parameter, Progress, ProgressHook};
pub use outcome::{Ending, Fit, FitError};
pub(crate) use revive::fit_reviving;
pub use starts::fit;
pub use uncertainty::{Interval, Uncertainty};
