//! Laws of Jenkins' element.

use stickslip::contact::{ContactLaw, Jenkins, LawError, SlipState};

use crate::common::contact::{close, go};

const STIFFNESS: f64 = 2e6;
const FRICTION: f64 = 0.4;
const LOAD: f64 = 150.0;
const LIMIT: f64 = FRICTION * LOAD;

fn law() -> Jenkins {
    Jenkins::new(STIFFNESS, FRICTION).unwrap()
}

fn fresh(load: f64) -> [f64; 3] {
    let mut state = [0.0; 3];
    law().set_state(0.0, load, 0.0, &mut state);
    state
}

#[test]
fn jenkins_loop_area_equals_4_limit_times_slip() {
    for amplitude in [31e-6, 50e-6, 1e-3] {
        for samples in [2, 3 * 4, 200] {
            let mut state = fresh(LOAD);
            let (mut dissipated, mut tip) = (0.0, 0.0);
            for i in 0..3 * samples {
                let angle = std::f64::consts::TAU * i as f64 / samples as f64;
                let response = go(&law(), &mut state, amplitude * angle.cos(), LOAD);
                if i >= 2 * samples {
                    dissipated += response.dissipated_energy;
                }
                if i == 2 * samples {
                    tip = response.force;
                }
            }
            let area = 4.0 * LIMIT * (amplitude - LIMIT / STIFFNESS);
            close(dissipated / area, 1.0, 1e-12);
            // Equivalent stiffness, from tip to tip of the loop.
            close(tip / amplitude, LIMIT / amplitude, 1e-9);
        }
    }
}

#[test]
fn a_stuck_contact_is_a_spring_and_dissipates_nothing() {
    let mut state = fresh(LOAD);
    for displacement in [29e-6, -29e-6, 3e-6, 0.0, 30e-6] {
        let response = go(&law(), &mut state, displacement, LOAD);
        close(response.force, STIFFNESS * displacement, 1e-12);
        assert_eq!(response.tangents.displacement, STIFFNESS);
        assert_eq!((response.dissipated_energy, response.slip_state), (0.0, SlipState::Stick));
    }
}

#[test]
fn a_change_of_load_in_stick_creates_no_force() {
    let mut state = fresh(LOAD);
    let before = go(&law(), &mut state, 10e-6, LOAD).force;
    for load in [1e3, 60.0, 1e9, before / FRICTION * 1.000001] {
        let response = go(&law(), &mut state, 10e-6, load);
        assert_eq!(response.force, before);
        assert_eq!((response.tangents.normal_load, response.dissipated_energy), (0.0, 0.0));
    }
    // Below the limit that the force needs, the contact slips and follows the limit.
    let response = go(&law(), &mut state, 10e-6, 10.0);
    close(response.force, FRICTION * 10.0, 1e-12);
    // Force and limit fall in proportion to the slider's motion from 20 N to 4 N over 8 µm.
    close(response.dissipated_energy, 12.0 * 8e-6, 1e-9 * 12.0 * 8e-6);
    assert_eq!(response.tangents.normal_load, FRICTION);
}

#[test]
fn a_load_without_motion_creates_no_force() {
    let mut state = fresh(0.0);
    for load in [10.0, -5.0, 100.0, 0.0, 1e6] {
        assert_eq!(go(&law(), &mut state, 0.0, load).force, 0.0);
    }
}

#[test]
fn re_contact_remembers_nothing() {
    let mut marched = fresh(LOAD);
    go(&law(), &mut marched, 25e-6, LOAD);
    go(&law(), &mut marched, 80e-6, LOAD);
    let apart = go(&law(), &mut marched, 70e-6, -1.0);
    assert_eq!((apart.force, apart.slip_state), (0.0, SlipState::Separated));
    // The same place reached without any history.
    let mut other = [0.0; 3];
    law().set_state(70e-6, -1.0, 33.0, &mut other);
    assert_eq!(marched, other);
    go(&law(), &mut marched, 70e-6, 0.0);
    let response = go(&law(), &mut marched, 71e-6, LOAD);
    close(response.force, STIFFNESS * 1e-6, 1e-9);
}

#[test]
fn re_contact_within_a_step_starts_where_the_load_vanishes() {
    let mut state = [0.0; 3];
    law().set_state(0.0, -50.0, 0.0, &mut state);
    // N = 0 a quarter into the step, at 2 µm.
    let response = go(&law(), &mut state, 8e-6, 150.0);
    close(response.force, STIFFNESS * 6e-6, 1e-12);
    close(state[0], 2e-6, 1e-20);
}

#[test]
fn lift_off_dissipates_what_the_spring_held() {
    // Without motion the force follows the falling limit to zero.
    let mut state = fresh(LOAD);
    let force = go(&law(), &mut state, 20e-6, LOAD).force;
    let response = go(&law(), &mut state, 20e-6, -1e-300);
    close(response.dissipated_energy, 0.5 * force * force / STIFFNESS, 1e-18);
}

#[test]
fn one_step_equals_many_with_displacement_and_load_linear() {
    // Every pairing of start force, motion and load change, lift-off and re-contact included.
    let loads = [-80.0, -1e-3, 0.0, 20.0, 150.0, 400.0];
    for (start_load, end_load) in loads.iter().flat_map(|a| loads.iter().map(move |b| (*a, *b))) {
        for start_force in [-1.0, -0.4, 0.0, 0.7, 1.0] {
            for travel in [-90e-6, -7e-6, 0.0, 1e-6, 35e-6, 300e-6] {
                let mut once = [0.0; 3];
                let start_limit = law().limit(start_load);
                law().set_state(5e-6, start_load, start_force * start_limit, &mut once);
                let mut often = once;
                let whole = go(&law(), &mut once, 5e-6 + travel, end_load);
                let (mut dissipated, mut last, parts) = (0.0, 0.0, 37);
                for i in 1..=parts {
                    let s = i as f64 / parts as f64;
                    let load = if i == parts { end_load } else { start_load + s * (end_load - start_load) };
                    let part = go(&law(), &mut often, 5e-6 + s * travel, load);
                    dissipated += part.dissipated_energy;
                    last = part.force;
                }
                close(whole.force, last, 1e-9);
                close(whole.dissipated_energy, dissipated, 1e-14);
                close(once[0], often[0], 1e-15);
            }
        }
    }
}

#[test]
fn work_of_a_fine_history_equals_stored_plus_dissipated() {
    let law = law();
    let mut state = fresh(LOAD);
    let (mut work, mut dissipated, mut force) = (0.0, 0.0, 0.0);
    let samples = 40_000;
    for i in 1..=samples {
        let t = 6.0 * i as f64 / samples as f64;
        let displacement = 60e-6 * (1.7 * t).sin() + 30e-6 * (5.1 * t).sin();
        let load = 100.0 + 160.0 * (2.3 * t).cos(); // apart for a part of the time
        let before = state[1];
        let response = go(&law, &mut state, displacement, load);
        work += 0.5 * (force + response.force) * (displacement - before);
        force = response.force;
        dissipated += response.dissipated_energy;
    }
    let stored = 0.5 * force * force / STIFFNESS;
    close(work / (stored + dissipated), 1.0, 1e-6);
}

#[test]
fn force_is_odd_in_the_history() {
    let (mut state, mut mirror) = (fresh(LOAD), fresh(LOAD));
    for (u, load) in [(50e-6, LOAD), (20e-6, 90.0), (-70e-6, -3.0), (4e-6, 80.0), (9e-6, 200.0)] {
        let (a, b) = (go(&law(), &mut state, u, load), go(&law(), &mut mirror, -u, load));
        assert_eq!((a.force, a.dissipated_energy), (-b.force, b.dissipated_energy));
        assert_eq!(a.tangents.displacement, b.tangents.displacement);
        assert_eq!(a.tangents.normal_load, -b.tangents.normal_load);
    }
}

#[test]
fn huge_steps_stay_at_the_limit() {
    let mut state = fresh(LOAD);
    for displacement in [1e300, -1e300, 1e300] {
        let response = go(&law(), &mut state, displacement, LOAD);
        assert_eq!(response.force, LIMIT * displacement.signum());
        assert!(response.dissipated_energy.is_finite());
    }
}

#[test]
fn a_force_above_the_limit_is_cut_to_it() {
    let mut state = [0.0; 3];
    law().set_state(1e-6, LOAD, 1e9, &mut state);
    close(go(&law(), &mut state, 1e-6, LOAD).force, LIMIT, 1e-9);
}

#[test]
fn bad_parameters_are_named_with_value_and_bounds() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Jenkins::new(bad, 0.5).unwrap_err();
        assert!(matches!(error, LawError::OutOfBounds { parameter: "tangential_stiffness", .. }));
        let error = Jenkins::new(1e6, bad).unwrap_err();
        assert!(matches!(error, LawError::OutOfBounds { parameter: "friction_coefficient", .. }));
    }
    assert_eq!(
        Jenkins::new(-3.0, 0.5).unwrap_err().to_string(),
        "tangential_stiffness is -3 N/m; it must be a finite number, above 0"
    );
}
