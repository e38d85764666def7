//! The residual as a function of coordinates: failures, counters and finite differences.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::coordinate::Coordinate;
use super::options::{Difference, Options};

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
