//! A first response is found where equivalent linearisation leads nowhere: one-sided springs without a gap, and
//! friction so stiff that it is Coulomb's.

use stickslip::contact::{ContactLaw, Jenkins, Unilateral};
use stickslip::harmonic::{Control, CurveSettings, Point, frequency_response, periodic_response};

use crate::common::oscillator::{in_contact, settings, single, two_masses};

fn response(law: impl ContactLaw + 'static, omega: f64, control: &Control) -> Point {
    let structure = two_masses(0.1);
    let assembly = in_contact(&structure, law);
    let settings = settings(15);
    periodic_response(&assembly, omega, control, &settings, None).expect("a response")
}

#[test]
fn a_one_sided_spring_without_gap_answers_in_proportion_to_the_force() {
    for stiffness in [0.1, 1.0, 5.0] {
        let law = Unilateral::new(stiffness, 0.0).unwrap();
        for omega in [0.2, 0.7, 1.6] {
            let weak = response(law, omega, &Control::Level(0.4));
            let strong = response(law, omega, &Control::Level(0.8));
            for (weak, strong) in weak.amplitude.iter().zip(&strong.amplitude) {
                assert!((strong / weak - 2.0).abs() < 1e-6, "{stiffness} {omega}: {weak} {strong}");
            }
            // It pushes one way only.
            assert!(weak.nodes[1][0] < 0.0, "{stiffness} {omega}");
        }
    }
}

#[test]
fn a_response_held_against_a_one_sided_spring_has_its_amplitude() {
    let law = Unilateral::new(5.0, 0.0).unwrap();
    let held = Control::Held { node: 0, order: 1, derivative: 0, amplitude: 0.5 };
    let point = response(law, 0.3, &held);
    assert!((point.nodes[0][1].hypot(point.nodes[0][2]) - 0.5).abs() < 1e-8);
}

#[test]
fn friction_ever_stiffer_becomes_that_of_coulomb() {
    for omega in [0.2, 0.8, 1.3] {
        let at = |stiffness: f64| {
            response(Jenkins::new(stiffness, 0.02).unwrap(), omega, &Control::Level(0.4)).amplitude[1]
        };
        let coulomb = at(1e8);
        let mut before = 2e-3;
        for stiffness in [1e3, 1e4, 1e5, 1e6] {
            let off = (at(stiffness) - coulomb).abs();
            assert!(off < before, "{omega} {stiffness}: {off}");
            before = 0.5 * off;
        }
    }
}

#[test]
fn a_mass_that_sticks_and_slips_has_a_start_at_any_frequency() {
    let structure = single(1.0, 0.02, 1.0, 1);
    for (stiffness, omega, harmonics) in [(1e2, 0.3, 31), (1e2, 0.2, 21), (1e3, 0.3, 21), (1e4, 0.2, 21)] {
        let law = Jenkins::new(stiffness, 0.1).unwrap();
        let assembly = in_contact(&structure, law);
        let settings = settings(harmonics);
        let point = periodic_response(&assembly, omega, &Control::Level(1.0), &settings, None)
            .unwrap_or_else(|error| panic!("{stiffness} {omega} {harmonics}: {error}"));
        // Below resonance the spring carries what friction leaves: within 0.1 N either way of what it would carry alone.
        let alone = 1.0 / (1.0 - omega * omega);
        assert!(
            (point.amplitude[0] / alone - 0.9).abs() < 0.1,
            "{stiffness} {omega}: {}",
            point.amplitude[0]
        );
    }
}

#[test]
fn a_curve_that_adapts_its_harmonics_starts_among_stick_and_slip() {
    let structure = single(1.0, 0.02, 1.0, 1);
    let law = Jenkins::new(1e2, 0.1).unwrap();
    let assembly = in_contact(&structure, law);
    let settings = CurveSettings { truncation: Some(1e-3), ..CurveSettings::default() };
    let curve =
        frequency_response(&assembly, 0.3, 0.4, &Control::Level(1.0), &settings, &mut |_| true).unwrap();
    assert!((curve.points[0].amplitude[0] / 0.8996 - 1.0).abs() < 5e-3, "{}", curve.points[0].amplitude[0]);
}
