//! Friction under a normal force that varies.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, Jenkins, NormalDirection, NormalLaw, SlipSlapInputs, SlipState};

use super::{History, PRELOAD, STIFFNESS, frictions, motion, normal, normals};
use crate::common::contact::close;

fn at(displacement: [f64; 2]) -> SlipSlapInputs {
    SlipSlapInputs { displacement, velocity: [0.0; 2] }
}

#[test]
fn in_stick_a_change_of_the_normal_force_creates_no_force() {
    for direction in normals() {
        let mut history = History::new(Arc::new(Jenkins::new(3.95e6, 0.6).unwrap()), direction);
        let before = history.go(at([3e-6, 0.0]));
        for opening in [-2e-6, 1e-6, 0.5e-6, -5e-6] {
            let response = history.go(at([3e-6, opening]));
            assert_eq!((response.force[0], response.slip_state), (before.force[0], SlipState::Stick));
            assert_eq!(response.friction_energy, 0.0);
        }
    }
}

#[test]
fn in_slip_the_force_is_the_limit_of_the_instantaneous_normal_force() {
    for direction in normals() {
        let mut history = History::new(Arc::new(Jenkins::new(3.95e6, 0.6).unwrap()), direction);
        for step in 1..40 {
            let mut inputs = motion([0.0, 2e-6], [1.0, 3.0], [0.0, 0.4], f64::from(step) * 1e-3);
            inputs.displacement[0] = f64::from(step) * 20e-6;
            let response = history.go(inputs);
            assert_eq!(response.slip_state, SlipState::Slip);
            close(response.force[0], 0.6 * response.normal_force, 1e-9);
            close(response.force[1], PRELOAD - response.normal_force, 1e-9);
        }
    }
}

#[test]
fn after_a_lift_off_nothing_is_remembered() {
    for law in frictions(1e5) {
        for direction in normals() {
            let parting = direction.static_approach();
            let mut history = History::new(law.clone(), direction);
            assert!(history.go(at([3e-6, 0.0])).force[0] > 1.0);
            let apart = history.go(at([3e-6, 2.0 * parting]));
            assert_eq!((apart.normal_force, apart.slip_state), (0.0, SlipState::Separated));
            close(apart.separation, parting, 1e-15);
            // Springs beside the law go on acting; what friction held is gone.
            let beside = apart.force[0];
            close(history.go(at([3e-6, 0.0])).force[0], beside, 1e-9);
        }
    }
}

/// Where bodies meet within a step, friction begins at that instant, whatever the step.
#[test]
fn the_step_in_which_bodies_meet_is_divided_at_the_instant() {
    for direction in normals().into_iter().filter(|direction| direction.impact_damping() == 0.0) {
        let parting = direction.static_approach();
        let mut history = History::new(Arc::new(Jenkins::new(3.95e6, 0.6).unwrap()), direction);
        history.go(at([0.0, 3.0 * parting]));
        // The bodies meet at two thirds of the way, so that a third of 6 µm stretches the spring.
        let response = history.go(at([6e-6, 0.0]));
        close(response.force[0], 3.95e6 * 2e-6, 1e-9);
    }
}

/// Full slip one way under N(t) = N0 + a sin, against `∫ μ N v dt`, and under a motion in phase the closed loop.
#[test]
fn friction_under_a_sinusoidal_normal_force_meets_its_closed_form() {
    // A rigid slider (yield displacement far below the amplitude), u = U sin, N = N0 + a sin: the loop's area is that
    // under N0, 4 μ N0 U, whatever a: what the swing adds going up it takes off going down.
    let (stiffness, friction, amplitude, swing) = (1e12, 0.6, 30e-6, 0.5 * PRELOAD);
    let mut errors = Vec::new();
    for steps in [40, 80, 160] {
        let direction = normal(NormalLaw::Linear, 0.0);
        let mut history = History::new(Arc::new(Jenkins::new(stiffness, friction).unwrap()), direction);
        let (mut energy, mut lost) = (0.0, 0.0);
        for step in 1..=2 * steps {
            let time = f64::from(step) / f64::from(steps) / 50.0;
            // η below zero presses: N_c = N0 + a sin.
            let inputs = motion([amplitude, -swing / STIFFNESS], [1.0, 1.0], [0.0, 0.0], time);
            let response = history.go(inputs);
            if step > steps {
                energy += response.friction_energy;
                lost += response.impact_energy;
            }
        }
        assert_eq!(lost, 0.0);
        errors.push((energy / (4.0 * friction * PRELOAD * amplitude) - 1.0).abs());
    }
    assert!(errors.iter().all(|error| *error < 1e-5), "{errors:?}");
}

/// The largest error (N, and 10 µJ) of tangential forces and friction energy over steps of several sizes near one: where
/// in a step slip begins is a matter of chance.
fn errors(run: impl Fn(u32) -> Vec<f64>) -> impl Fn(u32) -> f64 {
    let exact = run(20_480);
    move |steps| {
        let one = |steps: u32| {
            let found = run(steps);
            found.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        [0, 60, 100, 140, 220].map(|more| one(steps + more * steps / 320)).into_iter().fold(0.0, f64::max)
    }
}

/// Tangential forces (N) along a motion that opens the contact by `opening` of the static approach, and friction energy.
fn samples(law: &Arc<dyn ContactLaw>, direction: NormalDirection, opening: f64, steps: u32) -> Vec<f64> {
    let mut history = History::new(law.clone(), direction);
    let amplitudes = [25e-6, opening * direction.static_approach()];
    let at = |time: f64| motion(amplitudes, [1.0, 3.0], [0.2, 0.7], time);
    history.go(at(0.0));
    let (mut energy, mut samples) = (0.0, Vec::new());
    for step in 1..=steps {
        let time = 1.25 * f64::from(step) / f64::from(steps) / 50.0;
        let response = history.go(at(time));
        energy += response.friction_energy;
        if step % (steps / 20) == 0 {
            samples.push(response.force[0]);
        }
    }
    samples.push(energy * 1e5);
    samples
}

#[test]
fn forces_and_friction_energy_converge_with_order_two() {
    for direction in normals() {
        for law in frictions(0.0) {
            for opening in [0.7, 1.2] {
                let error = errors(|steps| samples(&law, direction, opening, steps));
                let (coarse, fine) = (error(320), error(2560));
                // 64 for order two. Where slip sets in gradually or by many sliders it falls behind where the limit grows
                // from nothing, after the bodies have met.
                let gradual = !law.has_stick() || law.state_len() > 10;
                let factor = if gradual && opening > 1.0 { 10.0 } else { 32.0 };
                // A coarse step that happens to meet the events is no measure: at least a thousandth of the limit.
                let bound = coarse.max(1e-3 * 0.6 * PRELOAD) / factor;
                assert!(fine < bound, "{coarse} to {fine}: {opening} {law:?}, {direction:?}");
            }
        }
    }
}
