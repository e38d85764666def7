//! Laws of Jenkins' elements side by side, and of the element that the exact harmonic balance carries.

use stickslip::contact::{ContactLaw, Inputs, Jenkins, LawError, ParallelSliders, Slider, SlipState};

use crate::common::contact::{
    ContactHistory, LOADS, check_derivatives, check_energy_balance, check_one_step_equals_many, close,
};

const LOAD: f64 = 150.0;
/// Stiffness (N/m) and friction (1); they yield at 3, 40 and 12 µm under 150 N.
const ELEMENTS: [(f64, f64); 3] = [(2e6, 0.04), (1e6, 40.0 / 150.0), (3e6, 0.24)];

fn law() -> ParallelSliders {
    ParallelSliders::new(&ELEMENTS).unwrap()
}

#[test]
fn parallel_sliders_are_the_sum_of_jenkins_elements() {
    let law = law();
    let elements = ELEMENTS.map(|(k, mu)| Jenkins::new(k, mu).unwrap());
    let mut whole = ContactHistory::at_rest(&law, LOAD);
    let mut parts: Vec<_> = elements.iter().map(|law| ContactHistory::at_rest(law, LOAD)).collect();
    for i in 0..400 {
        let t = 0.05 * f64::from(i);
        let (u, load) = (50e-6 * (t.sin() + 0.4 * (3.3 * t).cos()), 100.0 + 160.0 * (1.7 * t).cos());
        let response = whole.go(u, load);
        let responses: Vec<_> = parts.iter_mut().map(|part| part.go(u, load)).collect();
        let sum = |f: &dyn Fn(&stickslip::contact::Response) -> f64| responses.iter().map(f).sum::<f64>();
        close(response.force, sum(&|r| r.force), 1e-11);
        close(response.dissipated_energy, sum(&|r| r.dissipated_energy), 1e-16);
        close(response.tangents.displacement, sum(&|r| r.tangents.displacement), 1e-8);
        close(response.tangents.normal_load, sum(&|r| r.tangents.normal_load), 1e-12);
        let slips = responses.iter().any(|r| r.slip_state == SlipState::Slip);
        assert_eq!(response.slip_state == SlipState::Slip, slips);
        assert_eq!(response.slip_state == SlipState::Separated, load <= 0.0);
    }
}

#[test]
fn loading_curve_falls_in_slope_where_each_element_yields() {
    let law = law();
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    for (u, slope) in [(2.9e-6, 6e6), (11.9e-6, 4e6), (39.9e-6, 1e6), (41e-6, 0.0)] {
        assert_eq!(contact.go(u, LOAD).tangents.displacement, slope);
    }
    close(contact.go(1.0, LOAD).force, law.limit(LOAD), 1e-12);
    close(law.limit(LOAD), 6.0 + 40.0 + 36.0, 1e-12);
    assert_eq!((law.limit(0.0), law.limit(-3.0)), (0.0, 0.0));
}

#[test]
fn masing_branches_are_the_loading_curve_at_twice_its_size() {
    let law = law();
    for amplitude in [2e-6, 8e-6, 25e-6, 90e-6] {
        let tip = ContactHistory::at_rest(&law, LOAD).go(amplitude, LOAD).force;
        for part in [0.1, 0.37, 0.8, 1.0] {
            let loading = ContactHistory::at_rest(&law, LOAD).go(part * amplitude, LOAD).force;
            let mut contact = ContactHistory::at_rest(&law, LOAD);
            contact.go(amplitude, LOAD);
            let branch = contact.go(amplitude - 2.0 * part * amplitude, LOAD).force;
            close(branch, tip - 2.0 * loading, 1e-10);
        }
    }
}

#[test]
fn minor_loops_close_and_are_forgotten() {
    let law = law();
    let mut direct = ContactHistory::at_rest(&law, LOAD);
    let mut with_minor_loop = ContactHistory::at_rest(&law, LOAD);
    for u in [60e-6, -20e-6] {
        direct.go(u, LOAD);
        with_minor_loop.go(u, LOAD);
    }
    let before = with_minor_loop.go(-20e-6, LOAD).force;
    with_minor_loop.go(5e-6, LOAD);
    close(with_minor_loop.go(-20e-6, LOAD).force, before, 1e-10);
    close(with_minor_loop.go(-50e-6, LOAD).force, direct.go(-50e-6, LOAD).force, 1e-10);
    close(with_minor_loop.state[2], direct.state[2], 1e-18);
}

#[test]
fn loop_area_is_the_sum_of_4_limit_times_slip() {
    let law = law();
    for amplitude in [2e-6, 8e-6, 25e-6, 90e-6] {
        let (dissipated, tip) = ContactHistory::at_rest(&law, LOAD).last_loop(amplitude, LOAD, 3);
        let area = |(k, mu): &(f64, f64)| 4.0 * mu * LOAD * (amplitude - mu * LOAD / k).max(0.0);
        let total: f64 = ELEMENTS.iter().map(area).sum();
        close(dissipated, total, 1e-12 * total);
        close(tip, ELEMENTS.iter().map(|(k, mu)| (k * amplitude).min(mu * LOAD)).sum(), 1e-11);
    }
}

#[test]
fn one_step_equals_many_with_displacement_and_load_linear() {
    let law = law();
    for (start_load, end_load) in LOADS {
        for fraction in [-1.0, -0.4, 0.0, 0.7] {
            for travel in [-90e-6, -7e-6, 0.0, 1e-6, 35e-6] {
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
            for travel in [-110e-6, -21e-6, -3.1e-6, 0.13e-6, 4.3e-6, 57e-6] {
                let mut start =
                    ContactHistory::from(&law, 2e-6, start_load, fraction * law.limit(start_load));
                // Off the kink: an element that has just yielded may stick or slip.
                start.state[2..].iter_mut().for_each(|z| *z *= 0.995);
                let inputs = Inputs { displacement: 2e-6 + travel, velocity: 0.0, normal_load: end_load };
                check_derivatives(&law, &start.state, inputs, &|index| index != 1);
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
fn a_change_of_load_in_stick_creates_no_force() {
    let law = law();
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    let before = contact.go(2e-6, LOAD).force;
    for load in [1e3, 151.0, 1e9, 120.0] {
        let response = contact.go(2e-6, load);
        assert_eq!((response.force, response.dissipated_energy), (before, 0.0));
    }
}

#[test]
fn the_state_carries_the_force_that_loading_leads_to() {
    let law = law();
    for fraction in [-2.0, -1.0, -0.9, -0.1, 0.0, 0.05, 0.2, 0.6, 0.999, 1.0, 1e9] {
        let force = f64::clamp(fraction, -1.0, 1.0) * law.limit(LOAD);
        let mut contact = ContactHistory::from(&law, 7e-6, LOAD, fraction * law.limit(LOAD));
        close(contact.go(7e-6, LOAD).force, force, 1e-12 * law.limit(LOAD));
    }
    // The same place by loading.
    let mut loaded = ContactHistory::at_rest(&law, LOAD);
    let force = loaded.go(20e-6, LOAD).force;
    let set = ContactHistory::from(&law, 20e-6, LOAD, force);
    loaded.state.iter().zip(&set.state).for_each(|(a, b)| close(*a, *b, 1e-18));
}

#[test]
fn re_contact_remembers_nothing() {
    let law = law();
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    contact.go(80e-6, LOAD);
    let response = contact.go(70e-6, -1.0);
    assert_eq!((response.force, response.slip_state), (0.0, SlipState::Separated));
    assert_eq!(contact.state, ContactHistory::from(&law, 70e-6, -1.0, 9.0).state);
}

#[test]
fn bad_elements_are_named() {
    assert!(matches!(
        ParallelSliders::new(&[]).unwrap_err(),
        LawError::OutOfBounds { parameter: "number of sliders", .. }
    ));
    let error = ParallelSliders::new(&[(1e6, 0.1), (-1.0, 0.1)]).unwrap_err();
    assert!(matches!(error, LawError::OutOfBounds { parameter: "tangential_stiffness", .. }));
    let error = ParallelSliders::new(&[(1e6, f64::NAN)]).unwrap_err();
    assert!(matches!(error, LawError::OutOfBounds { parameter: "friction_coefficient", .. }));
}

#[test]
fn sliders_under_a_constant_load_are_the_law() {
    let law = law();
    let mut sliders = vec![Slider::linear(1.0)];
    assert!(law.sliders(LOAD, &mut sliders));
    assert_eq!(sliders.len(), 3);
    let (mut contact, mut positions) = (ContactHistory::at_rest(&law, LOAD), [0.0; 3]);
    for i in 0..300 {
        let u = 55e-6 * (0.3 * f64::from(i)).sin() + 20e-6 * (1.1 * f64::from(i)).cos();
        let mut sum = 0.0;
        for (slider, position) in sliders.iter().zip(&mut positions) {
            let (force, moved) = slider.step(*position, u);
            *position = moved;
            sum += force;
        }
        close(contact.go(u, LOAD).force, sum, 1e-11);
    }
    assert!(law.sliders(-1.0, &mut sliders) && sliders.is_empty());
}

/// A slider of each kind: symmetric, with play, one-sided friction, one-sided spring, linear.
fn kinds() -> [Slider; 5] {
    let uneven =
        Slider { play_below: -3e-6, play_above: 1e-6, lower_limit: 20.0, upper_limit: 45.0, stiffness: 2e6 };
    [
        Slider::jenkins(2e6, 30.0),
        Slider { play_below: -4e-6, play_above: 4e-6, ..Slider::jenkins(2e6, 30.0) },
        uneven,
        Slider::unilateral(2e6, 5e-6),
        Slider::linear(2e6),
    ]
}

#[test]
fn a_slider_without_play_steps_as_jenkins_element() {
    let (law, slider) = (Jenkins::new(2e6, 0.2).unwrap(), Slider::jenkins(2e6, 0.2 * LOAD));
    let (mut contact, mut position) = (ContactHistory::at_rest(&law, LOAD), 0.0);
    for i in 0..500 {
        let u = 25e-6 * (0.3 * f64::from(i)).sin() + 20e-6 * (1.1 * f64::from(i)).cos();
        let (force, moved) = slider.step(position, u);
        let response = contact.go(u, LOAD);
        close(force, response.force, 1e-13);
        close(moved, contact.state[0], 1e-20);
        position = moved;
    }
}

#[test]
fn a_slider_never_leaves_its_limits_nor_creates_energy() {
    for slider in kinds() {
        let mut position = 0.0;
        let (mut before, mut dissipated) = (0.0, 0.0);
        for i in 0..2000 {
            let i = f64::from(i);
            let u = 40e-6 * (0.3 * i).sin() + 20e-6 * (1.1 * i).cos() + 9e-6 * (0.017 * i).sin();
            let (force, moved) = slider.step(position, u);
            assert!(-slider.lower_limit <= force && force <= slider.upper_limit);
            // The slider moves under the force at its limit, so that their product is what is lost.
            let lost = force * (moved - position);
            assert!(lost >= 0.0, "{slider:?}: {lost:e}");
            // Halving the step changes nothing: the displacement ran one way.
            let (_, halfway) = slider.step(position, 0.5 * (before + u));
            let (same, there) = slider.step(halfway, u);
            close(same, force, 1e-9);
            close(there, moved, 1e-18);
            dissipated += lost;
            (position, before) = (moved, u);
        }
        assert_eq!(dissipated > 0.0, slider.upper_limit.is_finite());
    }
}

#[test]
fn only_an_even_slider_is_odd_in_its_history() {
    for slider in kinds() {
        let (mut position, mut mirrored, mut odd) = (0.0, 0.0, true);
        for u in [8e-6, 40e-6, -9e-6, -60e-6, 3e-6, 12e-6] {
            let (force, moved) = slider.step(position, u);
            let (other, mirror) = slider.step(mirrored, -u);
            odd &= force == -other;
            (position, mirrored) = (moved, mirror);
        }
        assert_eq!(odd, slider.is_odd(), "{slider:?}");
    }
}

#[test]
fn a_slider_hands_a_nan_on() {
    for slider in kinds() {
        assert!(slider.step(0.0, f64::NAN).0.is_nan());
    }
}
