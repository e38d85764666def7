//! The input of a fit: its parameters and how to run.

use crate::vocabulary::Scale;

/// One parameter of a fit.
///
/// ```
/// use stickslip::fit::{Options, Parameter, Scale, fit};
/// // y = a e^(-b t) through three points.
/// let points = [(0.0, 2.0), (1.0, 2.0 * f64::exp(-0.5)), (2.0, 2.0 * f64::exp(-1.0))];
/// let residual = |p: &[f64], out: &mut [f64]| -> Result<(), String> {
///     out.iter_mut().zip(points).for_each(|(r, (t, y))| *r = p[0] * f64::exp(-p[1] * t) - y);
///     Ok(())
/// };
/// let parameter = |start| Parameter { start, lower: 1e-3, upper: 1e3, scale: Scale::Logarithmic };
/// let found = fit(residual, 3, &[parameter(1.0), parameter(1.0)], &Options::default())?.parameters;
/// assert!((found[0] - 2.0).abs() < 1e-6 && (found[1] - 0.5).abs() < 1e-6);
/// # Ok::<(), stickslip::fit::FitError<String>>(())
/// ```
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
///
/// ```
/// use stickslip::fit::{Difference, Options};
/// let options = Options { starts: 5, difference: Difference::Central, ..Options::default() };
/// assert_eq!((options.starts, options.confidence), (5, 0.95));
/// ```
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Number of starts, at least 1. Further ones are spread evenly over the bounds (or one unit of
    /// the scale around the start where there is no bound), the same in every run.
    pub starts: usize,
    /// Accepted steps per start.
    pub max_iterations: usize,
    /// Relative change of the sum of squares, and of the parameters, that counts as none.
    pub tolerance: f64,
    /// Step of the finite differences, in fractions of the parameter's range or value (of its logarithm's
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
