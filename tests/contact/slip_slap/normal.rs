//! The normal direction: closed forms, lift-off, Hunt and Crossley's loop.

use stickslip::contact::{NormalDirection, NormalLaw};

use super::{PRELOAD, STIFFNESS, normal, normals};
use crate::common::contact::close;

#[test]
fn at_rest_every_law_carries_the_preload_with_its_stiffness() {
    for direction in normals() {
        let [force, slope, _] = direction.force_and_slopes(0.0, 0.0);
        close(force, PRELOAD, 1e-12 * PRELOAD);
        close(slope, -STIFFNESS, 1e-12 * STIFFNESS);
    }
}

#[test]
fn the_static_approach_of_hertz_law_is_its_closed_form() {
    for exponent in [1.0, 1.25, 1.5, 2.0] {
        let constant = 3e9;
        let hertz = NormalDirection::hertz(constant, exponent, PRELOAD, 0.0).unwrap();
        let approach = (PRELOAD / constant).powf(1.0 / exponent);
        close(hertz.static_approach(), approach, 1e-12 * approach);
        for displacement in [-2.0 * approach, -0.3 * approach, 0.6 * approach] {
            let expected = constant * (approach - displacement).powf(exponent);
            close(hertz.force(displacement, 0.0), expected, 1e-11 * expected);
        }
    }
}

#[test]
fn hertz_law_of_power_one_is_the_linear_law() {
    let (hertz, linear) = (normal(NormalLaw::Hertz { exponent: 1.0 }, 20.0), normal(NormalLaw::Linear, 20.0));
    for place in -20..20 {
        let (displacement, velocity) = (f64::from(place) * 3e-7, f64::from(place % 7) * 1e-2);
        close(hertz.force(displacement, velocity), linear.force(displacement, velocity), 1e-11);
    }
}

#[test]
fn bodies_part_at_the_static_approach_and_never_pull() {
    for direction in normals() {
        let parting = direction.static_approach();
        assert!(direction.force(parting * (1.0 - 1e-9), 0.0) > 0.0);
        for place in 0..50 {
            assert_eq!(direction.force(parting * (1.0 + f64::from(place)), -0.1), 0.0);
            assert!(direction.force(-parting, f64::from(place) * 1e-2) >= 0.0, "however fast they part");
        }
    }
}

#[test]
fn the_force_falls_as_the_elastic_energy_does() {
    for direction in normals() {
        for place in [-3.0, -0.5, 0.2, 0.8] {
            let (at, span) = (place * direction.static_approach(), 1e-10);
            let slope =
                (direction.stored_energy(at + span) - direction.stored_energy(at - span)) / (2.0 * span);
            close(-slope, direction.force(at, 0.0), 1e-4 * PRELOAD);
        }
        assert_eq!(direction.stored_energy(direction.static_approach()), 0.0);
    }
}

#[test]
fn illegal_numbers_are_refused_by_name() {
    let refused = |law, preload, stiffness, damping| {
        NormalDirection::new(law, preload, stiffness, damping).unwrap_err().to_string()
    };
    let hertz = |exponent| NormalLaw::Hertz { exponent };
    assert!(refused(NormalLaw::Linear, 1.0, 0.0, 0.0).starts_with("normal_stiffness"));
    assert!(refused(NormalLaw::Linear, -1.0, 1.0, 0.0).starts_with("normal_load"));
    assert!(refused(NormalLaw::Linear, 1.0, 1.0, -1.0).starts_with("impact_damping"));
    assert!(refused(NormalLaw::Cubic { cubic_stiffness: -1.0 }, 1.0, 1.0, 0.0).starts_with("normal_cubic"));
    assert!(refused(hertz(2.1), 1.0, 1.0, 0.0).starts_with("normal_exponent"));
    assert!(refused(hertz(1.5), 0.0, 1.0, 0.0).starts_with("normal_load"));
}
