//! The periodic state: it reproduces itself, equals what marching tends to, and is found where
//! marching is hopeless or the solution is not unique.

use std::f64::consts::TAU;

use stickslip::contact::{
    ContactLaw, Inputs, Jenkins, Period, PeriodicError, PeriodicSolver, Response, SlipState, StateTangents,
    Tangents, Valanis, periodic_state,
};

const LOAD: f64 = 147.15;

fn valanis(residual_stiffness: f64) -> Valanis {
    Valanis::from_lambda(7.9e6, residual_stiffness, 0.3, 8.7e4, LOAD).unwrap()
}

fn jenkins() -> Jenkins {
    Jenkins::new(7.9e6, 0.6).unwrap()
}

fn wave(samples: usize, mean: f64, first: f64, third: f64) -> Vec<f64> {
    let value = |i: usize| {
        let angle = TAU * i as f64 / samples as f64;
        mean + first * angle.cos() + third * (3.0 * angle + 0.4).sin()
    };
    (0..samples).map(value).collect()
}

fn march(law: &dyn ContactLaw, displacement: &[f64], load: &[f64], state: &mut [f64], periods: usize) {
    let mut next = vec![0.0; state.len()];
    for _ in 0..periods {
        for (i, displacement) in displacement.iter().enumerate() {
            let normal_load = load[i % load.len()];
            law.step(state, Inputs { displacement: *displacement, velocity: 0.0, normal_load }, &mut next);
            state.copy_from_slice(&next);
        }
    }
}

#[test]
fn periodic_state_is_what_marching_tends_to() {
    let laws: [&dyn ContactLaw; 3] = [&valanis(0.0), &valanis(5e5), &jenkins()];
    let displacements =
        [wave(64, 0.0, 20e-6, 0.0), wave(64, 3e-6, 2e-6, 0.5e-6), wave(64, -8e-6, 12e-6, 6e-6)];
    // Constant, varying, and apart for a part of the period.
    let loads = [vec![LOAD], wave(64, LOAD, 60.0, 20.0), wave(64, 40.0, 90.0, 0.0)];
    for law in laws {
        for displacement in &displacements {
            for load in &loads {
                let mut state = vec![0.0; law.state_len()];
                law.set_state(0.0, load[0], 0.0, &mut state);
                let mut marched = state.clone();
                march(law, displacement, load, &mut marched, 60);
                let info = periodic_state(law, displacement, load, &mut state).unwrap();
                assert!(info.iterations <= 8, "{info:?}");
                let mut after = state.clone();
                march(law, displacement, load, &mut after, 1);
                for (i, marched) in marched.iter().enumerate() {
                    let unit: f64 = if i == 0 && law.state_len() == 4 { 1.0 } else { 1e-6 };
                    assert!((after[i] - state[i]).abs() <= 1e-10 * unit.max(state[i].abs()));
                    let error = (marched - state[i]).abs();
                    assert!(error <= 1e-9 * unit.max(state[i].abs()), "{law:?} component {i}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn tiny_amplitude_needs_a_few_newton_steps_where_marching_needs_a_million_periods() {
    let law = valanis(0.0);
    let mut state = [0.0; 4];
    law.set_state(0.0, LOAD, 30.0, &mut state);
    let displacement = wave(32, 0.0, 1e-10, 0.0);
    let info = periodic_state(&law, &displacement, &[LOAD], &mut state).unwrap();
    assert!(info.iterations <= 12, "{info:?}");
    // The contraction of a period is only 1 − 2.4e-5: the force's mean has to come from the solver.
    let tip = 7.9e6 * 1e-10;
    assert!((state[0] / (tip * (TAU / 32.0).cos()) - 1.0).abs() < 1e-3, "{state:?}");
}

#[test]
fn a_stuck_contact_keeps_the_slider_it_was_given() {
    let law = jenkins();
    let mut state = [0.0; 3];
    law.set_state(0.0, LOAD, 5.0, &mut state);
    let slider = state[0];
    let info = periodic_state(&law, &wave(16, 0.0, 2e-6, 0.0), &[LOAD], &mut state).unwrap();
    assert_eq!((state[0], info.iterations, info.residual), (slider, 0, 0.0));
}

#[test]
fn a_resting_contact_is_periodic_as_it_is() {
    let law = valanis(5e5);
    let mut state = [0.0; 4];
    law.set_state(4e-6, LOAD, 20.0, &mut state);
    let given = state;
    periodic_state(&law, &[4e-6; 8], &[LOAD], &mut state).unwrap();
    assert_eq!(state, given);
}

#[test]
fn dissipation_of_the_traced_period_equals_its_work() {
    let law = valanis(5e5);
    let displacement = wave(4096, 0.0, 15e-6, 5e-6);
    let period = Period { displacement: &displacement, velocity: &[], normal_load: &[LOAD] };
    let (mut solver, mut state, mut force) = (PeriodicSolver::new(), [0.0; 4], vec![0.0; 4096]);
    law.set_state(0.0, LOAD, 0.0, &mut state);
    solver.solve(&law, &period, &mut state).unwrap();
    let dissipated = solver.trace(&law, &period, &mut state, &mut force).unwrap();
    let work: f64 = (0..4096)
        .map(|i| {
            let j = (i + 1) % 4096;
            0.5 * (force[i] + force[j]) * (displacement[j] - displacement[i])
        })
        .sum();
    assert!((work / dissipated - 1.0).abs() < 1e-5, "{work:e} {dissipated:e}");
}

fn silent() -> Response {
    let tangents = Tangents::default();
    Response { force: 0.0, tangents, dissipated_energy: 0.0, slip_state: SlipState::Slip }
}

/// A state that grows without end has no period.
#[derive(Debug)]
struct Drifting;

impl ContactLaw for Drifting {
    fn state_len(&self) -> usize {
        1
    }
    fn set_state(&self, _: f64, _: f64, _: f64, state: &mut [f64]) {
        state[0] = 0.0;
    }
    fn step(&self, state: &[f64], _: Inputs, next: &mut [f64]) -> Response {
        next[0] = state[0] + 1.0;
        silent()
    }
    fn state_tangents(&self, _: &[f64], _: Inputs, out: &mut StateTangents) {
        out.reset(1);
        out.next_by_state[0] = 1.0;
    }
    fn limit(&self, _: f64) -> f64 {
        0.0
    }
}

#[test]
fn a_drifting_state_is_reported_not_returned() {
    let error = periodic_state(&Drifting, &[0.0, 1.0], &[1.0], &mut [0.0]).unwrap_err();
    assert!(matches!(error, PeriodicError::NotConverged { .. }), "{error}");
}

/// A linear memory of two components that turns and shrinks them, in an order that matters; it has
/// exactly one periodic state, which one Newton step must hit.
#[derive(Debug)]
struct Turning;

impl Turning {
    fn matrix(displacement: f64) -> [f64; 4] {
        if displacement > 0.5 { [0.999, 0.4, 0.0, 0.9999] } else { [0.998, 0.0, -0.3, 0.9] }
    }
}

impl ContactLaw for Turning {
    fn state_len(&self) -> usize {
        2
    }
    fn set_state(&self, _: f64, _: f64, _: f64, state: &mut [f64]) {
        state.fill(0.0);
    }
    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let [a, b, c, d] = Self::matrix(inputs.displacement);
        next[0] = a * state[0] + b * state[1] + 1.0;
        next[1] = c * state[0] + d * state[1] - 2.0 * inputs.displacement;
        silent()
    }
    fn state_tangents(&self, _: &[f64], inputs: Inputs, out: &mut StateTangents) {
        out.reset(2);
        out.next_by_state.copy_from_slice(&Self::matrix(inputs.displacement));
    }
    fn limit(&self, _: f64) -> f64 {
        0.0
    }
}

#[test]
fn the_monodromy_multiplies_the_steps_in_their_order() {
    let mut state = [3.0, 0.0];
    let info = periodic_state(&Turning, &[0.0, 1.0, 1.0], &[1.0], &mut state).unwrap();
    assert!(info.iterations <= 2 && info.residual < 1e-12, "{info:?}");
    let mut after = state;
    march(&Turning, &[0.0, 1.0, 1.0], &[1.0], &mut after, 1);
    assert!((after[0] - state[0]).abs() + (after[1] - state[1]).abs() < 1e-10);
}

#[test]
fn arrays_that_do_not_fit_are_named() {
    let law = jenkins();
    let solve = |displacement: &[f64], load: &[f64], len: usize| {
        periodic_state(&law, displacement, load, &mut vec![0.0; len]).unwrap_err().to_string()
    };
    assert_eq!(solve(&[], &[1.0], 3), "displacement has length 0, expected 1");
    assert_eq!(solve(&[0.0; 4], &[1.0; 3], 3), "normal_load has length 3, expected 4");
    assert_eq!(solve(&[0.0; 4], &[], 3), "normal_load has length 0, expected 4");
    assert_eq!(solve(&[0.0; 4], &[1.0], 2), "state has length 2, expected 3");
    assert_eq!(solve(&[0.0, f64::NAN], &[1.0], 3), "displacement[1] is not a finite number");
}
