//! Laws of the contacts without memory: the one-sided spring and the cubic spring.

use stickslip::contact::{
    ContactLaw, CubicSpring, Inputs, LawError, Slider, SlipState, StateTangents, Unilateral, periodic_state,
};

use crate::common::contact::{ContactHistory, check_derivatives, close};

fn laws() -> Vec<Box<dyn ContactLaw>> {
    vec![
        Box::new(Unilateral::new(2e6, 3e-6).unwrap()),
        Box::new(Unilateral::new(2e6, -3e-6).unwrap()),
        Box::new(CubicSpring::new(2e6, 1e15).unwrap()),
        Box::new(CubicSpring::new(2e6, -1e14).unwrap()),
        Box::new(CubicSpring::new(0.0, 1e15).unwrap()),
    ]
}

#[test]
fn force_depends_on_displacement_alone() {
    for law in laws() {
        assert_eq!(law.state_len(), 0);
        let mut contact = ContactHistory::at_rest(law.as_ref(), 100.0);
        let expected = contact.go(7e-6, 100.0);
        for (u, load) in [(-40e-6, 3.0), (7e-6, -50.0), (1e-6, 0.0), (7e-6, 1e9)] {
            let response = contact.go(u, load);
            assert_eq!(response.dissipated_energy, 0.0);
            if u == 7e-6 {
                assert_eq!(response, expected);
            }
        }
    }
}

#[test]
fn work_over_a_closed_path_is_zero_and_force_is_the_slope_of_the_energy() {
    for law in laws() {
        let mut contact = ContactHistory::at_rest(law.as_ref(), 100.0);
        let samples = 20_000;
        let at = |i: usize| 12e-6 * (std::f64::consts::TAU * i as f64 / samples as f64).sin() + 2e-6;
        let (mut work, mut path, mut force) = (0.0, 0.0, contact.go(at(0), 1.0).force);
        for i in 1..=samples {
            let (response, du) = (contact.go(at(i), 1.0), at(i) - at(i - 1));
            work += 0.5 * (force + response.force) * du;
            path += (response.force * du).abs();
            force = response.force;
        }
        assert!(work.abs() <= 1e-9 * path, "{law:?}: {work:e} of {path:e}");
    }
}

#[test]
fn tangents_equal_finite_differences() {
    for law in laws() {
        for displacement in [-9e-6, -1e-6, 2.5e-6, 3.5e-6, 11e-6] {
            let inputs = Inputs { displacement, velocity: 0.3, normal_load: 20.0 };
            check_derivatives(law.as_ref(), &[], inputs, &|_| true);
        }
        let mut out = StateTangents::default();
        out.reset(3);
        law.state_tangents(&[], Inputs { displacement: 1.0, velocity: 0.0, normal_load: 1.0 }, &mut out);
        assert_eq!(out, StateTangents::default());
    }
}

#[test]
fn a_contact_without_memory_is_periodic_at_once() {
    for law in laws() {
        let info = periodic_state(law.as_ref(), &[1e-6, 5e-6, -2e-6], &[1.0], &mut []).unwrap();
        assert_eq!((info.iterations, info.residual), (0, 0.0));
    }
}

#[test]
fn one_sided_spring_resists_beyond_its_gap_alone() {
    let law = Unilateral::new(2e6, 3e-6).unwrap();
    let mut contact = ContactHistory::at_rest(&law, 100.0);
    for u in [-1.0, 0.0, 3e-6] {
        let response = contact.go(u, 100.0);
        assert_eq!((response.force, response.slip_state), (0.0, SlipState::Separated));
    }
    let response = contact.go(8e-6, 100.0);
    close(response.force, 10.0, 1e-12);
    assert_eq!((response.tangents.displacement, response.slip_state), (2e6, SlipState::Stick));
    // Preloaded by a negative gap.
    let law = Unilateral::new(2e6, -3e-6).unwrap();
    close(ContactHistory::at_rest(&law, 1.0).go(0.0, 1.0).force, 6.0, 1e-12);
    assert!(!law.is_odd());
}

#[test]
fn sliders_of_contacts_without_memory() {
    let mut sliders = vec![Slider::linear(1.0); 2];
    let law = Unilateral::new(2e6, 3e-6).unwrap();
    // At any load: the law does not depend on it.
    for load in [-5.0, 0.0, 100.0] {
        assert!(law.sliders(load, &mut sliders));
        assert_eq!(sliders, [Slider::unilateral(2e6, 3e-6)]);
    }
    assert!(!sliders[0].is_odd());
    assert!(!CubicSpring::new(1e6, 1e15).unwrap().sliders(1.0, &mut sliders));
    assert!(CubicSpring::new(1e6, 0.0).unwrap().sliders(1.0, &mut sliders));
    assert_eq!(sliders, [Slider::linear(1e6)]);
    assert!(CubicSpring::new(0.0, 0.0).unwrap().sliders(1.0, &mut sliders) && sliders.is_empty());
}

#[test]
fn cubic_spring_is_odd_and_follows_its_polynomial() {
    let law = CubicSpring::new(3.0, -0.25).unwrap();
    assert!(law.is_odd());
    for u in [0.0, 0.5, 2.0, -1.5] {
        let response = ContactHistory::at_rest(&law, 1.0).go(u, 1.0);
        close(response.force, 3.0 * u - 0.25 * u * u * u, 1e-15);
        close(response.tangents.displacement, 3.0 - 0.75 * u * u, 1e-15);
    }
    // Turns round at √(k/(−3 k₃)) = 2.
    close(ContactHistory::at_rest(&law, 1.0).go(2.0, 1.0).tangents.displacement, 0.0, 1e-15);
}

#[test]
fn bad_parameters_are_named() {
    let name = |error: LawError| match error {
        LawError::OutOfBounds { parameter, .. } => parameter,
        other => panic!("{other}"),
    };
    assert_eq!(name(Unilateral::new(0.0, 1.0).unwrap_err()), "tangential_stiffness");
    assert_eq!(name(Unilateral::new(1.0, f64::INFINITY).unwrap_err()), "gap");
    assert_eq!(name(CubicSpring::new(-1.0, 1.0).unwrap_err()), "tangential_stiffness");
    assert_eq!(name(CubicSpring::new(1.0, f64::NAN).unwrap_err()), "cubic_stiffness");
}
