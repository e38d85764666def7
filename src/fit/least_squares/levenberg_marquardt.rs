//! Levenberg's method with Marquardt's scaling and an active set for the bounds, on sums that the caller makes.
//!
//! A joint fit to many records has unknowns that touch one record each. Its caller adds up `JᵀJ` and `Jᵀr`
//! record by record, never holding the whole Jacobian, and this file steps. The method tolerates kinks (a sample that
//! changes from stick to slip) and failures: a step that does not lower the sum is shortened and tried again.

use nalgebra::{DMatrix, DVector};

use super::outcome::Ending;

/// The sums of a problem at one point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sums {
    /// `½ Σ r²`.
    pub cost: f64,
    /// `Jᵀ r`.
    pub gradient: Vec<f64>,
    /// `Jᵀ J`, row-major.
    pub curvature: Vec<f64>,
}

/// A sum of squares as a function of coordinates of size one.
pub(crate) trait SumOfSquares {
    /// `½ Σ r²`; `None` where it cannot be evaluated.
    fn cost(&mut self, y: &[f64]) -> Option<f64>;

    /// The sums at `y`; `None` where they cannot be evaluated.
    fn sums(&mut self, y: &[f64]) -> Option<Sums>;

    /// Whether to end with the best point so far.
    fn interrupted(&self) -> bool {
        false
    }

    /// Called after every accepted step, from 1, with the cost there.
    fn accepted(&mut self, step: usize, cost: f64) {
        let _ = (step, cost);
    }
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Accepted steps.
    pub iterations: usize,
    /// Relative fall of the sum of squares that counts as none.
    pub tolerance: f64,
    /// Largest change of a coordinate that counts as none; infinite where only the fall of the sum counts.
    pub change: f64,
    /// Cost above which the end is of no use: a search that cannot come below it any more is given up.
    pub useful: f64,
    /// Trials of a step, at least one, before it is given up.
    pub trials: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            iterations: 40,
            tolerance: 1e-6,
            change: f64::INFINITY,
            useful: f64::INFINITY,
            trials: DAMPINGS,
        }
    }
}

/// Where a fit ended.
#[derive(Debug, Clone)]
pub(crate) struct End {
    /// The coordinates.
    pub y: Vec<f64>,
    /// The sums there.
    pub sums: Sums,
    /// Why it ended; `None` where the search was given up, above [`Limits::useful`].
    pub ending: Option<Ending>,
}

impl End {
    /// Fall of the cost that one more step within the bounds promises.
    pub fn promise(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let step = step(&self.sums, &self.y, lower, upper, LEAST_DAMPING);
        step.map_or(0.0, |step| promised(&self.sums, &step))
    }
}

/// Times faster than in its last step that a search may go on falling before it counts as hopeless.
const HOPE: f64 = 2.0;
/// Dampings of a step before it is given up.
const DAMPINGS: usize = 10;
/// Damping at the start, as a fraction of the curvature's diagonal.
const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-9;
/// Sum of squares, as a fraction of that at the start, which is rounding alone.
const ROUNDING: f64 = 1e-20;

/// Minimises from `y` within `[lower, upper]`; `None` when the start cannot be evaluated.
pub(crate) fn minimise(
    problem: &mut impl SumOfSquares,
    mut y: Vec<f64>,
    lower: &[f64],
    upper: &[f64],
    limits: Limits,
) -> Option<End> {
    into_bounds(&mut y, lower, upper);
    let sums = problem.sums(&y).filter(|sums| sums.cost.is_finite())?;
    let exact = ROUNDING * sums.cost;
    let mut search = Search { problem, lower, upper, y, sums, damping: FIRST_DAMPING };
    let mut ending = Some(Ending::StepLimit);
    for step in 1..=limits.iterations {
        if search.sums.cost <= exact {
            ending = Some(Ending::Converged);
            break;
        }
        let before = search.sums.cost;
        let (cost, change) = match search.step(limits) {
            Ok(accepted) => accepted,
            Err(why) => {
                ending = Some(why);
                break;
            }
        };
        search.problem.accepted(step, cost);
        let left = (limits.iterations - step) as f64;
        let reachable = cost * (cost / before).powf(HOPE * left);
        let enough = before - cost <= limits.tolerance * before && change <= limits.change;
        let given_up = !enough && reachable > limits.useful;
        match search.problem.sums(&search.y) {
            Some(there) if there.cost.is_finite() => search.sums = there,
            // Derivatives failed where the value did not: the point is kept, and the search ends.
            _ => {
                search.sums.cost = cost;
                let interrupted = search.problem.interrupted();
                ending = Some(if interrupted { Ending::Interrupted } else { Ending::Stalled });
                ending = ending.filter(|_| !given_up);
                break;
            }
        }
        if enough || given_up {
            ending = enough.then_some(Ending::Converged);
            break;
        }
    }
    Some(End { y: search.y, sums: search.sums, ending })
}

/// The state of a search.
struct Search<'a, P> {
    problem: &'a mut P,
    lower: &'a [f64],
    upper: &'a [f64],
    y: Vec<f64>,
    sums: Sums,
    damping: f64,
}

impl<P: SumOfSquares> Search<'_, P> {
    /// Moves to a lower point; its cost and the largest change of a coordinate, or why there is none.
    fn step(&mut self, Limits { tolerance, trials, .. }: Limits) -> Result<(f64, f64), Ending> {
        let mut trial = self.y.clone();
        let mut promise = None;
        let mut left = trials;
        for _ in 0..DAMPINGS {
            if self.problem.interrupted() {
                return Err(Ending::Interrupted);
            }
            let step = step(&self.sums, &self.y, self.lower, self.upper, self.damping);
            let Some(step) = step else { break };
            let last =
                std::mem::replace(&mut trial, self.y.iter().zip(&step).map(|(y, step)| y + step).collect());
            into_bounds(&mut trial, self.lower, self.upper);
            // What the bounds make of a step may be what they made of the one before.
            let cost = if trial == last {
                None
            } else {
                left -= 1;
                self.problem.cost(&trial)
            };
            if let Some(cost) = cost.filter(|cost| *cost < self.sums.cost) {
                self.damping = (0.2 * self.damping).max(LEAST_DAMPING);
                let change = trial.iter().zip(&self.y).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                self.y = trial;
                return Ok((cost, change));
            }
            self.damping *= 6.0;
            // The fall that a step promises decreases with the damping: no further fall is possible.
            let promised = promised(&self.sums, &step);
            promise.get_or_insert(promised);
            if left == 0 || promised <= 0.1 * tolerance * self.sums.cost {
                break;
            }
        }
        if self.problem.interrupted() {
            return Err(Ending::Interrupted);
        }
        // Without a step all gradients vanish or point out of the bounds.
        let flat = promise.is_none_or(|promise| promise <= tolerance.sqrt() * self.sums.cost);
        Err(if flat { Ending::Converged } else { Ending::Stalled })
    }
}

fn into_bounds(y: &mut [f64], lower: &[f64], upper: &[f64]) {
    for ((y, lower), upper) in y.iter_mut().zip(lower).zip(upper) {
        *y = y.max(*lower).min(*upper);
    }
}

/// Fall of the cost that the quadratic model promises.
fn promised(sums: &Sums, step: &[f64]) -> f64 {
    let n = step.len();
    let linear: f64 = sums.gradient.iter().zip(step).map(|(g, s)| g * s).sum();
    let quadratic: f64 =
        (0..n).map(|i| step[i] * (0..n).map(|j| sums.curvature[i * n + j] * step[j]).sum::<f64>()).sum();
    -(linear + 0.5 * quadratic)
}

/// The damped step over the coordinates that are not held at a bound; those that would leave their bounds are
/// put on them and the others stepped again. `None` when all are held.
fn step(sums: &Sums, y: &[f64], lower: &[f64], upper: &[f64], damping: f64) -> Option<Vec<f64>> {
    let n = y.len();
    let mut step = vec![0.0; n];
    let mut free: Vec<usize> = (0..n)
        .filter(|&i| {
            let outward =
                (y[i] <= lower[i] && sums.gradient[i] > 0.0) || (y[i] >= upper[i] && sums.gradient[i] < 0.0);
            !outward && sums.curvature[i * n + i] > 0.0 && upper[i] > lower[i]
        })
        .collect();
    while !free.is_empty() {
        let solved = damped(sums, &free, &step, damping)?;
        let mut left = Vec::with_capacity(free.len());
        for (&i, &move_by) in free.iter().zip(&solved) {
            let within = y[i] + move_by >= lower[i] && y[i] + move_by <= upper[i];
            if within {
                left.push(i);
            }
            step[i] = move_by.max(lower[i] - y[i]).min(upper[i] - y[i]);
        }
        if left.len() == free.len() {
            return Some(step);
        }
        left.iter().for_each(|&i| step[i] = 0.0);
        free = left;
    }
    step.iter().any(|s| *s != 0.0).then_some(step)
}

/// Solves `(A + λ diag A) s = −g − A s_held` over the `free` coordinates.
fn damped(sums: &Sums, free: &[usize], held: &[f64], damping: f64) -> Option<Vec<f64>> {
    let n = held.len();
    let size: Vec<f64> = free.iter().map(|&i| sums.curvature[i * n + i].sqrt()).collect();
    let fixed = |i: usize| -> f64 {
        (0..n).filter(|j| !free.contains(j)).map(|j| sums.curvature[i * n + j] * held[j]).sum()
    };
    let matrix = DMatrix::from_fn(free.len(), free.len(), |a, b| {
        let entry = sums.curvature[free[a] * n + free[b]] / (size[a] * size[b]);
        if a == b { entry + damping } else { entry }
    });
    let right = DVector::from_fn(free.len(), |a, _| -(sums.gradient[free[a]] + fixed(free[a])) / size[a]);
    let solution = matrix.cholesky()?.solve(&right);
    Some(solution.iter().zip(&size).map(|(s, size)| s / size).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of Rosenbrock's valley and of a line that pulls along one coordinate.
    struct Valley;

    impl SumOfSquares for Valley {
        fn cost(&mut self, y: &[f64]) -> Option<f64> {
            Some(self.sums(y)?.cost)
        }

        fn sums(&mut self, y: &[f64]) -> Option<Sums> {
            let r = [10.0 * (y[1] - y[0] * y[0]), 1.0 - y[0]];
            let j = [[-20.0 * y[0], 10.0], [-1.0, 0.0]];
            let product = |a: usize, b: usize| j[0][a] * j[0][b] + j[1][a] * j[1][b];
            Some(Sums {
                cost: 0.5 * (r[0] * r[0] + r[1] * r[1]),
                gradient: (0..2).map(|a| j[0][a] * r[0] + j[1][a] * r[1]).collect(),
                curvature: (0..4).map(|k| product(k / 2, k % 2)).collect(),
            })
        }
    }

    fn limits() -> Limits {
        Limits { iterations: 200, tolerance: 1e-14, ..Limits::default() }
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_bottom() {
        let end = minimise(&mut Valley, vec![-1.2, 1.0], &[-5.0; 2], &[5.0; 2], limits()).unwrap();
        assert!((end.y[0] - 1.0).abs() < 1e-6 && (end.y[1] - 1.0).abs() < 1e-6, "{:?}", end.y);
    }

    /// `y → y − fraction · y` a step: a parabola so flat at its bottom that steps only shrink the distance.
    struct Slow {
        exponent: i32,
        steps: usize,
    }

    impl SumOfSquares for Slow {
        fn cost(&mut self, y: &[f64]) -> Option<f64> {
            Some(0.5 * (1.0 + y[0].powi(2 * self.exponent)))
        }

        fn sums(&mut self, y: &[f64]) -> Option<Sums> {
            self.steps += 1;
            let slope = f64::from(self.exponent) * y[0].powi(self.exponent - 1);
            let gradient = vec![slope * y[0].powi(self.exponent)];
            Some(Sums { cost: self.cost(y)?, gradient, curvature: vec![slope * slope] })
        }
    }

    #[test]
    fn a_search_that_cannot_become_useful_is_given_up_and_one_that_can_is_not() {
        let steps = |useful: f64| {
            let mut slow = Slow { exponent: 4, steps: 0 };
            let limits = Limits { useful, tolerance: 1e-9, ..limits() };
            let end = minimise(&mut slow, vec![2.0], &[-5.0], &[5.0], limits).unwrap();
            (slow.steps, end.sums.cost)
        };
        // The bottom is at one half.
        let (all, cost) = steps(f64::INFINITY);
        assert!((cost - 0.5).abs() < 1e-6 && steps(0.6) == (all, cost));
        let (few, above) = steps(0.4);
        assert!(few < all && above >= cost, "{few} of {all}");
    }

    #[test]
    fn at_a_bound_the_others_find_their_minimum() {
        let end = minimise(&mut Valley, vec![-1.2, 1.0], &[-5.0; 2], &[0.5, 5.0], limits()).unwrap();
        assert!((end.y[0] - 0.5).abs() < 1e-9 && (end.y[1] - 0.25).abs() < 1e-7, "{:?}", end.y);
    }

    /// A parabola whose slope is told wrong.
    struct Misled {
        tried: Vec<f64>,
    }

    impl SumOfSquares for Misled {
        fn cost(&mut self, y: &[f64]) -> Option<f64> {
            self.tried.push(y[0]);
            Some(1.0 + y[0] * y[0])
        }

        fn sums(&mut self, y: &[f64]) -> Option<Sums> {
            Some(Sums { cost: 1.0 + y[0] * y[0], gradient: vec![-1e3], curvature: vec![1.0] })
        }
    }

    #[test]
    fn what_a_bound_makes_of_several_steps_is_tried_once_and_no_more_often_than_told() {
        let tried = |trials: usize| {
            let mut misled = Misled { tried: Vec::new() };
            let end =
                minimise(&mut misled, vec![0.0], &[-5.0], &[5.0], Limits { trials, ..limits() }).unwrap();
            assert_eq!(end.y, [0.0]);
            misled.tried
        };
        let all = tried(10);
        assert!(all.len() > 2 && all.windows(2).all(|pair| pair[1] < pair[0]) && all[0] == 5.0, "{all:?}");
        assert_eq!(tried(2), all[..2]);
    }
}
