//! Balance equations with conditions on top: Newton's method on unknowns and free scalars together.

use super::system::{Observation, Operating, PeriodicSystem, Scalar};
use crate::harmonic::HarmonicError;
use crate::harmonic::settings::Interrupt;
use crate::numeric::lu::Factors;

/// Gradient of a condition.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ConditionRow {
    /// By the unknowns.
    pub by_unknowns: Vec<f64>,
    /// By the scalars, in the order of [`Scalar`].
    pub by_scalars: [f64; 4],
    /// What it sees of outputs, beside the above.
    pub seen: Vec<Seen>,
}

/// Weights of the cosine and the sine of an output's harmonic in a gradient: their derivatives take an effort that a
/// solution does not ask for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen {
    /// Which output.
    pub node: usize,
    /// Which harmonic.
    pub order: usize,
    /// The weights.
    pub weights: [f64; 2],
}

/// A scalar equation beside the balance.
pub(crate) trait Condition {
    /// Value at the system's last evaluation, which was at `x` and `at`, and its gradient; `row` comes zeroed
    /// and as long as `x`. The value is relative: 1 is a complete miss.
    fn evaluate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        x: &[f64],
        at: &Operating,
        row: &mut ConditionRow,
    ) -> f64;
}

/// A residual this many times the tolerance is accepted where it does not fall any more.
const STALLED: f64 = 1e3;
/// A residual larger than this is never taken for rounding.
const LARGEST_ROUNDING: f64 = 1e-6;
/// … after a step that changes the unknowns by this fraction at most.
const SMALL_STEP: f64 = 1e-6;

/// Halvings of a step where no more is known of how near the solution is.
pub(crate) const HALVINGS: usize = 12;

/// When a solution is good enough, and when it is given up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stopping {
    /// Largest residual accepted, as a fraction of the largest term; the conditions count in full.
    pub tolerance: f64,
    /// Newton steps at most.
    pub max_iterations: usize,
    /// Longest step wanted, as multiple of the unknowns, from which the solution is still near.
    pub reach: f64,
    /// Halvings of a step without a smaller residual after which it is given up.
    pub halvings: usize,
    /// Asked before every evaluation.
    pub interrupt: Option<Interrupt>,
}

impl Stopping {
    /// Ends the work where that is asked for.
    fn look(&self) -> Result<(), HarmonicError> {
        if self.interrupt.is_some_and(|Interrupt(asked)| asked()) {
            Err(HarmonicError::Interrupted)
        } else {
            Ok(())
        }
    }
}

/// How a solution was reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Effort {
    /// Newton steps made.
    pub iterations: usize,
    /// Largest relative residual left.
    pub residual: f64,
}

/// Solves balance and conditions for `x` and the scalars `free`, as many as there are conditions, starting
/// from what they hold; on failure they hold the last iterate. For many solves keep a [`Newton`].
pub(crate) fn solve(
    system: &mut dyn PeriodicSystem,
    x: &mut [f64],
    at: &mut Operating,
    free: &[Scalar],
    conditions: &mut [&mut dyn Condition],
    stopping: &Stopping,
) -> Result<Effort, HarmonicError> {
    Newton::default().solve(system, x, at, free, conditions, stopping)
}

/// Newton's method with a line search, and its buffers.
///
/// Rows of the balance are divided by the size of their terms, so that all residuals are relative.
#[derive(Debug, Default)]
pub(crate) struct Newton {
    factors: Factors,
    residual: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    rows: Vec<ConditionRow>,
    observation: Observation,
    scale: f64,
    factored: bool,
}

impl Newton {
    /// As the function [`solve`].
    pub fn solve(
        &mut self,
        system: &mut dyn PeriodicSystem,
        x: &mut [f64],
        at: &mut Operating,
        free: &[Scalar],
        conditions: &mut [&mut dyn Condition],
        stopping: &Stopping,
    ) -> Result<Effort, HarmonicError> {
        debug_assert_eq!(free.len(), conditions.len());
        self.factored = false;
        stopping.look()?;
        self.evaluate(system, x, at, free, conditions)?;
        let mut residual = largest(&self.residual);
        let mut before = f64::INFINITY;
        let mut iterations = 0;
        loop {
            let settled = |system: &mut dyn PeriodicSystem| {
                residual <= LARGEST_ROUNDING && largest(&self.residual[x.len()..]) <= stopping.tolerance && {
                    residual <= system.rounding(at)
                }
            };
            if residual <= stopping.tolerance || settled(system) {
                return Ok(Effort { iterations, residual });
            }
            if iterations == stopping.max_iterations || residual.is_nan() {
                return Err(HarmonicError::NotConverged { residual, iterations });
            }
            // Under quadratic convergence a step with the last factors leaves 2 r²/r_before: often enough.
            let chord = self.factored && 4.0 * residual * residual <= stopping.tolerance * before;
            if !chord && !self.factor(system, free) {
                return Err(HarmonicError::NotConverged { residual, iterations });
            }
            stopping.look()?;
            let norm = length(&self.residual);
            self.step.clear();
            self.step.extend(self.residual.iter().map(|r| -r));
            self.factors.solve(&mut self.step);
            if self.step.iter().any(|s| !s.is_finite()) {
                return Err(HarmonicError::NotConverged { residual, iterations });
            }
            if length(&self.step[..x.len()]) > stopping.reach * length(x) {
                return Err(HarmonicError::NotConverged { residual, iterations });
            }
            before = residual;
            residual = match self.search(system, x, at, free, conditions, norm, stopping) {
                Some(smaller) => smaller,
                // The compliances of a large structure are only as good as its condition allows: there
                // the residual stops falling before it meets the tolerance.
                None if residual <= STALLED * stopping.tolerance
                    && length(&self.step[..x.len()]) <= SMALL_STEP * length(x) =>
                {
                    self.evaluate(system, x, at, free, conditions)?;
                    return Ok(Effort { iterations, residual });
                }
                None => {
                    stopping.look()?;
                    return Err(HarmonicError::NotConverged { residual, iterations });
                }
            };
            iterations += 1;
        }
    }

    /// Makes sure that there are factors: of the last Newton step or, where the start was already the solution,
    /// of the last evaluation. False where the matrix is singular.
    pub fn prepare(&mut self, system: &mut dyn PeriodicSystem, free: &[Scalar]) -> bool {
        self.factored || self.factor(system, free)
    }

    /// Factors the matrix of the last evaluation anew: a direction is then as good as the solution.
    pub fn refactor(&mut self, system: &mut dyn PeriodicSystem, free: &[Scalar]) -> bool {
        self.factor(system, free)
    }

    /// Solves with the factors there are: `right` has an entry per unknown, relative to the size of the
    /// balance's terms, and one per condition. False where the result is not finite.
    pub fn solve_linear(&self, right: &mut [f64]) -> bool {
        self.factors.solve(right);
        right.iter().all(|value| value.is_finite())
    }

    /// Sign of the determinant of the matrix factored last.
    pub fn orientation(&self) -> f64 {
        self.factors.orientation()
    }

    /// Size of the terms of the balance at the last evaluation.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The longest sensible step along the direction found, then halves until the residual falls. Returns
    /// the new residual; `x` and `at` are moved.
    #[expect(clippy::too_many_arguments, reason = "the problem's four parts, and what is known of them")]
    fn search(
        &mut self,
        system: &mut dyn PeriodicSystem,
        x: &mut [f64],
        at: &mut Operating,
        free: &[Scalar],
        conditions: &mut [&mut dyn Condition],
        norm: f64,
        stopping: &Stopping,
    ) -> Option<f64> {
        let n = x.len();
        let mut fraction = longest_fraction(at, free, &self.step[n..]);
        for _ in 0..=stopping.halvings {
            stopping.look().ok()?;
            let mut moved = *at;
            let mut trial = std::mem::take(&mut self.trial);
            trial.clear();
            trial.extend(x.iter().zip(&self.step).map(|(x, s)| x + fraction * s));
            for (scalar, step) in free.iter().zip(&self.step[n..]) {
                moved.set(*scalar, at.get(*scalar) + fraction * step);
            }
            let done = self.evaluate(system, &trial, &moved, free, conditions).is_ok();
            self.trial = trial;
            let residual = largest(&self.residual);
            // At the accuracy of the contacts' periodic states the norm cannot fall any more.
            if done
                && (length(&self.residual) <= (1.0 - 1e-4 * fraction) * norm
                    || residual <= stopping.tolerance)
            {
                x.copy_from_slice(&self.trial);
                *at = moved;
                return Some(residual);
            }
            fraction *= 0.5;
        }
        None
    }

    fn evaluate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        x: &[f64],
        at: &Operating,
        free: &[Scalar],
        conditions: &mut [&mut dyn Condition],
    ) -> Result<(), HarmonicError> {
        let scale = system.evaluate(x, at, free)?;
        self.scale = if scale > 0.0 { scale } else { 1.0 };
        self.residual.clear();
        self.residual.extend(system.residual().iter().map(|r| r / self.scale));
        self.rows.resize_with(conditions.len(), ConditionRow::default);
        for (condition, row) in conditions.iter_mut().zip(&mut self.rows) {
            row.by_unknowns.clear();
            row.by_unknowns.resize(x.len(), 0.0);
            row.by_scalars = [0.0; 4];
            row.seen.clear();
            self.residual.push(condition.evaluate(system, x, at, row));
        }
        Ok(())
    }

    /// Completes the conditions' gradients by what they see of the outputs.
    fn look(&mut self, system: &mut dyn PeriodicSystem) {
        for row in &mut self.rows {
            for Seen { node, order, weights } in row.seen.drain(..) {
                system.observe(node, order, &mut self.observation);
                for (part, weight) in weights.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0) {
                    let gradient = row.by_unknowns.iter_mut().zip(&self.observation.by_unknowns[part]);
                    gradient.for_each(|(r, d)| *r += weight * d);
                    let gradient = row.by_scalars.iter_mut().zip(&self.observation.by_scalars[part]);
                    gradient.for_each(|(r, d)| *r += weight * d);
                }
            }
        }
    }

    fn factor(&mut self, system: &mut dyn PeriodicSystem, free: &[Scalar]) -> bool {
        let n = system.unknowns();
        let size = n + free.len();
        let weight = 1.0 / self.scale;
        system.jacobian();
        self.look(system);
        let matrix = self.factors.reset(size);
        for (k, source) in system.jacobian().as_slice().chunks_exact(n.max(1)).enumerate() {
            let column = &mut matrix[k * size..(k + 1) * size];
            column.iter_mut().zip(source).for_each(|(c, s)| *c = s * weight);
            column[n..].iter_mut().zip(&self.rows).for_each(|(c, row)| *c = row.by_unknowns[k]);
        }
        for (k, scalar) in free.iter().enumerate() {
            let column = &mut matrix[(n + k) * size..(n + k + 1) * size];
            column.iter_mut().zip(system.by(*scalar)).for_each(|(c, s)| *c = s * weight);
            let rows = column[n..].iter_mut().zip(&self.rows);
            rows.for_each(|(c, row)| *c = row.by_scalars[scalar.index()]);
        }
        self.factored = self.factors.factor();
        self.factored
    }
}

/// Keeps the frequency positive: at most halved in a step.
fn longest_fraction(at: &Operating, free: &[Scalar], step: &[f64]) -> f64 {
    let frequency = free.iter().position(|scalar| *scalar == Scalar::AngularFrequency);
    frequency.map_or(1.0, |k| {
        let fall = -step[k];
        if fall > 0.5 * at.angular_frequency { 0.5 * at.angular_frequency / fall } else { 1.0 }
    })
}

/// Euclidean norm.
pub(crate) fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Largest magnitude; NaN where there is one.
pub(crate) fn largest(v: &[f64]) -> f64 {
    // Four side by side, which the processor does at once.
    let (mut most, mut no_number) = ([0.0_f64; 4], [0_u64; 4]);
    let mut compare = |x: &[f64]| {
        for ((most, no_number), x) in most.iter_mut().zip(&mut no_number).zip(x) {
            let size = x.abs();
            *most = if size > *most { size } else { *most };
            *no_number |= u64::from(x.is_nan());
        }
    };
    let (fours, rest) = v.as_chunks::<4>();
    fours.iter().for_each(|four| compare(four));
    compare(rest);
    if no_number.iter().any(|found| *found != 0) { f64::NAN } else { most.into_iter().fold(0.0, f64::max) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harmonic::newton::Point;
    use crate::system::System;
    use nalgebra::{DMatrix, dmatrix};
    use std::f64::consts::PI;

    /// `atan(steepness · x) = 0`, whose tangents lead the farther beyond the solution the steeper it is.
    struct Arctangent {
        steepness: f64,
        residual: [f64; 1],
        jacobian: DMatrix<f64>,
    }

    impl PeriodicSystem for Arctangent {
        fn unknowns(&self) -> usize {
            1
        }

        fn evaluate(&mut self, x: &[f64], _: &Operating, _: &[Scalar]) -> Result<f64, HarmonicError> {
            let x = self.steepness * x[0];
            self.residual = [x.atan()];
            self.jacobian = dmatrix![self.steepness / (1.0 + x * x)];
            Ok(1.0)
        }

        fn residual(&self) -> &[f64] {
            &self.residual
        }

        fn jacobian(&mut self) -> &DMatrix<f64> {
            &self.jacobian
        }

        fn by(&self, _: Scalar) -> &[f64] {
            &[0.0]
        }

        fn output(&mut self, _: usize, _: usize) -> [f64; 2] {
            [0.0; 2]
        }

        fn observe(&mut self, _: usize, _: usize, _: &mut Observation) {}

        fn forget(&mut self) {}

        fn nodes(&self) -> usize {
            0
        }

        fn harmonics(&self) -> usize {
            0
        }

        fn guess(&mut self, _: &Operating, _: &mut [f64]) -> Result<(), HarmonicError> {
            Ok(())
        }

        fn replace_laws(&mut self, _: &System) -> Result<(), HarmonicError> {
            Ok(())
        }

        fn describe(&mut self, _: &[f64], _: &Operating) -> Result<Point, HarmonicError> {
            Err(HarmonicError::InvalidInput("there is no response"))
        }
    }

    /// From one, a step must become shorter than 2 over its π/2 times the steepness.
    #[test]
    fn a_step_is_halved_as_often_as_allowed_and_then_given_up() {
        let solved = |steepness: f64, halvings: usize| {
            let mut system = Arctangent { steepness, residual: [0.0], jacobian: dmatrix![0.0] };
            let (mut x, mut at) = ([1.0], Operating::forced(1.0, 1.0));
            let stopping = Stopping {
                tolerance: 1e-12,
                max_iterations: 40,
                reach: f64::INFINITY,
                halvings,
                interrupt: None,
            };
            solve(&mut system, &mut x, &mut at, &[], &mut [], &stopping)
        };
        for steepness in [0.5, 20.0, 2000.0] {
            let needed = (steepness * PI / 4.0).log2().ceil().max(0.0) as usize;
            assert!(solved(steepness, needed).is_ok(), "{steepness}");
            if needed > 0 {
                let error = solved(steepness, needed - 1).unwrap_err();
                assert!(
                    matches!(error, HarmonicError::NotConverged { iterations: 0, .. }),
                    "{steepness}: {error}"
                );
            }
        }
    }

    #[test]
    fn the_largest_magnitude_is_found_wherever_it_lies_and_so_is_what_is_no_number() {
        for count in 1..11 {
            for place in 0..count {
                let mut v = vec![1.0; count];
                v[place] = -2.0;
                assert_eq!(largest(&v), 2.0, "{place} of {count}");
                v[place] = f64::NEG_INFINITY;
                assert_eq!(largest(&v), f64::INFINITY, "{place} of {count}");
                v[place] = f64::NAN;
                assert!(largest(&v).is_nan(), "{place} of {count}");
            }
        }
        assert_eq!(largest(&[]), 0.0);
    }
}
