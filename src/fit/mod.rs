//! Models and measurements: predict records, fit parameters, compare.
//!
//! - [`predict`]: a model and a record come in, what the sensors would show comes out.
//! - [`least_squares`]: bounded fits with intervals, of anything that has residuals.
//! - [`compare`]: a model against a dataset, before and after its free parameters are fitted.
//! - [`checks`]: what is wrong with the data, or with the model's units, before anything is fitted.
//! - [`ring_down`]: free decays without an excitation, cut into levels of amplitude, frequency and damping.
//! - [`residual`]: the residual, over what it may depend on, and what that may come from.

pub mod checks;
pub mod compare;
pub mod least_squares;
pub mod predict;
pub mod residual;
pub mod ring_down;
mod tables;

pub use least_squares::{
    Difference, Ending, Fit, FitError, InterruptHook, Interval, Options, Parameter, Progress, ProgressHook,
    Scale, Uncertainty, fit, student_quantile,
};
pub use tables::tabulated;

pub(crate) use least_squares::{Limits, SumOfSquares, Sums, minimise};
