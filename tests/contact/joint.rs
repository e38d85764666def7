//! A contact with effects, by law: closed forms of each change, what it leaves alone, and what all share.

use crate::common::contact::{Carried, close};
use stickslip::contact::JointChanges;
use stickslip::contact::{
    BoucWen, ContactLaw, Inputs, Iwan, IwanSpacing, Jenkins, Joint, JointBase, LawError, SlipState,
    StateTangents, Valanis,
};

const STIFFNESS: f64 = 5e6;
const FRICTION: f64 = 0.5;
const LOAD: f64 = 150.0;
const LIMIT: f64 = FRICTION * LOAD;
/// Displacement at which Jenkins' element begins to slip (m).
const YIELD: f64 = LIMIT / STIFFNESS;

fn none() -> JointChanges {
    JointChanges::default()
}

fn jenkins() -> Jenkins {
    Jenkins::new(STIFFNESS, FRICTION).unwrap()
}

fn joint(changes: JointChanges) -> Joint {
    Joint::new(JointBase::Jenkins(jenkins()), changes).unwrap()
}

fn on_valanis(changes: JointChanges) -> Joint {
    Joint::new(JointBase::Gradual(Box::new(Valanis::new(STIFFNESS, FRICTION, 0.3, 0.0).unwrap())), changes)
        .unwrap()
}

/// Force at the end of a motion through `corners` (m) in steps of at most `step` (m).
fn walk(law: &dyn ContactLaw, corners: &[f64], step: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut contact = Carried::virgin(law, LOAD);
    let (mut at, mut path, mut force) = (0.0, Vec::new(), Vec::new());
    let mut lost = Vec::new();
    for corner in corners {
        let steps = ((corner - at) / step).abs().ceil().max(1.0) as usize;
        for index in 1..=steps {
            let u = at + (corner - at) * index as f64 / steps as f64;
            let response = contact.go(u, LOAD);
            path.push(u);
            force.push(response.force);
            lost.push(response.dissipated_energy);
        }
        at = *corner;
    }
    (path, force, lost)
}

/// Dissipation of the third of three loops of amplitude `amplitude` (m).
fn loop_area(law: &dyn ContactLaw, amplitude: f64) -> f64 {
    Carried::virgin(law, LOAD).last_loop(amplitude, LOAD, 3).0
}

/// Deterministic histories with reversals; loads vary and now and then vanish.
fn history(seed: u64, count: usize) -> Vec<Inputs> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).max(1);
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut before = 0.0;
    (0..count)
        .map(|_| {
            let displacement = 6.0 * YIELD * (2.0 * random() - 1.0);
            let velocity = (displacement - before) / 1e-3;
            before = displacement;
            Inputs { displacement, velocity, normal_load: LOAD * (1.6 * random() - 0.2) }
        })
        .collect()
}

/// Every kind of change, alone and together.
fn many_changes() -> Vec<JointChanges> {
    let weakening = Some((0.4, 0.02));
    let alone = [
        none(),
        JointChanges { spread: 0.7, ..none() },
        JointChanges { residual_stiffness: 4e5, ..none() },
        JointChanges { damping: 300.0, ..none() },
        JointChanges { cubic_stiffness: 3e14, ..none() },
        JointChanges { weakening, ..none() },
        JointChanges { wear: 900.0, ..none() },
        JointChanges { wear: -900.0, ..none() },
        JointChanges { asymmetry: 0.3, ..none() },
        JointChanges { half_gap: 8e-6, ..none() },
        JointChanges { half_gap: 8e-6, spread: 0.7, ..none() },
        JointChanges { half_gap: 8e-6, residual_stiffness: 4e5, cubic_stiffness: 1e14, ..none() },
        JointChanges { half_gap: 8e-6, damping: 300.0, ..none() },
    ];
    let all = JointChanges {
        spread: 0.6,
        residual_stiffness: 3e5,
        damping: 100.0,
        cubic_stiffness: 1e14,
        weakening,
        wear: 500.0,
        asymmetry: -0.2,
        half_gap: 5e-6,
        ..none()
    };
    alone.into_iter().chain([all, JointChanges { half_gap: 0.0, ..all }]).collect()
}

fn many_laws() -> Vec<Joint> {
    let gradual = many_changes().into_iter().filter(|changes| changes.spread == 0.0);
    many_changes().into_iter().map(joint).chain(gradual.map(on_valanis)).collect()
}

#[test]
fn without_changes_a_joint_is_its_base_law() {
    let valanis = Valanis::new(STIFFNESS, FRICTION, 0.3, 2e5).unwrap();
    let iwan = Iwan::new(STIFFNESS, FRICTION, -0.4, 2.0, 12, IwanSpacing::Equal).unwrap();
    let bouc_wen = BoucWen::new(STIFFNESS, FRICTION, 1.5, 1.4, 2e5).unwrap();
    let pairs: [(Box<dyn ContactLaw>, JointBase); 4] = [
        (Box::new(bouc_wen), JointBase::Gradual(Box::new(bouc_wen))),
        (Box::new(jenkins()), JointBase::Jenkins(jenkins())),
        (Box::new(valanis), JointBase::Gradual(Box::new(valanis))),
        (Box::new(iwan.clone()), JointBase::Iwan(iwan)),
    ];
    for (law, base) in pairs {
        let same = Joint::new(base, none()).unwrap();
        let (mut plain, mut changed) = (Carried::virgin(law.as_ref(), LOAD), Carried::virgin(&same, LOAD));
        for inputs in history(3, 500) {
            let expected = plain.go(inputs.displacement, inputs.normal_load);
            let found = changed.go(inputs.displacement, inputs.normal_load);
            close(found.force, expected.force, 1e-10);
            close(found.dissipated_energy, expected.dissipated_energy, 1e-15);
            close(found.tangents.displacement, expected.tangents.displacement, 1e-3);
            close(found.tangents.normal_load, expected.tangents.normal_load, 1e-9);
            assert_eq!(found.slip_state, expected.slip_state);
        }
    }
}

#[test]
fn the_step_for_the_force_alone_is_the_step() {
    for law in many_laws() {
        let mut contact = Carried::virgin(&law, LOAD);
        let mut state = contact.state.clone();
        let mut next = state.clone();
        for inputs in history(7, 300) {
            let force = law.advance(&mut state, inputs);
            let response = law.step(&contact.state, inputs, &mut next);
            contact.state.copy_from_slice(&next);
            close(force, response.force, 1e-10);
            assert_eq!(state, contact.state, "{law:?}");
        }
    }
}

#[test]
fn dissipation_is_never_negative_and_closes_the_energy_balance() {
    for law in many_laws() {
        let mut contact = Carried::virgin(&law, LOAD);
        let mut next = contact.state.clone();
        let (mut work, mut lost, mut at, mut force, mut size) = (0.0, 0.0, 0.0, 0.0, 0.0f64);
        // Fine steps between the turning points: the work is the trapezoidal sum.
        for target in history(11, 40) {
            let (steps, from) = (200, at);
            for index in 1..=steps {
                let u = from + (target.displacement - from) * f64::from(index) / f64::from(steps);
                let inputs = Inputs { displacement: u, velocity: (u - at) / 1e-4, normal_load: LOAD };
                let response = law.step(&contact.state, inputs, &mut next);
                contact.state.copy_from_slice(&next);
                assert!(response.dissipated_energy >= 0.0, "{law:?}");
                work += 0.5 * (force + response.force) * (u - at);
                size += (0.5 * (force + response.force) * (u - at)).abs();
                lost += response.dissipated_energy;
                (at, force) = (u, response.force);
            }
        }
        let balance = work - lost - law.stored_energy(&contact.state);
        assert!(balance.abs() < 4e-3 * size, "{balance:e} of {size:e}, {:?}", law.changes());
    }
}

#[test]
fn one_long_step_equals_many_short_ones() {
    for changes in many_changes() {
        // A velocity that changes within the step is another motion.
        let law = joint(JointChanges { weakening: None, damping: 0.0, ..changes });
        for corner in [0.4, 3.0, 9.0] {
            let corners = [corner * YIELD, -1.3 * corner * YIELD, 0.2 * YIELD];
            let (_, once, lost_once) = walk(&law, &corners, f64::INFINITY);
            let (_, often, lost_often) = walk(&law, &corners, YIELD / 17.0);
            close(*once.last().unwrap(), *often.last().unwrap(), 1e-8);
            let (a, b): (f64, f64) = (lost_once.iter().sum(), lost_often.iter().sum());
            // The limit may grow while sliders slip; its mean is exact, that of many limits nearly.
            close(
                a,
                b,
                if changes.wear == 0.0 && changes.half_gap == 0.0 { 1e-12 } else { 0.02 * b + 1e-12 },
            );
        }
    }
}

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
    let (mut found, mut expected) = (Carried::virgin(&law, LOAD), Carried::virgin(&reference, LOAD));
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
        let mut contact = Carried::virgin(&law, LOAD);
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
    let base = || JointBase::Gradual(Box::new(Valanis::new(STIFFNESS, FRICTION, 0.3, 0.0).unwrap()));
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

#[test]
fn apart_there_is_no_friction_and_no_memory() {
    for law in many_laws() {
        let mut contact = Carried::virgin(&law, LOAD);
        contact.go(9.0 * YIELD, LOAD);
        let response = contact.go(2.0 * YIELD, -3.0);
        assert_eq!(response.slip_state, SlipState::Separated);
        let JointChanges { residual_stiffness, cubic_stiffness, half_gap, .. } = *law.changes();
        if residual_stiffness == 0.0 && cubic_stiffness == 0.0 {
            assert_eq!(response.force, 0.0);
            let elsewhere = contact.go(-YIELD, -3.0);
            assert_eq!(elsewhere.force, 0.0);
            let back = contact.go(-YIELD + 0.5 * half_gap, LOAD);
            assert!(half_gap == 0.0 || back.force == 0.0);
        }
    }
}

#[test]
fn sliders_give_the_same_force_where_there_are_any() {
    for law in many_laws() {
        let mut sliders = Vec::new();
        let piecewise = law.sliders(LOAD, &mut sliders);
        let JointChanges {
            damping,
            cubic_stiffness,
            weakening,
            wear,
            half_gap,
            spread,
            residual_stiffness,
            ..
        } = *law.changes();
        let smooth = damping != 0.0 || cubic_stiffness != 0.0 || weakening.is_some() || wear != 0.0;
        let together = half_gap > 0.0 && (spread > 0.0 || residual_stiffness > 0.0);
        assert_eq!(piecewise, law.has_stick() && !smooth && !together, "{law:?}");
        if !piecewise {
            continue;
        }
        let mut contact = Carried::virgin(&law, LOAD);
        let mut positions = vec![0.0; sliders.len()];
        for inputs in history(13, 200) {
            let mut expected = 0.0;
            for (slider, position) in sliders.iter().zip(&mut positions) {
                let (force, next) = slider.step(*position, inputs.displacement);
                expected += force;
                *position = next;
            }
            close(contact.go(inputs.displacement, LOAD).force, expected, 1e-9);
        }
    }
}

#[test]
fn a_state_that_was_set_carries_its_force() {
    for law in many_laws() {
        for force in [0.0, 0.3 * LIMIT, -0.5 * LIMIT] {
            let mut state = vec![0.0; law.state_len()];
            law.set_state(2e-6, LOAD, force, &mut state);
            let inputs = Inputs { displacement: 2e-6, velocity: 0.0, normal_load: LOAD };
            close(law.advance(&mut state, inputs), force, 1e-9);
        }
    }
}

#[test]
fn derivatives_are_those_of_the_step() {
    let mut checked = 0;
    for law in many_laws() {
        let mut contact = Carried::virgin(&law, LOAD);
        let mut next = contact.state.clone();
        for inputs in history(17, 120) {
            checked += usize::from(derivatives_agree(&law, &contact.state, inputs));
            law.step(&contact.state, inputs, &mut next);
            contact.state.copy_from_slice(&next);
        }
    }
    assert!(checked > 2000, "{checked} steps without a kink nearby");
}

#[test]
fn force_and_tangents_at_once_are_those_of_the_step() {
    for law in many_laws() {
        let mut state = Carried::virgin(&law, LOAD).state;
        let mut next = state.clone();
        let (mut tangents, mut lean) = (StateTangents::default(), StateTangents::default());
        for inputs in history(19, 120) {
            let quick = law.force_and_tangents(&state, inputs, &mut next, &mut lean);
            let whole = law.step(&state, inputs, &mut next);
            law.state_tangents(&state, inputs, &mut tangents);
            assert_eq!(quick.force, whole.force);
            assert_eq!(quick.tangents.displacement, whole.tangents.displacement);
            assert_eq!(quick.tangents.velocity, whole.tangents.velocity);
            assert_eq!(quick.slip_state, whole.slip_state);
            for (lean, by_state) in lean.force_by_state.iter().zip(&tangents.force_by_state) {
                close(*lean, *by_state, 1e-12);
            }
            assert_eq!(lean.force_by_state.len(), state.len());
            state.copy_from_slice(&next);
        }
    }
}

/// Every derivative of a step against central differences; false where a kink lies within the difference.
fn derivatives_agree(law: &Joint, state: &[f64], inputs: Inputs) -> bool {
    let n = state.len();
    let step = |state: &[f64], inputs: Inputs| {
        let mut next = vec![0.0; n];
        let force = law.step(state, inputs, &mut next).force;
        next.insert(0, force);
        next
    };
    let mut tangents = Default::default();
    let response = law.step(state, inputs, &mut vec![0.0; n]);
    law.state_tangents(state, inputs, &mut tangents);
    let here = step(state, inputs);
    // Sizes of the columns: u, v, N, then the state's. Loads and forces are of the size of one.
    let is_force = |index: usize| {
        index == 2 || (law.has_stick() && index == 4) || (!law.has_stick() && (index == 3 || index == 5))
    };
    for column in 1..n + 3 {
        let size = match column {
            c if c < n && is_force(c) => 1.0,
            c if c == n + 2 => 1.0,
            c if c == n + 1 => 1e-3,
            _ => 1e-7,
        };
        let moved = |by: f64| {
            let (mut state, mut inputs) = (state.to_vec(), inputs);
            match column {
                c if c < n => state[c] += by,
                c if c == n => inputs.displacement += by,
                c if c == n + 1 => inputs.velocity += by,
                _ => inputs.normal_load += by,
            }
            step(&state, inputs)
        };
        let h = 1e-4 * size;
        let (more, less) = (moved(h), moved(-h));
        for row in 0..=n {
            let found = match (row, column) {
                (0, c) if c < n => tangents.force_by_state[c],
                (0, c) if c == n => response.tangents.displacement,
                (0, c) if c == n + 1 => response.tangents.velocity,
                (0, _) => response.tangents.normal_load,
                (r, c) if c < n => tangents.next_by_state[(r - 1) * n + c],
                (r, c) if c == n => tangents.next_by_displacement[r - 1],
                (r, c) if c == n + 1 => tangents.next_by_velocity[r - 1],
                (r, _) => tangents.next_by_normal_load[r - 1],
            };
            let unit = if row == 0 || is_force(row - 1) { 1.0 } else { 1e-7 };
            let (ahead, behind) = ((more[row] - here[row]) / h, (here[row] - less[row]) / h);
            let scale = unit / size;
            if (ahead - behind).abs() > 1e-3 * (scale + ahead.abs()) {
                // A kink, or a curvature too strong for the difference.
                return false;
            }
            let error = (found - 0.5 * (ahead + behind)).abs();
            assert!(
                error <= 1e-3 * (scale + found.abs()),
                "row {row}, column {column}: {found:e}, differences {ahead:e} and {behind:e}\n{:?}\n{state:?} {inputs:?}",
                law.changes()
            );
        }
    }
    true
}
