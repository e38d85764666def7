//! Sliders with a viscous damper beside them: exact, as the damper is linear in the motion.

use std::f64::consts::PI;

use super::map::ContactMap;
use super::reference::ReferenceCycle;
use super::{Cycle, PeriodicContact};
use crate::contact::JointChanges;
use crate::contact::{ContactLaw, Jenkins, Joint};
use crate::harmonic::Method;
use crate::numeric::HarmonicSet;

const OMEGA: f64 = 300.0;
const DAMPING: f64 = 2e-3;
const STIFFNESS: f64 = 1.0;

/// A slider with a damper beside it, of the limit 0.4 under the load 1.
fn law() -> Joint {
    let changes = JointChanges { damping: DAMPING, ..JointChanges::default() };
    Joint::new(Jenkins::new(STIFFNESS, 0.4).unwrap(), changes).unwrap()
}

fn evaluated<C: Cycle>(mut cycle: C, law: &dyn ContactLaw, angular_frequency: f64, u: &[f64]) -> C {
    let contact = PeriodicContact { law, normal_load: 1.0, load_swing: &[], compliance: 0.0 };
    cycle.evaluate(&contact, angular_frequency, u).unwrap();
    cycle
}

fn damped(law: &dyn ContactLaw, angular_frequency: f64, u: &[f64]) -> ContactMap {
    evaluated(ContactMap::new(HarmonicSet::full(u.len() / 2), Method::Exact, 0.0), law, angular_frequency, u)
}

/// Slips in both directions, with harmonics that make no reversal more.
const SLIPPING: [f64; 7] = [0.1, 1.0, 0.2, 0.05, -0.1, 0.03, 0.04];

#[test]
fn in_stick_the_loop_is_the_ellipse_of_a_dashpot() {
    let (bias, c, s) = (0.02, 0.15, -0.2);
    let mut cycle = damped(&law(), OMEGA, &[bias, c, s]);
    let rate = DAMPING * OMEGA;
    let expected = [STIFFNESS * bias, STIFFNESS * c + rate * s, STIFFNESS * s - rate * c];
    for (force, expected) in cycle.force().iter().zip(expected) {
        assert!((force - expected).abs() < 1e-13, "{force} {expected}");
    }
    let area = PI * rate * (c * c + s * s);
    assert!((cycle.summary().dissipated_energy / area - 1.0).abs() < 1e-13);
}

#[test]
fn in_slip_the_damper_adds_its_ellipses_to_the_loop_of_the_slider() {
    let slider = Jenkins::new(STIFFNESS, 0.4).unwrap();
    let alone = damped(&slider, OMEGA, &SLIPPING).summary().dissipated_energy;
    let squares: f64 =
        (1..=3).map(|h| (h * h) as f64 * (SLIPPING[2 * h - 1].powi(2) + SLIPPING[2 * h].powi(2))).sum();
    let expected = alone + PI * DAMPING * OMEGA * squares;
    assert!(alone > 0.0);
    assert!((damped(&law(), OMEGA, &SLIPPING).summary().dissipated_energy / expected - 1.0).abs() < 1e-12);
}

#[test]
fn the_sampled_cycle_converges_to_it() {
    let exact = damped(&law(), OMEGA, &SLIPPING);
    let errors = [256, 1024].map(|samples| {
        let sampled = ReferenceCycle::new(HarmonicSet::full(3), samples);
        let sampled = evaluated(sampled, &law(), OMEGA, &SLIPPING);
        let force = exact.force().iter().zip(sampled.force()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (force, (exact.jacobian() - sampled.jacobian()).amax())
    });
    // Turning points are met to the second order of the step, the onset of slip to the first in its derivative.
    assert!(errors[1].0 < 1e-4 && errors[1].0 < 0.15 * errors[0].0, "{errors:?}");
    assert!(errors[1].1 < 1e-2 && errors[1].1 < 0.5 * errors[0].1, "{errors:?}");
}

#[test]
fn derivatives_are_those_of_the_force() {
    let cycle = damped(&law(), OMEGA, &SLIPPING);
    let step = 1e-6;
    for column in 0..SLIPPING.len() {
        let at = |sign: f64| {
            let mut moved = SLIPPING;
            moved[column] += sign * step;
            damped(&law(), OMEGA, &moved)
        };
        let (ahead, behind) = (at(1.0), at(-1.0));
        for row in 0..SLIPPING.len() {
            let expected = (ahead.force()[row] - behind.force()[row]) / (2.0 * step);
            assert!((cycle.jacobian()[(row, column)] - expected).abs() < 1e-5, "{row} {column}");
        }
    }
    let (ahead, behind) = (damped(&law(), OMEGA + 0.1, &SLIPPING), damped(&law(), OMEGA - 0.1, &SLIPPING));
    for row in 0..SLIPPING.len() {
        let expected = (ahead.force()[row] - behind.force()[row]) / 0.2;
        assert!((cycle.by_frequency()[row] - expected).abs() < 1e-9, "{row}");
    }
}

#[test]
fn on_more_harmonics_the_known_ones_stay() {
    let mut cycle = damped(&law(), OMEGA, &SLIPPING);
    let mut more = vec![0.0; 15];
    cycle.force_on(HarmonicSet::full(7), &mut more);
    for (known, force) in cycle.force().iter().zip(&more) {
        assert!((known - force).abs() < 1e-12);
    }
    let mut alone = vec![0.0; 15];
    let law = law();
    let contact = PeriodicContact { law: &law, normal_load: 1.0, load_swing: &[], compliance: 0.0 };
    let mut fresh = ContactMap::new(HarmonicSet::full(3), Method::Exact, 0.0);
    fresh.force_alone(&contact, OMEGA, &SLIPPING, HarmonicSet::full(7), &mut alone).unwrap();
    more.iter().zip(&alone).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{a} {b}"));
}
