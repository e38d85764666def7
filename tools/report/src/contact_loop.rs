//! Loops of the contacts, by the contact law itself.
//!
//! A Fourier series of the force would ring at its corners (Gibbs); the law along the displacement's
//! series does not.

use std::f64::consts::TAU;

use stickslip::contact::{ContactLaw, Inputs, Period, PeriodicSolver};
use stickslip::harmonic::fourier::{time_derivative, value};

/// Samples of a period.
const SAMPLES: usize = 360;

/// Displacement (m) and force (N) over one period, closed, for the displacement coefficients
/// `[a0, c1, s1, …]`; nothing where the law does not come to a periodic state.
pub fn contact_loop(
    law: &dyn ContactLaw,
    normal_load: f64,
    angular_frequency: f64,
    coefficients: &[f64],
) -> Option<(Vec<f64>, Vec<f64>)> {
    let rate = time_derivative(coefficients, 1, angular_frequency);
    let phases = || (0..SAMPLES).map(|k| TAU * k as f64 / SAMPLES as f64);
    let mut displacement: Vec<f64> = phases().map(|phase| value(coefficients, phase)).collect();
    let mut velocity: Vec<f64> = phases().map(|phase| value(&rate, phase)).collect();
    // A stuck contact keeps what it remembers: a contact without history is loaded to the largest displacement.
    let largest = (0..SAMPLES).max_by(|&a, &b| displacement[a].abs().total_cmp(&displacement[b].abs()))?;
    displacement.rotate_left(largest);
    velocity.rotate_left(largest);
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, normal_load, 0.0, &mut state);
    let first = Inputs { displacement: displacement[0], velocity: velocity[0], normal_load };
    let mut loaded = state.clone();
    law.step(&state, first, &mut loaded);
    let period = Period { displacement: &displacement, velocity: &velocity, normal_load: &[normal_load] };
    let mut solver = PeriodicSolver::new();
    solver.solve(law, &period, &mut loaded).ok()?;
    let mut force = vec![0.0; SAMPLES];
    solver.trace(law, &period, &mut loaded, &mut force).ok()?;
    force.push(force[0]);
    displacement.push(displacement[0]);
    Some((displacement, force))
}

#[cfg(test)]
mod tests {
    use stickslip::contact::Jenkins;

    use super::*;

    #[test]
    fn loop_area_of_a_jenkins_element_is_four_limits_times_the_slip() {
        let law = Jenkins::new(2e6, 0.5).unwrap();
        let (amplitude, limit) = (1e-4, 50.0);
        let (u, force) = contact_loop(&law, 100.0, 3.0, &[0.0, 0.6 * amplitude, 0.8 * amplitude]).unwrap();
        assert_eq!((u.len(), force.len()), (SAMPLES + 1, SAMPLES + 1));
        let area: f64 = (0..SAMPLES).map(|k| 0.5 * (force[k] + force[k + 1]) * (u[k + 1] - u[k])).sum();
        let expected = 4.0 * limit * (amplitude - limit / 2e6);
        assert!((area / expected - 1.0).abs() < 1e-3, "{area} {expected}");
        assert!((force[0] - force[SAMPLES]).abs() < 1e-9);
    }

    #[test]
    fn a_stuck_contact_shows_a_line_through_the_origin() {
        let law = Jenkins::new(2e6, 0.5).unwrap();
        let (u, force) = contact_loop(&law, 100.0, 3.0, &[0.0, 1e-5, 0.0]).unwrap();
        assert!(u.iter().zip(&force).all(|(u, force)| (force - 2e6 * u).abs() < 1e-9));
    }
}
