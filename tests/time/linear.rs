//! Time integration where the exact solution is known in closed form, or from an independent method.

use stickslip::time::{Outputs, Ramp, Settings};

use crate::common::beam::{one_mode, steel_beam};
use crate::common::time::{Spring, held, loaded, rest, supported, tolerance};

const FREE: Ramp = Ramp::held(0.0);

#[test]
fn a_free_mode_decays_as_the_closed_form_says() {
    let (omega, zeta) = (330.0, 0.02);
    let mut integrator = loaded(&one_mode(omega, zeta, 0.06, 1.2, 0.0));
    let mut motion = integrator.moving(&[1e-3], &[0.4], &[FREE; 2], &[]).unwrap();
    let inputs = [FREE; 2];
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    for i in 1..=200 {
        integrator.advance(&mut motion, 1e-3, &inputs, &Settings::default()).unwrap();
        let t = i as f64 * 1e-3;
        let (s, c) = (damped * t).sin_cos();
        let exact = (-zeta * omega * t).exp() * (1e-3 * c + (0.4 + zeta * omega * 1e-3) / damped * s);
        assert!((motion.modal_displacement()[0] - exact).abs() < 1e-14, "at {t}");
    }
}

#[test]
fn a_linear_mode_answers_a_force_ramp_exactly_whatever_the_step() {
    let (omega, phi) = (330.0, 1.2);
    for (steps, duration) in [(1, 1e-2), (10, 1e-3), (10_000, 1e-6)] {
        let mut integrator = loaded(&one_mode(omega, 0.0, 0.06, phi, 0.0));
        let mut motion = rest(&mut integrator);
        for i in 0..steps {
            let excitation = Ramp::with_slope(3.0 + 500.0 * i as f64 * duration, 500.0, duration);
            let inputs = [excitation, FREE];
            integrator.advance(&mut motion, duration, &inputs, &Settings::default()).unwrap();
        }
        let (s, c) = (omega * 1e-2).sin_cos();
        let exact = phi * (3.0 * (1.0 - c) + 500.0 * (1e-2 - s / omega)) / (omega * omega);
        let q = motion.modal_displacement()[0];
        assert!((q - exact).abs() < 1e-13 * exact.abs().max(1e-4), "{steps} steps: {q} {exact}");
    }
}

/// Largest relative error over ten periods of a mode held by a linear spring in the contact.
fn spring_error(settings: &Settings) -> f64 {
    let (omega, shape, stiffness) = (330.0, 0.06, 4e7);
    let mut integrator = supported(&one_mode(omega, 0.0, shape, 1.2, 0.0), Spring(stiffness), 1.0);
    let mut motion = integrator.moving(&[1e-3], &[0.0], &held(0.0, 1.0), &[]).unwrap();
    let total = (omega * omega + shape * shape * stiffness).sqrt();
    let duration = 1e-2;
    (1..=20).fold(0.0, |worst: f64, i| {
        integrator.advance(&mut motion, duration, &held(0.0, 1.0), settings).unwrap();
        let exact = 1e-3 * (total * duration * i as f64).cos();
        worst.max((motion.modal_displacement()[0] - exact).abs() / 1e-3)
    })
}

#[test]
fn the_error_falls_with_the_tolerance() {
    let errors = [1e-4, 1e-6, 1e-8, 1e-10].map(|t| spring_error(&tolerance(t)));
    for (error, tolerance) in errors.iter().zip([1e-4, 1e-6, 1e-8, 1e-10]) {
        assert!(*error < 5.0 * tolerance, "{errors:?}");
    }
    for pair in errors.windows(2) {
        assert!(pair[1] < pair[0] / 20.0, "{errors:?}");
    }
}

#[test]
fn a_spring_in_the_contact_is_of_fifth_order_in_the_step() {
    let (omega, shape, stiffness) = (330.0_f64, 0.06, 4e7);
    let total = (omega * omega + shape * shape * stiffness).sqrt();
    let error = |steps: usize| {
        let mut integrator = supported(&one_mode(omega, 0.0, shape, 1.2, 0.0), Spring(stiffness), 1.0);
        let mut motion = integrator.moving(&[1e-3], &[0.0], &held(0.0, 1.0), &[]).unwrap();
        let duration = 6e-3 / steps as f64;
        // The tolerance never cuts these communication steps: the order shows.
        for _ in 0..steps {
            integrator.advance(&mut motion, duration, &held(0.0, 1.0), &tolerance(1e-5)).unwrap();
        }
        (motion.modal_displacement()[0] - 1e-3 * (total * 6e-3).cos()).abs()
    };
    let order = (error(15) / error(30)).log2();
    assert!((4.7..6.5).contains(&order), "{order}");
}

#[test]
fn external_force_and_geometric_stiffness_match_runge_kutta() {
    let beam = steel_beam(3, 0.003);
    let (force, excitation) = (Ramp::line(80.0, -60.0), Ramp::line(0.0, 30.0));
    let duration = 5e-3;
    let inputs = [excitation, force];
    let (q0, v0) = ([2e-3, -1e-4, 3e-5], [0.1, 0.5, -0.2]);
    let mut integrator = loaded(&beam);
    let mut motion = integrator.moving(&q0, &v0, &[FREE; 2], &[]).unwrap();
    integrator.advance(&mut motion, duration, &inputs, &tolerance(1e-9)).unwrap();

    let rate = |t: f64, y: &[f64; 6]| -> [f64; 6] {
        let s = t / duration;
        let (force, excitation) = (80.0 - 140.0 * s, 30.0 * s);
        std::array::from_fn(|i| {
            if i < 3 {
                return y[i + 3];
            }
            let m = i - 3;
            let omega = beam.angular_frequency[m];
            let bend: f64 = (0..3).map(|j| beam.shortening[3 * m + j] * y[j]).sum();
            excitation * beam.excitation_shape[m]
                - force * (beam.contact_shape[m] - bend)
                - 2.0 * beam.damping_ratio[m] * omega * y[i]
                - omega * omega * y[m]
        })
    };
    let mut y: [f64; 6] = std::array::from_fn(|i| if i < 3 { q0[i] } else { v0[i - 3] });
    let steps = 5000;
    let h = duration / steps as f64;
    let along = |y: &[f64; 6], k: &[f64; 6], h: f64| -> [f64; 6] { std::array::from_fn(|i| y[i] + h * k[i]) };
    for step in 0..steps {
        let t = step as f64 * h;
        let k1 = rate(t, &y);
        let k2 = rate(t + 0.5 * h, &along(&y, &k1, 0.5 * h));
        let k3 = rate(t + 0.5 * h, &along(&y, &k2, 0.5 * h));
        let k4 = rate(t + h, &along(&y, &k3, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    for m in 0..3 {
        let (q, v) = (motion.modal_displacement()[m], motion.modal_velocity()[m]);
        assert!((q - y[m]).abs() < 1e-8 * 2e-3, "q{m}: {q} {}", y[m]);
        assert!((v - y[m + 3]).abs() < 1e-8, "v{m}: {v} {}", y[m + 3]);
    }
}

#[test]
fn a_jump_of_the_external_force_passes_to_the_displacement_at_once() {
    let beam = one_mode(330.0, 0.003, 0.06, 1.2, 1.5e-8);
    let mut integrator = loaded(&beam);
    let motion = integrator.moving(&[1e-3], &[0.0], &[FREE; 2], &[]).unwrap();
    let mut out = Outputs::default();
    let mut displacement = |force: f64| {
        integrator.outputs(&motion, f64::INFINITY, &held(0.0, force), &mut out).unwrap();
        (out.contacts[0].displacement, out.sensors[0].acceleration)
    };
    let (before, after) = (displacement(0.0), displacement(100.0));
    assert!((before.0 - 0.06e-3).abs() < 1e-18);
    assert!((after.0 - before.0 + 1.5e-6).abs() < 1e-18);
    // q̈ = −ω² q − c T
    assert!((after.1 + 330.0_f64.powi(2) * 1e-3 + 0.06 * 100.0).abs() < 1e-10);
}

#[test]
fn decayed_amplitudes_are_zero_and_not_denormal() {
    let mut integrator = loaded(&one_mode(330.0, 0.9, 0.06, 1.2, 0.0));
    let mut motion = integrator.moving(&[1e-3], &[0.0], &[FREE; 2], &[]).unwrap();
    let inputs = [FREE; 2];
    for _ in 0..200 {
        integrator.advance(&mut motion, 1e-2, &inputs, &Settings::default()).unwrap();
    }
    assert_eq!(motion.modal_displacement(), [0.0]);
    assert_eq!(motion.modal_velocity(), [0.0]);
}
