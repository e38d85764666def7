//! Each change by its closed form, and what it leaves alone.

use stickslip::contact::LawError;

use super::*;

#[test]
fn residual_stiffness_inclines_the_loop_and_keeps_its_area() {
    let law = joint(JointChanges { residual_stiffness: 4e5, ..none() });
    let amplitude = 4.0 * YIELD;
    close(loop_area(&law, amplitude), 4.0 * LIMIT * (amplitude - YIELD), 1e-12);
    let (_, force, _) = walk(&law, &[amplitude, 5.0 * YIELD], f64::INFINITY);
    close((force[1] - force[0]) / YIELD, 4e5, 1e-3);
    close(force[0], LIMIT + 4e5 * amplitude, 1e-9);
}

#[test]
fn a_cubic_spring_adds_its_force_and_no_loss() {
    let law = joint(JointChanges { cubic_stiffness: 1e15, ..none() });
    let amplitude = 4.0 * YIELD;
    close(loop_area(&law, amplitude), 4.0 * LIMIT * (amplitude - YIELD), 1e-12);
    let (_, force, _) = walk(&law, &[amplitude], f64::INFINITY);
    close(force[0], LIMIT + 1e15 * amplitude.powi(3), 1e-9);
}

#[test]
fn backlash_leaves_a_plateau_of_twice_the_half_gap() {
    let gap = 8e-6;
    for spread in [0.0, 0.8] {
        let law = joint(JointChanges { half_gap: gap, spread, ..none() });
        let top = 6.0 * YIELD;
        let (path, force, _) = walk(&law, &[top, -top, top], YIELD / 200.0);
        let resting = |range: std::ops::Range<usize>| {
            let inside: Vec<f64> =
                range.filter(|index| force[*index] == 0.0).map(|index| path[index]).collect();
            inside.iter().copied().fold(f64::MIN, f64::max) - inside.iter().copied().fold(f64::MAX, f64::min)
        };
        let turn = path.iter().position(|u| *u == -top).unwrap();
        let start = path.iter().position(|u| *u == top).unwrap();
        for range in [start..turn, turn..path.len()] {
            close(resting(range), 2.0 * gap, YIELD / 90.0);
        }
        // From rest the play lies evenly: the force begins at g.
        let first = force.iter().position(|force| *force > 0.0).unwrap();
        close(path[first], gap, YIELD / 150.0);
    }
    let law = joint(JointChanges { half_gap: gap, ..none() });
    let amplitude = 6.0 * YIELD;
    close(loop_area(&law, amplitude), 4.0 * LIMIT * (amplitude - gap - YIELD), 1e-12);
}

#[test]
fn backlash_is_backlash() {
    let (law, reference) = (
        joint(JointChanges { half_gap: 8e-6, ..none() }),
        stickslip::contact::Backlash::new(STIFFNESS, FRICTION, 8e-6).unwrap(),
    );
    let (mut found, mut expected) =
        (ContactHistory::at_rest(&law, LOAD), ContactHistory::at_rest(&reference, LOAD));
    for inputs in history(5, 400) {
        // A change of the load where the contact stays closed.
        let load = 0.2 * LOAD + inputs.normal_load.abs();
        let (a, b) = (found.go(inputs.displacement, load), expected.go(inputs.displacement, load));
        close(a.force, b.force, 1e-9);
    }
}

#[test]
fn springs_beside_the_law_act_behind_the_play() {
    let (gap, beside) = (8e-6, 4e5);
    let law = joint(JointChanges { half_gap: gap, residual_stiffness: beside, ..none() });
    let top = 6.0 * YIELD;
    let (path, force, _) = walk(&law, &[top, -top, top], YIELD / 50.0);
    let start = path.iter().position(|u| *u == top).unwrap();
    close(force[start], LIMIT + beside * (top - gap), 1e-9);
    // Unloading with both springs: the force vanishes after F/(k + e_t), and stays so over the play.
    let zero = top - (LIMIT + beside * (top - gap)) / (STIFFNESS + beside);
    let slipping = (LIMIT + beside * (top - gap) - beside * (top - gap - 2.0 * YIELD)) > 2.0 * LIMIT;
    assert!(!slipping, "the closed form above holds in stick only");
    let after = &path[start..];
    for (u, force) in after.iter().zip(&force[start..]).take_while(|(u, _)| **u > zero - 2.0 * gap) {
        let expected = if *u > zero { (STIFFNESS + beside) * (u - zero) } else { 0.0 };
        close(*force, expected, 1e-7);
    }
}

#[test]
fn asymmetry_shifts_the_mean_and_a_reversal_is_elastic() {
    let law = joint(JointChanges { asymmetry: 0.3, ..none() });
    let top = 6.0 * YIELD;
    let (path, force, _) = walk(&law, &[top, -top, top, 0.0], YIELD / 50.0);
    let largest = force.iter().copied().fold(f64::MIN, f64::max);
    let smallest = force.iter().copied().fold(f64::MAX, f64::min);
    close(largest, 1.3 * LIMIT, 1e-12);
    close(smallest, -0.7 * LIMIT, 1e-12);
    close(0.5 * (largest + smallest), 0.3 * LIMIT, 1e-12);
    let turn = path.iter().position(|u| *u == top).unwrap();
    close(force[turn] - force[turn + 1], STIFFNESS * (path[turn] - path[turn + 1]), 1e-9);
    // Area: 2 limits (mean of both) times the slip of either direction.
    close(loop_area(&law, top), 4.0 * LIMIT * (top - YIELD), 1e-12);
    assert!(!law.is_odd());
}

#[test]
fn wear_raises_the_plateau_in_proportion_to_the_slip() {
    let rate = 20.0;
    for (law, tolerance) in [
        (joint(JointChanges { wear: rate, ..none() }), 1e-9),
        (joint(JointChanges { wear: rate, spread: 0.5, ..none() }), 1e-9),
        (on_valanis(JointChanges { wear: rate, ..none() }), 1e-4),
    ] {
        let mut contact = ContactHistory::at_rest(&law, LOAD);
        for index in 1..=30 {
            let u = if index % 2 == 1 { 12.0 * YIELD } else { -12.0 * YIELD };
            let response = contact.go(4.0 * u, LOAD);
            let distance = law.slip_distance(&contact.state);
            close(response.force.abs(), LIMIT * (1.0 + rate * distance), tolerance * LIMIT);
        }
        // A record begins: the distance alone is forgotten.
        let mut state = contact.state.clone();
        law.restart(&mut state);
        assert_eq!(law.slip_distance(&state), 0.0);
        let force =
            law.advance(&mut state, Inputs { displacement: 13.0 * YIELD, velocity: 0.0, normal_load: LOAD });
        close(force, LIMIT * (1.0 + rate * law.slip_distance(&state)), 0.01 * LIMIT);
    }
}

#[test]
fn damping_dissipates_pi_c_omega_x_squared() {
    let (damping, omega, amplitude) = (50.0, 60.0, 0.5 * YIELD);
    let law = joint(JointChanges { damping, ..none() });
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, LOAD, 0.0, &mut state);
    let (mut next, mut lost) = (state.clone(), 0.0);
    let count = 2000;
    for index in 1..=2 * count {
        let phase = std::f64::consts::TAU * f64::from(index) / f64::from(count);
        let inputs = Inputs {
            displacement: amplitude * phase.sin(),
            velocity: amplitude * omega * phase.cos(),
            normal_load: LOAD,
        };
        let response = law.step(&state, inputs, &mut next);
        std::mem::swap(&mut state, &mut next);
        lost += if index > count { response.dissipated_energy } else { 0.0 };
    }
    let expected = std::f64::consts::PI * damping * omega * amplitude * amplitude;
    close(lost, expected, 1e-5 * expected);
}

#[test]
fn the_limit_at_constant_speed_is_stribecks() {
    let (excess, scale) = (0.4, 0.02);
    let law = joint(JointChanges { weakening: Some((excess, scale)), ..none() });
    for velocity in [1e-4, 0.02, -0.02, 0.1, 5.0f64] {
        let mut state = vec![0.0; law.state_len()];
        law.set_state(0.0, LOAD, 0.0, &mut state);
        let displacement = (20.0 * YIELD).copysign(velocity);
        let force = law.advance(&mut state, Inputs { displacement, velocity, normal_load: LOAD });
        close(force.abs(), LIMIT * (1.0 + excess * (-velocity.abs() / scale).exp()), 1e-12);
    }
    assert_eq!(law.limit(LOAD), 1.4 * LIMIT);
}

#[test]
fn spread_keeps_stiffness_and_limit_and_loses_energy_in_small_loops() {
    for spread in [0.2, 0.6, 1.0] {
        let law = joint(JointChanges { spread, ..none() });
        let (_, force, _) =
            walk(&law, &[1e-3 * YIELD * (1.0 - spread).max(0.01), 3.0 * YIELD], f64::INFINITY);
        close(force[0] / (1e-3 * YIELD * (1.0 - spread).max(0.01)), STIFFNESS, 1e-6 * STIFFNESS);
        close(force[1], LIMIT, 1e-12);
        // An even distribution p of yield displacements dissipates ∫ 4 k y (X − y) p dy over the y below X.
        let amplitude = (1.0 + 0.5 * spread) * YIELD;
        let low = (1.0 - spread) * YIELD;
        let (a, b) = (low, amplitude);
        let integral = amplitude * (b * b - a * a) / 2.0 - (b * b * b - a * a * a) / 3.0;
        let expected = 4.0 * STIFFNESS * integral / (2.0 * spread * YIELD);
        close(loop_area(&law, amplitude), expected, 5e-3 * expected);
    }
    // With slip from the first displacement on, small loops lose with the third power of the amplitude.
    let law = joint(JointChanges { spread: 1.0, ..none() });
    let ratio = loop_area(&law, 0.8 * YIELD) / loop_area(&law, 0.4 * YIELD);
    close(ratio, 8.0, 0.3);
}

#[test]
fn a_spread_on_a_gradual_law_is_refused() {
    let base = || Valanis::new(STIFFNESS, FRICTION, 0.3, 0.0).unwrap();
    let refused = Joint::new(base(), JointChanges { spread: 0.5, ..none() });
    assert!(matches!(refused, Err(LawError::Combination { parameter: "spread", .. })));
    for changes in [
        JointChanges { half_gap: -1e-6, ..none() },
        JointChanges { half_gap: f64::NAN, ..none() },
        JointChanges { asymmetry: 1.0, ..none() },
        JointChanges { weakening: Some((-1.0, 1.0)), ..none() },
        JointChanges { weakening: Some((0.1, 0.0)), ..none() },
    ] {
        let refused = Joint::new(base(), changes);
        assert!(matches!(refused, Err(LawError::OutOfBounds { .. })), "{changes:?}");
    }
}
