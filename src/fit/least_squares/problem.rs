//! The caller's residual as a sum of squares over coordinates: failures, counters, finite differences.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::coordinate::Coordinate;
use super::levenberg_marquardt::{SumOfSquares, Sums};
use super::options::{Difference, Options, Progress};

/// The residual with what is counted of it.
pub(super) struct Residual<'a, R, E> {
    residual: &'a R,
    pub coordinates: &'a [Coordinate],
    pub count: usize,
    pub options: &'a Options<'a>,
    evaluations: AtomicUsize,
    failures: AtomicUsize,
    first_error: Mutex<Option<E>>,
}

/// Asked to stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stop;

impl<'a, R, E> Residual<'a, R, E>
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

    /// Whether the caller wants the end.
    pub fn interrupted(&self) -> bool {
        self.options.interrupt.is_some_and(|interrupt| interrupt())
    }

    pub fn values(&self, y: &[f64]) -> Vec<f64> {
        self.coordinates.iter().zip(y).map(|(c, y)| c.value(*y)).collect()
    }

    /// Residuals at `y`; NaN throughout when the evaluation failed.
    pub fn at(&self, y: &[f64]) -> Vec<f64> {
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

    fn unless_stopped(&self, y: &[f64]) -> Result<Vec<f64>, Stop> {
        if self.interrupted() { Err(Stop) } else { Ok(self.at(y)) }
    }

    /// ∂residual/∂y about `y` with the residuals `base`, column by column; the columns are evaluated in parallel, each
    /// on its own, so that the result does not depend on the number of threads. A column is taken from the other side
    /// where an evaluation fails, and is NaN if both sides fail.
    pub fn jacobian(&self, y: &[f64], base: &[f64]) -> Result<Vec<Vec<f64>>, Stop> {
        (0..y.len()).into_par_iter().map(|j| self.column(y, j, base)).collect()
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
            Ok((moved[j] - y[j], self.unless_stopped(&moved)?))
        };
        let up_fits = y[j] + step <= coordinate.upper;
        let down_fits = y[j] - step >= coordinate.lower;
        let difference = |(h, mut r): (f64, Vec<f64>), base: &[f64]| {
            r.iter_mut().zip(base).for_each(|(r, b)| *r = (*r - b) / h);
            r
        };
        let usable = |(_, r): &(f64, Vec<f64>)| r.iter().all(|r| r.is_finite());
        if self.options.difference == Difference::Central && up_fits && down_fits {
            let (up, down) = (side(step)?, side(-step)?);
            return Ok(match (usable(&up), usable(&down)) {
                (true, false) => difference(up, base),
                (false, true) => difference(down, base),
                _ => difference((up.0 - down.0, up.1), &down.1),
            });
        }
        let first = side(if up_fits { step } else { -step })?;
        if !usable(&first) && up_fits && down_fits {
            return Ok(difference(side(-step)?, base));
        }
        Ok(difference(first, base))
    }
}

/// One start's search.
pub(super) struct Run<'p, 'a, R, E> {
    pub residual: &'p Residual<'a, R, E>,
    /// Which start it is.
    pub start: usize,
    /// The last point tried, with its residuals.
    tried: (Vec<f64>, Vec<f64>),
    /// The last point accepted, with its residuals: they are kept while others are tried from it.
    accepted: (Vec<f64>, Vec<f64>),
    /// The last point differentiated, with the columns of the Jacobian.
    differentiated: (Vec<f64>, Vec<Vec<f64>>),
}

impl<'p, 'a, R, E> Run<'p, 'a, R, E>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    pub fn new(residual: &'p Residual<'a, R, E>, start: usize) -> Self {
        Self {
            residual,
            start,
            tried: Default::default(),
            accepted: Default::default(),
            differentiated: Default::default(),
        }
    }

    /// Residuals at `y`, an accepted point, known or not, interrupted or not.
    fn residuals(&mut self, y: &[f64]) -> &[f64] {
        if self.accepted.0 != y {
            let known = self.tried.0 == y;
            self.accepted =
                if known { std::mem::take(&mut self.tried) } else { (y.to_vec(), self.residual.at(y)) };
        }
        &self.accepted.1
    }

    /// Finds residuals and the Jacobian's columns at `y`; none when interrupted before they are known.
    fn differentiate(&mut self, y: &[f64]) -> Option<()> {
        self.residuals(y);
        if self.differentiated.0 != y {
            self.differentiated = Default::default();
            self.differentiated = (y.to_vec(), self.residual.jacobian(y, &self.accepted.1).ok()?);
            // What was interrupted may have come back without being whole.
            if self.residual.interrupted() {
                self.differentiated = Default::default();
                return None;
            }
        }
        Some(())
    }

    /// Residuals at `y`, and the Jacobian's columns unless it was interrupted before they are known.
    pub fn end(mut self, y: &[f64]) -> (Vec<f64>, Option<Vec<Vec<f64>>>) {
        let known = self.differentiate(y);
        (self.accepted.1, known.map(|()| self.differentiated.1))
    }
}

pub(super) fn half_square(residuals: &[f64]) -> f64 {
    0.5 * residuals.iter().map(|r| r * r).sum::<f64>()
}

impl<R, E> SumOfSquares for Run<'_, '_, R, E>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    fn cost(&mut self, y: &[f64]) -> Option<f64> {
        let residuals = self.residual.unless_stopped(y).ok()?;
        let cost = half_square(&residuals);
        self.tried = (y.to_vec(), residuals);
        Some(cost)
    }

    fn sums(&mut self, y: &[f64]) -> Option<Sums> {
        if self.residual.interrupted() {
            return None;
        }
        let cost = half_square(self.residuals(y));
        if !cost.is_finite() {
            return None;
        }
        self.differentiate(y)?;
        let (residuals, columns) = (&self.accepted.1, &self.differentiated.1);
        // What cannot be differentiated stays where it is.
        let product = |a: &[f64], b: &[f64]| {
            let sum = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            if sum.is_finite() { sum } else { 0.0 }
        };
        Some(Sums {
            cost,
            gradient: columns.iter().map(|column| product(column, residuals)).collect(),
            curvature: columns.iter().flat_map(|a| columns.iter().map(|b| product(a, b))).collect(),
        })
    }

    fn interrupted(&self) -> bool {
        self.residual.interrupted()
    }

    fn accepted(&mut self, step: usize, cost: f64) {
        if let Some(progress) = self.residual.options.progress {
            progress(&Progress {
                start: self.start,
                starts: self.residual.options.starts,
                iteration: step,
                root_mean_square: (2.0 * cost / self.residual.count as f64).sqrt(),
                evaluations: self.residual.evaluations(),
            });
        }
    }
}
