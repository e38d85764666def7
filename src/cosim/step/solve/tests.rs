//! Every method on a small loop.

use super::*;

/// `residual = gain · assumed + constant + bend · assumed² − assumed`
struct Loop {
    gain: Vec<Vec<f64>>,
    constant: Vec<f64>,
    bend: f64,
    derived: bool,
    at: Vec<f64>,
}

impl Coupling for Loop {
    type Trouble = std::convert::Infallible;

    fn evaluate(&mut self, assumed: &[f64], residual: &mut [f64]) -> Result<(), Self::Trouble> {
        self.at = assumed.to_vec();
        for (row, out) in residual.iter_mut().enumerate() {
            let linear: f64 = self.gain[row].iter().zip(assumed).map(|(gain, value)| gain * value).sum();
            *out = linear + self.constant[row] + self.bend * assumed[row] * assumed[row] - assumed[row];
        }
        Ok(())
    }

    fn product(&mut self, direction: &[f64], change: &mut [f64]) -> Result<bool, Self::Trouble> {
        for (row, out) in change.iter_mut().enumerate() {
            let linear: f64 = self.gain[row].iter().zip(direction).map(|(gain, value)| gain * value).sum();
            *out = linear + (2.0 * self.bend * self.at[row] - 1.0) * direction[row];
        }
        Ok(self.derived)
    }
}

fn solve(method: Method, gain: f64, bend: f64, derived: bool) -> (Solved, f64) {
    let gains = vec![vec![gain, 0.3, 0.0], vec![-0.2, gain, 1e3], vec![1e-4, 0.0, -gain]];
    let mut coupling = Loop { gain: gains, constant: vec![1.0, -2e3, 0.5], bend, derived, at: vec![] };
    let settings = Strong { method, tolerance: 1e-10, iterations: 200 };
    let mut solver = Solver::new(settings, 3);
    let mut assumed = [0.0; 3];
    let Ok(solved) = solver.solve(&mut coupling, &mut assumed);
    let mut residual = [0.0; 3];
    let Ok(()) = coupling.evaluate(&assumed, &mut residual);
    let worst = residual.iter().zip(&assumed).map(|(r, u)| (r / u).abs()).fold(0.0, f64::max);
    (solved, worst)
}

#[test]
fn contracting_loops_converge_under_every_method() {
    let methods = [Method::FixedPoint, Method::Aitken, Method::Anderson { depth: 4 }, Method::Newton];
    for method in methods {
        let (solved, worst) = solve(method, 0.5, 0.0, true);
        assert!(solved.converged && worst < 1e-8, "{method:?} {solved:?} {worst:e}");
    }
}

#[test]
fn expanding_loops_need_more_than_a_fixed_point() {
    assert!(!solve(Method::FixedPoint, -3.0, 0.0, true).0.converged);
    for method in [Method::Anderson { depth: 4 }, Method::Newton] {
        let (solved, worst) = solve(method, -3.0, 0.0, true);
        assert!(solved.converged && worst < 1e-8, "{method:?} {solved:?} {worst:e}");
    }
}

#[test]
fn newton_solves_linear_loops_at_once_and_others_quadratically() {
    let (solved, _) = solve(Method::Newton, -3.0, 0.0, true);
    assert_eq!(solved.evaluations, 2);
    let (solved, worst) = solve(Method::Newton, -3.0, 1e-4, true);
    assert!(solved.converged && solved.evaluations <= 7 && worst < 1e-8, "{solved:?} {worst:e}");
    // By repeated evaluations: three more for each step.
    let (solved, worst) = solve(Method::Newton, -3.0, 1e-4, false);
    assert!(solved.converged && solved.evaluations <= 30 && worst < 1e-8, "{solved:?} {worst:e}");
}
