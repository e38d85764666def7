//! Newton's method with a line search on the residual's norm.

use nalgebra::{DMatrix, DVector};

use super::{HarmonicError, Settings};

/// Equations `r(x) = 0` that leave residual and Jacobian in buffers of their own.
pub(crate) trait Equations {
    /// Evaluates both at `x`; returns the size of the terms that make up the residual.
    fn evaluate(&mut self, x: &[f64]) -> Result<f64, HarmonicError>;
    /// Residual of the last evaluation.
    fn residual(&self) -> &[f64];
    /// Hands out the Jacobian of the last evaluation, whose content is no longer needed after.
    fn jacobian(&self) -> &DMatrix<f64>;
    /// Largest share of the step that keeps `x` sensible (positive frequency), at most 1.
    fn longest_step(&self, x: &[f64], step: &[f64]) -> f64;
}

/// How a solution was reached.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    pub iterations: usize,
    /// Largest residual as share of the largest force.
    pub residual: f64,
}

/// Solves from `x`, which holds the solution after.
pub(crate) fn solve(
    equations: &mut impl Equations,
    x: &mut [f64],
    settings: &Settings,
) -> Result<Effort, HarmonicError> {
    let mut trial = x.to_vec();
    let mut scale = equations.evaluate(x)?;
    let mut iterations = 0;
    loop {
        let residual = relative_residual(equations.residual(), scale);
        if residual <= settings.tolerance {
            return Ok(Effort { iterations, residual });
        }
        if iterations == settings.max_iterations || residual.is_nan() {
            return Err(HarmonicError::NotConverged { residual, iterations });
        }
        let norm = length(equations.residual());
        let mut step = DVector::from_column_slice(equations.residual());
        let solved = equations.jacobian().clone().lu().solve_mut(&mut step);
        if !solved || step.iter().any(|s| !s.is_finite()) {
            return Err(HarmonicError::NotConverged { residual, iterations });
        }
        step.neg_mut();
        let mut share = equations.longest_step(x, step.as_slice());
        let mut halvings = 0;
        scale = loop {
            for ((t, x), s) in trial.iter_mut().zip(x.iter()).zip(step.iter()) {
                *t = x + share * s;
            }
            match equations.evaluate(&trial) {
                Ok(scale) if length(equations.residual()) <= (1.0 - 1e-4 * share) * norm => break scale,
                // At the accuracy of the contact's periodic state the norm cannot fall any more.
                Ok(scale) if relative_residual(equations.residual(), scale) <= settings.tolerance => {
                    break scale;
                }
                _ if halvings == 12 => return Err(HarmonicError::NotConverged { residual, iterations }),
                _ => {
                    share *= 0.5;
                    halvings += 1;
                }
            }
        };
        x.copy_from_slice(&trial);
        iterations += 1;
    }
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn relative_residual(residual: &[f64], scale: f64) -> f64 {
    let mut largest = 0.0_f64;
    for r in residual {
        if r.is_nan() {
            return f64::NAN;
        }
        largest = largest.max(r.abs());
    }
    if scale > 0.0 { largest / scale } else { largest }
}
