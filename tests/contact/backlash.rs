//! Laws of backlash: Jenkins' element with play.

use stickslip::contact::{Backlash, ContactLaw, Inputs, Jenkins, LawError, Slider, SlipState};

use crate::common::contact::{
    ContactHistory, LOADS, check_derivatives, check_energy_balance, check_one_step_equals_many, close,
};

const STIFFNESS: f64 = 2e6;
const LOAD: f64 = 150.0;
const LIMIT: f64 = 60.0;
const PLAY: f64 = 7e-6;

fn law() -> Backlash {
    Backlash::new(STIFFNESS, 0.4, PLAY).unwrap()
}

#[test]
fn without_play_backlash_is_jenkins_element() {
    let (backlash, jenkins) =
        (Backlash::new(STIFFNESS, 0.4, 0.0).unwrap(), Jenkins::new(STIFFNESS, 0.4).unwrap());
    let (mut one, mut other) =
        (ContactHistory::at_rest(&backlash, LOAD), ContactHistory::at_rest(&jenkins, LOAD));
    for i in 0..400 {
        let t = 0.05 * f64::from(i);
        let (u, load) = (50e-6 * (t.sin() + 0.4 * (3.3 * t).cos()), 100.0 + 160.0 * (1.7 * t).cos());
        assert_eq!(one.go(u, load), other.go(u, load));
        assert_eq!(one.state, other.state);
    }
}

#[test]
fn no_force_until_the_slack_is_taken_up() {
    let law = law();
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    for u in [3e-6, -6.8e-6, 6.9e-6] {
        let response = contact.go(u, LOAD);
        assert_eq!((response.force, response.tangents.displacement), (0.0, 0.0));
        assert_eq!(response.slip_state, SlipState::Stick);
    }
    let response = contact.go(10e-6, LOAD);
    close(response.force, STIFFNESS * 3e-6, 1e-9);
    assert_eq!(response.tangents.displacement, STIFFNESS);
    // Into slip, and back: the spring gives up its stretch, then the play 2g carries nothing.
    close(contact.go(80e-6, LOAD).force, LIMIT, 1e-12);
    let released = 80e-6 - LIMIT / STIFFNESS;
    close(contact.go(released + 1e-6, LOAD).force, STIFFNESS * 1e-6, 1e-9);
    assert_eq!(contact.go(released - 1e-6, LOAD).force, 0.0);
    assert_eq!(contact.go(released - 13.9e-6, LOAD).force, 0.0);
    close(contact.go(released - 15e-6, LOAD).force, -STIFFNESS * 1e-6, 1e-9);
}

#[test]
fn loop_area_equals_4_limit_times_slip() {
    let law = law();
    for amplitude in [5e-6, 30e-6, 38e-6, 50e-6, 1e-3] {
        let (dissipated, tip) = ContactHistory::at_rest(&law, LOAD).last_loop(amplitude, LOAD, 3);
        let slip = (amplitude - PLAY - LIMIT / STIFFNESS).max(0.0);
        close(dissipated, 4.0 * LIMIT * slip, 1e-12 * LIMIT * amplitude);
        close(tip, (STIFFNESS * (amplitude - PLAY)).clamp(0.0, LIMIT), 1e-9);
    }
}

#[test]
fn one_step_equals_many_with_displacement_and_load_linear() {
    let law = law();
    let loads = [-80.0, -1e-3, 0.0, 20.0, 150.0, 400.0];
    for (start_load, end_load) in loads.iter().flat_map(|a| loads.iter().map(move |b| (*a, *b))) {
        for fraction in [-1.0, -0.4, 0.0, 0.7, 1.0] {
            for travel in [-90e-6, -7.5e-6, 0.0, 1e-6, 35e-6, 300e-6] {
                let start = ContactHistory::from(&law, 5e-6, start_load, fraction * law.limit(start_load));
                check_one_step_equals_many(&law, &start, 5e-6 + travel, end_load, (5e-6, start_load));
            }
        }
    }
}

#[test]
fn state_tangents_equal_finite_differences() {
    let law = law();
    for (start_load, end_load) in LOADS {
        for fraction in [-0.93, -0.31, 0.0, 0.57, 0.97] {
            for travel in [-110e-6, -21e-6, -9.3e-6, -3.1e-6, 0.13e-6, 4.3e-6, 57e-6] {
                let start = ContactHistory::from(&law, 2e-6, start_load, fraction * law.limit(start_load));
                let inputs = Inputs { displacement: 2e-6 + travel, velocity: 0.0, normal_load: end_load };
                check_derivatives(&law, &start.state, inputs, &|index| index < 2);
            }
        }
    }
}

#[test]
fn work_of_a_fine_history_equals_stored_plus_dissipated() {
    let law = law();
    check_energy_balance(&law, &|state| law.stored_energy(state));
}

#[test]
fn re_contact_finds_the_play_even_on_both_sides() {
    let law = law();
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    contact.go(80e-6, LOAD);
    contact.go(70e-6, -1.0);
    assert_eq!(contact.state, ContactHistory::from(&law, 70e-6, -1.0, 33.0).state);
    contact.go(70e-6, 0.0);
    assert_eq!(contact.go(76.9e-6, LOAD).force, 0.0);
    assert_eq!(contact.go(63.1e-6, LOAD).force, 0.0);
    close(contact.go(60e-6, LOAD).force, -STIFFNESS * 3e-6, 1e-9);
}

#[test]
fn lift_off_dissipates_what_the_spring_held() {
    let law = law();
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    let force = contact.go(27e-6, LOAD).force;
    close(force, 40.0, 1e-9);
    close(contact.go(27e-6, -1e-300).dissipated_energy, 0.5 * force * force / STIFFNESS, 1e-16);
    // Within the play nothing is held.
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    contact.go(6e-6, LOAD);
    assert_eq!(contact.go(6.5e-6, -20.0).dissipated_energy, 0.0);
}

#[test]
fn force_is_odd_in_the_history() {
    let law = law();
    let (mut one, mut mirror) = (ContactHistory::at_rest(&law, LOAD), ContactHistory::at_rest(&law, LOAD));
    for (u, load) in [(50e-6, LOAD), (20e-6, 90.0), (-70e-6, -3.0), (4e-6, 80.0), (19e-6, 200.0)] {
        let (a, b) = (one.go(u, load), mirror.go(-u, load));
        assert_eq!((a.force, a.dissipated_energy), (-b.force, b.dissipated_energy));
    }
    assert!(law.is_odd());
}

#[test]
fn its_slider_under_a_constant_load_is_the_law() {
    let law = law();
    let mut sliders = Vec::new();
    assert!(law.sliders(LOAD, &mut sliders));
    assert_eq!(
        sliders,
        [Slider { play_below: -PLAY, play_above: PLAY, ..Slider::jenkins(STIFFNESS, LIMIT) }]
    );
    let (mut contact, mut position) = (ContactHistory::at_rest(&law, LOAD), 0.0);
    for i in 0..500 {
        let u = 45e-6 * (0.3 * f64::from(i)).sin() + 20e-6 * (1.1 * f64::from(i)).cos();
        let (force, moved) = sliders[0].step(position, u);
        close(contact.go(u, LOAD).force, force, 1e-10);
        position = moved;
    }
    assert!(law.sliders(0.0, &mut sliders) && sliders.is_empty());
}

#[test]
fn bad_parameters_are_named_with_value_and_bounds() {
    for bad in [-1e-9, f64::NAN, f64::INFINITY] {
        let error = Backlash::new(1e6, 0.4, bad).unwrap_err();
        assert!(matches!(error, LawError::OutOfBounds { parameter: "play", .. }));
    }
    assert!(Backlash::new(0.0, 0.4, 0.0).is_err() && Backlash::new(1e6, -1.0, 0.0).is_err());
}
