//! The beam with a frictional support, in the time domain and in the frequency domain: both solvers
//! against each other, and against a Runge–Kutta solution of the published equations by another program.

use std::f64::consts::TAU;

use stickslip::harmonic::fourier::{from_samples, value};
use stickslip::harmonic::{CurveSettings, Method};
use stickslip::model::{Beam, Damping, Model, Structure};
use stickslip::system::ModalBeam;
use stickslip::time::{self, Integrator, Motion, Ramp};

use crate::common::beam::forced_response;
use crate::common::contact::{self, LOAD, loaded};
use crate::common::time::{at_end, rest, supported};

/// Force (N) and frequency (Hz) of the excitation, near the resonance of the slipping beam.
const FORCE: f64 = 8.0;
const FREQUENCY: f64 = 52.0;

fn published(modes: usize, damping_ratio: f64) -> ModalBeam {
    let model = Model::parse(include_str!("../../examples/frictional-support/published.toml")).unwrap();
    let Structure::Beam(beam) = model.structure else { panic!("the example is a beam") };
    ModalBeam::new(&Beam { modes, damping: Damping::Uniform(damping_ratio), ..beam }).unwrap()
}

/// Drives `motion` from phase 0 over `periods` of a cosine, `steps` straight pieces a period; `visit` sees
/// the motion at the end of each.
fn drive(
    integrator: &mut Integrator,
    motion: &mut Motion,
    periods: usize,
    steps: usize,
    mut visit: impl FnMut(usize, &Motion),
) {
    let settings = time::Settings { tolerance: 1e-8, ..Default::default() };
    let force = |k: usize| FORCE * (TAU * (k % steps) as f64 / steps as f64).cos();
    for k in 0..periods * steps {
        let inputs = [Ramp::line(force(k), force(k + 1)), Ramp::held(LOAD)];
        integrator.advance(motion, 1.0 / (FREQUENCY * steps as f64), &inputs, &settings).unwrap();
        visit(k + 1, motion);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Three periods from rest. Reference: modes from 60 finite elements, the rate law
/// `Ṫ = D/(1 + D L/EA) · d(c·q − ½ qᵀGq)/dt`, classical Runge–Kutta at 4000 steps a period (at 2000 it
/// differs by 4e-8).
#[test]
fn the_transient_from_rest_is_that_of_the_published_equations() {
    let beam = published(4, 0.02);
    let mut integrator = supported(&beam, contact::published(), LOAD);
    let mut motion = rest(&mut integrator);
    drive(&mut integrator, &mut motion, 3, 2048, |_, _| {});
    let displacement = [-4.84833661e-5, -2.19250161e-6, -6.04993074e-7, -2.54945865e-7];
    let velocity = [-7.10355139e-2, 2.14457144e-3, 5.15418952e-4, 2.35241827e-4];
    for ((found, expected), tolerance) in
        motion.modal_displacement().iter().zip(displacement).zip([1e-5, 1e-4, 1e-4, 1e-3])
    {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
    }
    for ((found, expected), tolerance) in
        motion.modal_velocity().iter().zip(velocity).zip([1e-5, 1e-3, 5e-3, 2e-2])
    {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
    }
    let force = at_end(&motion).force;
    assert!((force / -37.0333993 - 1.0).abs() < 1e-4, "{force}");
}

#[test]
fn harmonic_balance_finds_the_steady_state_of_a_long_run_in_time() {
    let beam = published(4, 0.02);
    let law = contact::published();
    let contact = loaded(law, LOAD);
    let settings =
        CurveSettings { harmonics: 15, method: Method::Sampled { samples: 512 }, ..CurveSettings::default() };
    let system = beam.system(contact.clone()).unwrap();
    let balance = forced_response(system, 1.0 / FREQUENCY, &[0.0, FORCE], &settings).unwrap();

    let mut integrator = supported(&beam, law, LOAD);
    let mut motion = rest(&mut integrator);
    drive(&mut integrator, &mut motion, 60, 512, |_, _| {});
    let lost_before = at_end(&motion).dissipated_energy;
    let (mut exciter, mut forces) = (vec![0.0; 512], vec![0.0; 512]);
    drive(&mut integrator, &mut motion, 1, 512, |k, motion| {
        exciter[k % 512] = dot(&beam.excitation_shape, motion.modal_displacement());
        forces[k % 512] = at_end(motion).force;
    });
    let found = &balance.nodes[beam.sensors.len()];
    let largest = exciter.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for (k, in_time) in exciter.iter().enumerate() {
        let error = (value(found, TAU * k as f64 / 512.0) - in_time).abs() / largest;
        assert!(error < 2e-4, "displacement at sample {k}: {error}");
    }
    let in_time = from_samples(&forces, 1, 7);
    let force = &balance.contacts[0].force;
    for (balance, in_time) in force.iter().zip(&in_time) {
        assert!((balance - in_time).abs() < 0.05, "force coefficient {balance} N, in time {in_time} N");
    }
    let lost = at_end(&motion).dissipated_energy - lost_before;
    assert!(
        (balance.dissipated_energy() / lost - 1.0).abs() < 1e-3,
        "{} {lost}",
        balance.dissipated_energy()
    );
    // The other program, sixty periods of Runge–Kutta: first harmonics of displacement and force, and the
    // bias that the shortening of the beam gives the force.
    for (found, reference, tolerance) in [
        (found[1], 1.84770618e-5, 1e-8),
        (found[2], 1.46019779e-4, 1e-8),
        (force[0], 2.32181526, 0.02),
        (force[1], -50.4017551, 0.02),
        (force[2], -72.5483637, 0.02),
        (force[5], -1.86649022, 0.02),
        (force[6], 3.53133819, 0.02),
    ] {
        assert!((found - reference).abs() < tolerance, "{found} {reference}");
    }
}
