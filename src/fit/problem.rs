//! The residual in scaled coordinates: bounds, failures, counters and finite differences.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::{Difference, FitError, Options, Parameter, Scale};

/// One parameter's coordinate `y`, zero at the parameter's start and about one across its range.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coordinate {
    scale: Scale,
    start: f64,
    unit: f64,
    pub lower: f64,
    pub upper: f64,
    value_lower: f64,
    value_upper: f64,
}

impl Coordinate {
    pub fn new<E>(index: usize, parameter: &Parameter) -> Result<Self, FitError<E>> {
        let Parameter { start, lower, upper, scale } = *parameter;
        let refuse = |what| Err(FitError::InvalidParameter { index, what });
        if !start.is_finite() {
            return refuse("the start is not finite");
        }
        if lower.is_nan()
            || upper.is_nan()
            || lower > upper
            || lower == f64::INFINITY
            || upper == -f64::INFINITY
        {
            return refuse("the lower bound is not below the upper");
        }
        let start = start.clamp(lower, upper);
        if scale == Scale::Logarithmic && !(lower > 0.0 && start > 0.0) {
            return refuse("a logarithmic parameter needs a positive lower bound");
        }
        let unit = match scale {
            Scale::Logarithmic => 1.0,
            Scale::Linear if (upper - lower).is_finite() && upper > lower => upper - lower,
            Scale::Linear if start != 0.0 => start.abs(),
            Scale::Linear => 1.0,
        };
        let mut coordinate =
            Self { scale, start, unit, lower, upper, value_lower: lower, value_upper: upper };
        coordinate.lower = coordinate.coordinate_of(lower);
        coordinate.upper = coordinate.coordinate_of(upper);
        Ok(coordinate)
    }

    /// The parameter's value; never outside the bounds, whatever the rounding.
    pub fn value(self, y: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => self.start + self.unit * y,
            Scale::Logarithmic => self.start * y.exp(),
        };
        value.clamp(self.value_lower, self.value_upper)
    }

    pub fn coordinate_of(self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.start) / self.unit,
            Scale::Logarithmic => (value / self.start).ln(),
        }
    }

    /// ∂value/∂y.
    pub fn slope(self, y: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.unit,
            Scale::Logarithmic => self.value(y),
        }
    }

    pub fn held(self) -> bool {
        self.lower >= self.upper
    }

    /// The point a share `t` in [0, 1] of the way between the bounds, or within a unit of the start.
    pub fn spread(self, t: f64) -> f64 {
        let (low, high) = (self.lower.max(-1e3), self.upper.min(1e3));
        let low = if self.lower.is_finite() { low } else { (-1.0_f64).min(high - 1.0) };
        let high = if self.upper.is_finite() { high } else { 1.0_f64.max(low + 1.0) };
        low + t * (high - low)
    }
}

/// Asked to stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stop;

/// The residual as a function of the coordinates.
pub(super) struct Scaled<'a, R, E> {
    residual: &'a R,
    pub coordinates: &'a [Coordinate],
    pub count: usize,
    options: &'a Options<'a>,
    evaluations: AtomicUsize,
    failures: AtomicUsize,
    first_error: Mutex<Option<E>>,
    /// The last point evaluated, so that a Jacobian at an accepted point need not repeat it.
    last: Mutex<(Vec<f64>, Vec<f64>)>,
}

impl<'a, R, E> Scaled<'a, R, E>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    pub fn new(
        residual: &'a R,
        count: usize,
        coordinates: &'a [Coordinate],
        options: &'a Options<'a>,
    ) -> Self {
        Self {
            residual,
            coordinates,
            count,
            options,
            evaluations: AtomicUsize::new(0),
            failures: AtomicUsize::new(0),
            first_error: Mutex::new(None),
            last: Mutex::new((Vec::new(), Vec::new())),
        }
    }

    pub fn evaluations(&self) -> usize {
        self.evaluations.load(Ordering::Relaxed)
    }

    pub fn failures(&self) -> usize {
        self.failures.load(Ordering::Relaxed)
    }

    /// The error of the first evaluation that failed with one.
    pub fn take_first_error(&self) -> Option<E> {
        self.first_error.lock().ok().and_then(|mut error| error.take())
    }

    pub fn values(&self, y: &[f64]) -> Vec<f64> {
        self.coordinates.iter().zip(y).map(|(c, y)| c.value(*y)).collect()
    }

    /// Residuals at `y`; NaN throughout when the evaluation failed.
    pub fn evaluate(&self, y: &[f64]) -> Result<Vec<f64>, Stop> {
        if let Some(known) = self.known(y) {
            return Ok(known);
        }
        let residuals = self.evaluate_afresh(y)?;
        if let Ok(mut last) = self.last.lock() {
            *last = (y.to_vec(), residuals.clone());
        }
        Ok(residuals)
    }

    /// As `evaluate`, without asking whether to stop.
    pub fn evaluate_uninterrupted(&self, y: &[f64]) -> Vec<f64> {
        self.known(y).unwrap_or_else(|| self.compute(y))
    }

    /// The residuals at `y` if it was evaluated last.
    fn known(&self, y: &[f64]) -> Option<Vec<f64>> {
        self.last.lock().ok().filter(|last| last.0 == y).map(|last| last.1.clone())
    }

    fn evaluate_afresh(&self, y: &[f64]) -> Result<Vec<f64>, Stop> {
        if self.options.interrupt.is_some_and(|interrupt| interrupt()) {
            return Err(Stop);
        }
        Ok(self.compute(y))
    }

    fn compute(&self, y: &[f64]) -> Vec<f64> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let mut out = vec![0.0; self.count];
        let outcome = (self.residual)(&self.values(y), &mut out);
        if outcome.is_err() || out.iter().any(|r| !r.is_finite()) {
            self.failures.fetch_add(1, Ordering::Relaxed);
            out.fill(f64::NAN);
        }
        if let Err(error) = outcome
            && let Ok(mut first) = self.first_error.lock()
        {
            first.get_or_insert(error);
        }
        out
    }

    /// ∂residual/∂y, column by column; the columns are evaluated in parallel, each on its own, so that
    /// the result does not depend on the number of threads. A column is taken from the other side
    /// where an evaluation fails, and is NaN if both sides fail.
    pub fn jacobian(&self, y: &[f64]) -> Result<Vec<Vec<f64>>, Stop> {
        let base = self.evaluate(y)?;
        (0..y.len()).into_par_iter().map(|j| self.column(y, j, &base)).collect()
    }

    fn column(&self, y: &[f64], j: usize, base: &[f64]) -> Result<Vec<f64>, Stop> {
        let coordinate = self.coordinates[j];
        if coordinate.held() {
            return Ok(vec![0.0; self.count]);
        }
        let range = coordinate.upper - coordinate.lower;
        let step = self.options.difference_step.min(0.25 * range);
        let side = |step: f64| -> Result<(f64, Vec<f64>), Stop> {
            let mut moved = y.to_vec();
            moved[j] += step;
            Ok((moved[j] - y[j], self.evaluate_afresh(&moved)?))
        };
        let up_fits = y[j] + step <= coordinate.upper;
        let down_fits = y[j] - step >= coordinate.lower;
        let difference =
            |(h, r): &(f64, Vec<f64>)| -> Vec<f64> { r.iter().zip(base).map(|(r, b)| (r - b) / h).collect() };
        let usable = |(_, r): &(f64, Vec<f64>)| r.iter().all(|r| r.is_finite());
        if self.options.difference == Difference::Central && up_fits && down_fits {
            let (up, down) = (side(step)?, side(-step)?);
            return Ok(match (usable(&up), usable(&down)) {
                (true, false) => difference(&up),
                (false, true) => difference(&down),
                _ => up.1.iter().zip(&down.1).map(|(a, b)| (a - b) / (up.0 - down.0)).collect(),
            });
        }
        let first = side(if up_fits { step } else { -step })?;
        if !usable(&first) && up_fits && down_fits {
            return Ok(difference(&side(-step)?));
        }
        Ok(difference(&first))
    }
}
