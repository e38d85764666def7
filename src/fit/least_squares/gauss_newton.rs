//! Bounded least squares for a caller that has derivatives and sums them itself.
//!
//! A joint fit to many records has unknowns that touch one record each. Its caller adds up `JᵀJ` and `Jᵀr`
//! record by record, never holding the whole Jacobian, and this file steps: Levenberg's method with
//! Marquardt's scaling, an active set for the bounds. The method tolerates kinks (a sample that changes from
//! stick to slip): a step that does not lower the sum is shortened and tried again.

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
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Accepted steps.
    pub iterations: usize,
    /// Relative fall of the sum of squares that counts as none.
    pub tolerance: f64,
    /// Cost above which the end is of no use: a search that cannot come below it any more is given up.
    pub useful: f64,
}

/// Times faster than in its last step that a search may go on falling before it counts as hopeless.
const HOPE: f64 = 2.0;

/// Where a fit ended.
#[derive(Debug, Clone)]
pub(crate) struct End {
    /// The coordinates.
    pub y: Vec<f64>,
    /// The sums there.
    pub sums: Sums,
    /// Whether the search was given up, above [`Limits::useful`].
    pub given_up: bool,
}

/// Failed trials of a step before the point is taken for a minimum.
const TRIALS: usize = 10;
/// Damping at the start, as a share of the curvature's diagonal.
const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-9;

/// Minimises from `y` within `[lower, upper]`; `None` when the start cannot be evaluated.
pub(crate) fn minimise(
    problem: &mut impl SumOfSquares,
    mut y: Vec<f64>,
    lower: &[f64],
    upper: &[f64],
    limits: Limits,
) -> Option<End> {
    into_bounds(&mut y, lower, upper);
    let mut sums = problem.sums(&y).filter(|sums| sums.cost.is_finite())?;
    let mut damping = FIRST_DAMPING;
    let mut trial = y.clone();
    for iteration in 1..=limits.iterations {
        let mut accepted = None;
        for _ in 0..TRIALS {
            if problem.interrupted() {
                return Some(End { y, sums, given_up: false });
            }
            let Some(step) = step(&sums, &y, lower, upper, damping) else { break };
            for (trial, (y, step)) in trial.iter_mut().zip(y.iter().zip(&step)) {
                *trial = y + step;
            }
            into_bounds(&mut trial, lower, upper);
            let cost = problem.cost(&trial).filter(|cost| *cost < sums.cost);
            if let Some(cost) = cost {
                damping = (0.2 * damping).max(LEAST_DAMPING);
                accepted = Some(cost);
                break;
            }
            damping *= 6.0;
            // What a step promises falls with the damping: nothing is to be had any more.
            if promised(&sums, &step) <= 0.1 * limits.tolerance * sums.cost {
                break;
            }
        }
        let Some(cost) = accepted else { return Some(End { y, sums, given_up: false }) };
        let fall = sums.cost - cost;
        let left = (limits.iterations - iteration) as f64;
        let reachable = cost * (cost / sums.cost).powf(HOPE * left);
        let enough = fall <= limits.tolerance * sums.cost;
        let given_up = !enough && reachable > limits.useful;
        y.copy_from_slice(&trial);
        match problem.sums(&y) {
            Some(there) if there.cost.is_finite() => sums = there,
            // Derivatives failed where the value did not: the point stands, without a way on.
            _ => return Some(End { y, sums: Sums { cost, ..sums }, given_up }),
        }
        if enough || given_up {
            return Some(End { y, sums, given_up });
        }
    }
    Some(End { y, sums, given_up: false })
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
    let matrix = nalgebra::DMatrix::from_fn(free.len(), free.len(), |a, b| {
        let entry = sums.curvature[free[a] * n + free[b]] / (size[a] * size[b]);
        if a == b { entry + damping } else { entry }
    });
    let right =
        nalgebra::DVector::from_fn(free.len(), |a, _| -(sums.gradient[free[a]] + fixed(free[a])) / size[a]);
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

    const LIMITS: Limits = Limits { iterations: 200, tolerance: 1e-14, useful: f64::INFINITY };

    #[test]
    fn a_curved_valley_is_followed_to_its_bottom() {
        let end = minimise(&mut Valley, vec![-1.2, 1.0], &[-5.0; 2], &[5.0; 2], LIMITS).unwrap();
        assert!((end.y[0] - 1.0).abs() < 1e-6 && (end.y[1] - 1.0).abs() < 1e-6, "{:?}", end.y);
    }

    /// `y → y − share · y` a step: a parabola so flat at its bottom that steps only shrink the distance.
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
            let limits = Limits { useful, tolerance: 1e-9, ..LIMITS };
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
        let end = minimise(&mut Valley, vec![-1.2, 1.0], &[-5.0; 2], &[0.5, 5.0], LIMITS).unwrap();
        assert!((end.y[0] - 0.5).abs() < 1e-9 && (end.y[1] - 0.25).abs() < 1e-7, "{:?}", end.y);
    }
}
