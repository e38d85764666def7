//! Loops of the contacts, by the contact law itself.
//!
//! A Fourier series of the force would ring at its corners (Gibbs); the law along the displacement's
//! series does not.

use std::f64::consts::TAU;

use stickslip::contact::{
    ContactLaw, Inputs, Period, PeriodicSolver, SlipSlap, SlipSlapInputs, SlipSlapWork,
};
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

/// Samples of a period of a contact in two directions, and most periods until it repeats itself.
const FINE: usize = 1440;
const MOST_PERIODS: usize = 300;
/// Change of the state in a period, as a fraction of its largest part, that is none in a figure.
const CLOSED: f64 = 1e-6;

/// The same along ξ and η of a contact in two directions, for the coefficients of both.
pub fn slip_slap_loops(
    contact: &SlipSlap,
    angular_frequency: f64,
    coefficients: [&[f64]; 2],
) -> Option<[(Vec<f64>, Vec<f64>); 2]> {
    let rates = coefficients.map(|u| time_derivative(u, 1, angular_frequency));
    let at = |k: usize| {
        let phase = TAU * k as f64 / FINE as f64;
        SlipSlapInputs {
            displacement: coefficients.map(|u| value(u, phase)),
            velocity: [value(&rates[0], phase), value(&rates[1], phase)],
        }
    };
    let motion: Vec<SlipSlapInputs> = (0..FINE).map(at).collect();
    let far = |k: &usize| motion[*k].displacement[0].abs();
    let largest = (0..FINE).max_by(|a, b| far(a).total_cmp(&far(b)))?;
    let mut state = vec![0.0; contact.state_len()];
    contact.set_state([0.0; 2], 0.0, &mut state);
    let (mut next, mut work) = (state.clone(), SlipSlapWork::default());
    let mut step = |state: &mut Vec<f64>, k: usize| {
        let response = contact.step(state, motion[k % FINE], &mut next, &mut work);
        std::mem::swap(state, &mut next);
        response.force
    };
    step(&mut state, largest);
    for _ in 0..MOST_PERIODS {
        let before = state.clone();
        let mut size = vec![0.0_f64; state.len()];
        for k in 1..=FINE {
            step(&mut state, largest + k);
            size.iter_mut().zip(&state).for_each(|(size, x)| *size = size.max(x.abs()));
        }
        let changes = state.iter().zip(&before).zip(&size);
        if changes.into_iter().all(|((now, before), size)| (now - before).abs() <= CLOSED * size) {
            let mut loops: [(Vec<f64>, Vec<f64>); 2] = Default::default();
            for k in 0..=FINE {
                let force = step(&mut state, largest + 1 + k);
                let here = motion[(largest + 1 + k) % FINE].displacement;
                for (direction, (u, f)) in loops.iter_mut().enumerate() {
                    u.push(here[direction]);
                    f.push(force[direction]);
                }
            }
            return Some(loops);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #[test]
    fn loops_of_two_directions_are_those_of_the_friction_and_of_the_spring() {
        use stickslip::contact::{NormalDirection, NormalLaw};
        let normal = NormalDirection::new(NormalLaw::Linear, 60.0, 2e7, 0.0).unwrap();
        let contact = SlipSlap::new(std::sync::Arc::new(Jenkins::new(4e6, 0.5).unwrap()), normal);
        let (xi, eta) = ([0.0, 3e-5, 0.0], [0.0, 0.0, 1e-6]);
        let [(u, s), (v, n)] = slip_slap_loops(&contact, 3.0, [&xi, &eta]).unwrap();
        let area = |u: &[f64], f: &[f64]| -> f64 {
            (1..u.len()).map(|k| 0.5 * (f[k] + f[k - 1]) * (u[k] - u[k - 1])).sum()
        };
        // The friction takes 2 μ N0 twice the way that it slips, to the order of the change of its limit; the spring nothing.
        let slips = 4.0 * 30.0 * (3e-5 - 30.0 / 4e6);
        assert!((area(&u, &s) / slips - 1.0).abs() < 0.2, "{}", area(&u, &s));
        assert!(area(&v, &n).abs() < 1e-9 && n.iter().all(|n| n.abs() <= 20.0 + 1e-9));
        assert_eq!((u[0], s[0]), (u[FINE], s[FINE]));
    }

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
