//! What all changes share, alone and together.

use stickslip::contact::{BoucWen, Iwan, IwanSpacing, JointBase, SlipState, StateTangents};

use super::*;

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
        (Box::new(bouc_wen), JointBase::from(bouc_wen)),
        (Box::new(jenkins()), JointBase::from(jenkins())),
        (Box::new(valanis), JointBase::from(valanis)),
        (Box::new(iwan.clone()), JointBase::from(iwan)),
    ];
    for (law, base) in pairs {
        let same = Joint::new(base, none()).unwrap();
        let (mut plain, mut changed) =
            (ContactHistory::at_rest(law.as_ref(), LOAD), ContactHistory::at_rest(&same, LOAD));
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
    let bouc_wen = |unloading_ratio: f64, asymmetry: f64| {
        let law = BoucWen::new(STIFFNESS, FRICTION, 1.5, unloading_ratio, 2e5).unwrap();
        Joint::new(law, JointChanges { asymmetry, ..none() }).unwrap()
    };
    for law in many_laws().into_iter().chain([bouc_wen(1.4, 0.3), bouc_wen(2.0, -0.6), bouc_wen(1.0, 0.6)]) {
        let mut contact = ContactHistory::at_rest(&law, LOAD);
        let mut state = contact.state.clone();
        let mut next = state.clone();
        for inputs in history(7, 300) {
            let force = law.advance(&mut state, inputs);
            let response = law.step(&contact.state, inputs, &mut next);
            contact.state.copy_from_slice(&next);
            close(force, response.force, 1e-10);
            for (alone, whole) in state.iter().zip(&contact.state) {
                close(*alone, *whole, 1e-11 * whole.abs().max(1e-4));
            }
        }
    }
}

#[test]
fn dissipation_is_never_negative_and_closes_the_energy_balance() {
    for law in many_laws() {
        let mut contact = ContactHistory::at_rest(&law, LOAD);
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
fn apart_there_is_no_friction_and_no_memory() {
    for law in many_laws() {
        let mut contact = ContactHistory::at_rest(&law, LOAD);
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
        let mut contact = ContactHistory::at_rest(&law, LOAD);
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
        let mut contact = ContactHistory::at_rest(&law, LOAD);
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
        let mut state = ContactHistory::at_rest(&law, LOAD).state;
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
