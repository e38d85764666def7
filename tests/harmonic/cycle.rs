//! Contacts carried over a period: closed forms, brute-force integration, the published loops.

use std::f64::consts::{PI, TAU};

use nalgebra::DMatrix;
use stickslip::contact::{ContactLaw, Inputs, Jenkins, Valanis};
use stickslip::harmonic::fourier::value;
use stickslip::harmonic::{ContactMapping, HarmonicSet, Method, contact_cycle};

use crate::common::contact::{self, LOAD};
use crate::common::cycle::{Sliders, cases, evaluated, largest, motions};

/// Force coefficients `0..=harmonics` by stepping through two periods of very many samples, the force taken to
/// run linearly between them.
fn marched(law: &dyn ContactLaw, compliance: f64, u: &[f64], harmonics: usize, samples: usize) -> Vec<f64> {
    let n = law.state_len();
    let (mut state, mut next) = (vec![0.0; n], vec![0.0; n]);
    law.set_state(0.0, LOAD, 0.0, &mut state);
    let phase = |k: usize| TAU * (k % samples) as f64 / samples as f64;
    let first =
        (0..samples).max_by(|a, b| value(u, phase(*a)).abs().total_cmp(&value(u, phase(*b)).abs())).unwrap();
    let mut out = vec![0.0; 2 * harmonics + 1];
    let mut force = 0.0;
    for round in 0..3 {
        for i in 0..samples {
            let total = value(u, phase(first + i));
            // T = F(u − a T) by bisection: the force grows with the displacement.
            let mut respond = |force: f64| {
                let inputs =
                    Inputs { displacement: total - compliance * force, velocity: 0.0, normal_load: LOAD };
                law.step(&state, inputs, &mut next).force
            };
            if compliance == 0.0 {
                force = respond(0.0);
            } else {
                let (mut low, mut high) = (-100.0, 100.0);
                for _ in 0..60 {
                    force = 0.5 * (low + high);
                    if respond(force) > force { low = force } else { high = force }
                }
            }
            std::mem::swap(&mut state, &mut next);
            if round == 2 {
                let weight = 2.0 / samples as f64;
                out[0] += 0.5 * weight * force;
                for h in 1..=harmonics {
                    let (sin, cos) = (h as f64 * phase(first + i)).sin_cos();
                    out[2 * h - 1] += weight * force * cos;
                    out[2 * h] += weight * force * sin;
                }
            }
        }
    }
    out
}

#[test]
fn jenkins_loop_area_equals_4_limit_times_slip() {
    let law = Jenkins::new(3.0, 0.5 / LOAD).unwrap();
    for amplitude in [0.17, 0.4, 1.0, 30.0] {
        for set in [HarmonicSet::full(3), HarmonicSet::odd(3)] {
            let mut u = vec![0.0; set.len()];
            let place = set.place(1).unwrap();
            (u[place], u[place + 1]) = (0.6 * amplitude, -0.8 * amplitude);
            let mut map = evaluated(&law, 0.0, set, &u);
            let summary = map.summary();
            let area = 4.0 * 0.5 * (amplitude - 0.5 / 3.0);
            assert!((summary.dissipated_energy / area - 1.0).abs() < 1e-13, "{amplitude}");
            assert!((summary.equivalent_stiffness * amplitude / 0.5 - 1.0).abs() < 1e-13);
            // Stick from a crest until the displacement has come back by twice the limit.
            let stick = (1.0 - 2.0 * 0.5 / 3.0 / amplitude).acos() / PI;
            assert!((summary.stick_fraction.unwrap() - stick).abs() < 1e-13);
            // The first harmonic of the force does the same work.
            let work = PI * (map.force()[place] * u[place + 1] - map.force()[place + 1] * u[place]);
            assert!((work.abs() / area - 1.0).abs() < 1e-12, "{amplitude}");
        }
    }
}

#[test]
fn stuck_contact_is_a_spring() {
    let law = Jenkins::new(3.0, 0.5 / LOAD).unwrap();
    for (_, u) in motions() {
        let u: Vec<f64> = u.iter().map(|x| 0.05 * x).collect();
        let mut map = evaluated(&law, 0.1, HarmonicSet::full(5), &u);
        let stiffness = 3.0 / (1.0 + 0.1 * 3.0);
        for (f, u) in map.force().iter().zip(&u) {
            assert!((f - stiffness * u).abs() < 1e-15);
        }
        let identity = DMatrix::from_diagonal_element(11, 11, stiffness);
        assert!((map.jacobian() - identity).abs().max() < 1e-14);
        let summary = map.summary();
        assert_eq!((summary.dissipated_energy, summary.stick_fraction), (0.0, Some(1.0)));
        assert!((summary.equivalent_stiffness - 3.0).abs() < 1e-13);
    }
}

#[test]
fn coefficients_are_those_of_a_marched_contact() {
    for (name, sliders) in cases() {
        let law = Sliders(sliders);
        for (motion, u) in motions() {
            let map = evaluated(&law, 0.0, HarmonicSet::full(5), &u);
            let error = |samples: usize| {
                let expected = marched(&law, 0.0, &u, 5, samples);
                largest(expected.iter().zip(map.force()).map(|(a, b)| a - b))
            };
            let (coarse, fine) = (error(400), error(4000));
            assert!(fine < 5e-6, "{name}, {motion}: {coarse:e} {fine:e}");
            assert!(fine < 0.1 * coarse || fine < 1e-6, "{name}, {motion}: {coarse:e} {fine:e}");
        }
    }
}

#[test]
fn contact_behind_a_spring_is_that_of_a_marched_one() {
    for (name, sliders) in cases() {
        let law = Sliders(sliders);
        for (motion, u) in motions() {
            let map = evaluated(&law, 0.2, HarmonicSet::full(5), &u);
            let expected = marched(&law, 0.2, &u, 5, 1000);
            let error = largest(expected.iter().zip(map.force()).map(|(a, b)| a - b));
            assert!(error < 1e-4, "{name}, {motion}: {error:e}");
        }
    }
}

#[test]
fn force_on_more_harmonics_continues_the_force() {
    for (name, sliders) in cases() {
        let law = Sliders(sliders);
        for (set, u) in [
            (HarmonicSet::full(5), motions()[2].1.to_vec()),
            (HarmonicSet::odd(5), vec![0.7, 0.4, -0.5, 0.6, 0.3, -0.2]),
        ] {
            let mut map = evaluated(&law, 0.0, set, &u);
            let wider = map.force_on(HarmonicSet::full(9));
            let mut padded = vec![0.0; 19];
            set.convert(&u, HarmonicSet::full(9), &mut padded);
            let expected = evaluated(&law, 0.0, HarmonicSet::full(9), &padded);
            let error = largest(expected.force().iter().zip(&wider).map(|(a, b)| a - b));
            assert!(error < 1e-13, "{name}: {error:e}");
        }
    }
}

#[test]
fn a_jenkins_element_is_the_same_by_the_sampled_way_to_its_second_order() {
    let law = Jenkins::new(3.0, 0.5 / LOAD).unwrap();
    let u = motions()[2].1;
    let exact = evaluated(&law, 0.1, HarmonicSet::full(5), &u);
    let error = |samples: usize| {
        let mut map = ContactMapping::new(HarmonicSet::full(5), Method::Sampled { samples });
        map.evaluate(&law, LOAD, 0.1, 300.0, &u).unwrap();
        largest(map.force().iter().zip(exact.force()).map(|(a, b)| a - b))
    };
    let (coarse, fine) = (error(256), error(2048));
    assert!(fine < coarse / 30.0 && fine < 1e-5, "{coarse:e} {fine:e}");
}

/// Tip (N) and area (J) of the symmetric loop of Valanis' law without residual stiffness.
fn valanis_loop(e0: f64, kappa: f64, lambda: f64, amplitude: f64) -> (f64, f64) {
    // λ X = κ x + (1 − κ) y with x = tanh y, by Newton in y.
    let mut y = lambda * amplitude;
    for _ in 0..100 {
        let x = f64::tanh(y);
        y -= (kappa * x + (1.0 - kappa) * y - lambda * amplitude) / (1.0 - kappa * x * x);
    }
    // y − tanh y without cancellation where y is small.
    let rest = if y < 0.3 {
        let s = y * y;
        y * s / 3.0
            * (1.0
                - s * (0.4
                    - s * (17.0 / 105.0 - s * (62.0 / 945.0 - s * (1382.0 / 51975.0 - s * 0.0107668)))))
    } else {
        y - f64::tanh(y)
    };
    (e0 / lambda * f64::tanh(y), 4.0 * (1.0 - kappa) * e0 / (lambda * lambda) * rest)
}

#[test]
fn valanis_loops_have_the_closed_form_and_the_published_tips_and_areas() {
    let law = contact::published();
    let published = [
        (1e-6, 7.886058, 6.40993067e-7),
        (10e-6, 66.332303, 5.82422872e-4),
        (20e-6, 87.961333, 3.22016858e-3),
        (50e-6, 90.802885, 1.39860743e-2),
        (100e-6, 90.804598, 3.21469150e-2),
    ];
    for (amplitude, tip, area) in published {
        let (exact_tip, exact_area) = valanis_loop(7.9e6, 0.3, 8.7e4, amplitude);
        assert!((exact_tip - tip).abs() < 5.1e-7 && (exact_area / area - 1.0).abs() < 5e-9, "{amplitude:e}");
        for set in [HarmonicSet::full(1), HarmonicSet::odd(1), HarmonicSet::full(18), HarmonicSet::odd(35)] {
            let mut u = vec![0.0; set.len()];
            let place = set.place(1).unwrap();
            u[place + 1] = amplitude;
            let cycle = contact_cycle(&law, LOAD, 300.0, &u, set).unwrap();
            let summary = cycle.summary;
            let (tip, area) = (summary.equivalent_stiffness * amplitude, summary.dissipated_energy);
            assert!((tip / exact_tip - 1.0).abs() < 1e-11, "{amplitude:e} {set:?}: {tip} {exact_tip}");
            assert!((area / exact_area - 1.0).abs() < 1e-9, "{amplitude:e} {set:?}: {area:e} {exact_area:e}");
            assert_eq!(summary.stick_fraction, None);
            // The first harmonic of the force, from quadrature, does the work of the closed form.
            let work = PI * cycle.force[place] * amplitude;
            let error = (work - area) / (tip * amplitude);
            assert!(error.abs() < 1e-10, "{amplitude:e} {set:?}: {error:e}");
        }
    }
}

#[test]
fn valanis_coefficients_converge() {
    // The nodes follow from the harmonics asked for: with more of them the same coefficients come out.
    let law = contact::published();
    let softer = Valanis::from_lambda(7.9e6, 3e5, 0.7, 8.7e4, LOAD).unwrap();
    for law in [law, softer] {
        for scale in [1e-6, 10e-6, 100e-6, 1e-3] {
            for (_, motion) in motions() {
                let set = HarmonicSet::full(18);
                let mut u = vec![0.0; set.len()];
                u.iter_mut().zip(&motion).for_each(|(u, m)| *u = scale * m);
                let map = evaluated(&law, 1e-9, set, &u);
                let fine = HarmonicSet::full(60);
                let mut padded = vec![0.0; fine.len()];
                set.convert(&u, fine, &mut padded);
                let reference = evaluated(&law, 1e-9, fine, &padded);
                let size = largest(reference.force().iter().copied());
                let error = largest(map.force().iter().zip(reference.force()).map(|(a, b)| a - b)) / size;
                assert!(error < 1e-10, "{scale:e}: {error:e}");
                let stiff = reference.jacobian().abs().max();
                let view = reference.jacobian().view((0, 0), (set.len(), set.len()));
                let error = (map.jacobian() - view).abs().max() / stiff;
                assert!(error < 1e-6, "{scale:e}: Jacobian {error:e}");
            }
        }
    }
}

#[test]
fn valanis_is_the_same_by_the_sampled_way_to_its_second_order() {
    let law = Valanis::from_lambda(7.9e6, 2e5, 0.3, 8.7e4, LOAD).unwrap();
    let u: Vec<f64> = motions()[2].1.iter().map(|x| 2e-5 * x).collect();
    let exact = evaluated(&law, 1e-8, HarmonicSet::full(5), &u);
    let error = |samples: usize| {
        let mut map = ContactMapping::new(HarmonicSet::full(5), Method::Sampled { samples });
        map.evaluate(&law, LOAD, 1e-8, 300.0, &u).unwrap();
        largest(map.force().iter().zip(exact.force()).map(|(a, b)| a - b))
    };
    let (coarse, fine) = (error(256), error(2048));
    assert!(fine < coarse / 30.0 && fine < 1e-2, "{coarse:e} {fine:e}");
}

#[test]
fn bad_input_is_an_error() {
    let law = Jenkins::new(3.0, 0.5).unwrap();
    let mut map = ContactMapping::new(HarmonicSet::full(1), Method::Exact);
    assert!(map.evaluate(&law, 1.0, 0.0, 1.0, &[0.0; 2]).is_err());
    assert!(map.evaluate(&law, 1.0, -1.0, 1.0, &[0.0; 3]).is_err());
    assert!(map.evaluate(&law, 1.0, 0.0, 1.0, &[0.0, f64::NAN, 0.0]).is_err());
    assert!(map.evaluate(&law, 1.0, 0.0, 1.0, &[0.0, 1e200, 0.0]).is_err());
    assert!(map.evaluate(&law, -1.0, 0.0, 1.0, &[0.0, 1.0, 0.0]).is_ok());
    assert_eq!(map.force(), [0.0; 3]);
    assert_eq!(map.summary().stick_fraction, Some(0.0));
}
