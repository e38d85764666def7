//! A solution carried from value to value of what is varied, on steps that shorten where it is lost.

use super::tracker::{Solution, more_harmonics};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::system::PeriodicSystem;
use crate::harmonic::{CurveSettings, HarmonicError};

/// Fraction of the way from one value to the next below which it is given up.
const LEAST_FRACTION: f64 = 1e-5;
/// Change of the frequency in a step, relative, beyond which another resonance may have been taken for this.
const LARGEST_CHANGE: f64 = 0.03;

/// The last two values with their solutions, the later one first.
pub(crate) type LastSolutions = Vec<(f64, Solution)>;

/// What is carried.
pub(crate) trait StepwiseContinuation {
    /// The equations, and how they are solved.
    fn parts(&mut self) -> (&mut dyn PeriodicSystem, &CurveSettings);

    /// Where to look for the solution at `value`.
    fn start(&mut self, value: f64, reached: &LastSolutions) -> Result<Solution, HarmonicError>;

    /// Solves at `value` from what `solution` holds.
    fn solve(&mut self, value: f64, solution: &mut Solution) -> Result<Point, HarmonicError>;

    /// The solution at `value`, on smaller and smaller steps from the last one.
    fn reach(&mut self, value: f64, reached: &mut LastSolutions) -> Result<Point, HarmonicError> {
        let mut fraction = 1.0;
        loop {
            let next = reached.first().map_or(value, |(from, _)| between(*from, value, fraction));
            match self.step(next, reached) {
                Ok(point) if next == value => return Ok(point),
                Ok(_) => fraction = f64::min(2.0 * fraction, 1.0),
                Err(error) => {
                    fraction *= 0.5;
                    if reached.is_empty() || fraction < LEAST_FRACTION || !error.is_of_the_step() {
                        return Err(error);
                    }
                    self.parts().0.forget();
                }
            }
        }
    }

    /// One step to a value, with as many harmonics as it takes.
    fn step(&mut self, value: f64, reached: &mut LastSolutions) -> Result<Point, HarmonicError> {
        let mut solution = self.start(value, reached)?;
        let mut point = self.solve(value, &mut solution)?;
        loop {
            let (system, settings) = self.parts();
            let Some(harmonics) = more_harmonics(&point, settings) else { break };
            let mut vectors: Vec<&mut Vec<f64>> = vec![&mut solution.x];
            vectors.extend(reached.iter_mut().map(|(_, reached)| &mut reached.x));
            if !system.set_harmonics(harmonics, &mut vectors)? {
                break;
            }
            point = self.solve(value, &mut solution)?;
        }
        if let Some((_, last)) = reached.first() {
            let change = solution.at.angular_frequency / last.at.angular_frequency - 1.0;
            if change.abs() > LARGEST_CHANGE {
                let iterations = point.iterations;
                return Err(HarmonicError::NotConverged { residual: change.abs(), iterations });
            }
        }
        reached.insert(0, (value, solution));
        reached.truncate(2);
        Ok(point)
    }
}

/// A fraction of the way from one value to another, by ratio where both have the same sign.
fn between(from: f64, to: f64, fraction: f64) -> f64 {
    if fraction >= 1.0 || from == to {
        to
    } else if from * to > 0.0 {
        from * (to / from).powf(fraction)
    } else {
        from + fraction * (to - from)
    }
}
