//! Equal steps: exact under parabolas of force at any step; order with smooth forces and with corners; agreement with the
//! exact flow; energy balance; drag's decay; Duffing's frequency.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, CubicSpring, Drag, Jenkins};
use stickslip::system::LinearStructure;
use stickslip::time::{Excitation, Integrator, LoadedContact, Motion, OscillatorFlow, Ramp};

use crate::common::oscillator::{single, two_masses};

/// `structure` with `laws` under 1 N.
fn integrator(structure: &LinearStructure, laws: &[Arc<dyn ContactLaw>]) -> Integrator {
    Integrator::new(&structure.system(laws.iter().map(|law| (law.clone(), 1.0)).collect())).unwrap()
}

fn shared(law: impl ContactLaw + 'static) -> Arc<dyn ContactLaw> {
    Arc::new(law)
}

/// A force with several lines, at the instants of a grid.
fn multisine(samples: usize, step: f64) -> Vec<f64> {
    (0..samples)
        .map(|i| {
            let t = i as f64 * step;
            0.25 * (0.5 * t).sin() + 0.2 * (1.1 * t + 0.5).sin() - 0.2 * 0.5_f64.sin() + 0.1 * (1.5 * t).sin()
        })
        .collect()
}

/// Displacements of all masses at every sample, `steps` steps between two.
fn run(structure: &LinearStructure, law: &Jenkins, force: &[f64], step: f64, steps: usize) -> Vec<f64> {
    let mut integrator = integrator(structure, &[shared(*law)]);
    let mut inputs = integrator.held_inputs();
    let mut motion = integrator.rest(&inputs).unwrap();
    let mut all = integrator.displacement(&motion);
    for pair in force.windows(2) {
        inputs[0] = Ramp::line(pair[0], pair[1]);
        integrator.march(&mut motion, step, &inputs, steps).unwrap();
        all.extend(integrator.displacement(&motion));
    }
    all
}

fn exact(structure: &LinearStructure, law: &dyn ContactLaw, force: &[f64], step: f64) -> Vec<f64> {
    let contacts = [LoadedContact { law, normal_load: 1.0 }];
    let mut flow = OscillatorFlow::new(structure, &contacts).unwrap();
    let excitation = Excitation::Sampled { interval: step, values: force.to_vec() };
    let mut motion = flow.rest();
    let mut all = flow.displacement(&motion);
    for _ in 1..force.len() {
        flow.advance(&mut motion, step, &excitation).unwrap();
        all.extend(flow.displacement(&motion));
    }
    all
}

/// Root-mean-square difference over the root mean square.
fn relative(found: &[f64], exact: &[f64]) -> f64 {
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    (squares(&mut found.iter().zip(exact).map(|(a, b)| a - b)) / squares(&mut exact.iter().copied())).sqrt()
}

/// One mass with `laws`, from `start`, without a drive, over `steps` steps: displacement and velocity.
fn free_motion(
    structure: &LinearStructure,
    laws: &[Arc<dyn ContactLaw>],
    start: (f64, f64),
    duration: f64,
    steps: usize,
) -> (f64, f64) {
    let mut integrator = integrator(structure, laws);
    let inputs = integrator.held_inputs();
    let forces = vec![0.0; laws.len()];
    let mut motion = integrator.moving(&[start.0], &[start.1], &inputs, &forces).unwrap();
    integrator.march(&mut motion, duration, &inputs, steps).unwrap();
    (integrator.displacement(&motion)[0], integrator.velocity(&motion)[0])
}

#[test]
fn a_parabola_of_force_on_a_damped_mass_is_followed_exactly_at_any_step() {
    let (omega, zeta) = (3.0_f64, 0.07);
    let structure = single(1.0, 2.0 * zeta * omega, omega * omega, 0);
    // x = a + b t + c t² solves x'' + 2ζω x' + ω² x = f for the parabola f below; a free decay is added to start from rest.
    let (a, b, c) = (0.3, -0.8, 0.5);
    let force =
        |t: f64| 2.0 * c + 2.0 * zeta * omega * (b + 2.0 * c * t) + omega * omega * (a + b * t + c * t * t);
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let exact = |t: f64| {
        let (x0, v0) = (-a, -b);
        let sine = (v0 + zeta * omega * x0) / damped;
        a + b * t
            + c * t * t
            + (-zeta * omega * t).exp() * (x0 * (damped * t).cos() + sine * (damped * t).sin())
    };
    for (h, steps) in [(0.01, 1), (0.5, 1), (4.0, 1), (4.0, 3)] {
        let mut integrator = integrator(&structure, &[]);
        let mut motion = integrator.rest(&[Ramp::held(0.0)]).unwrap();
        for k in 0..5 {
            let t = f64::from(k) * h;
            let ramp =
                Ramp { start: force(t), end: force(t + h), bow: -omega * omega * c * h * h, skew: 0.0 };
            integrator.march(&mut motion, h, &[ramp], steps).unwrap();
            let (found, exact) = (integrator.displacement(&motion)[0], exact(t + h));
            assert!((found - exact).abs() < 1e-11 * exact.abs().max(1.0), "h = {h}: {found} {exact}");
        }
    }
}

#[test]
fn errors_against_the_exact_flow_fall_with_the_square_of_the_step_where_forces_have_corners() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let step = 0.4;
    let force = multisine(1500, step);
    let reference = exact(&structure, &law, &force, step);
    let errors = [2, 8, 32].map(|n| relative(&run(&structure, &law, &force, step, n), &reference));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log(4.0);
        assert!((1.6..2.6).contains(&order), "{errors:?}");
    }
    // The length recommended: well below a thousandth.
    let longest = integrator(&structure, &[shared(law)]).longest_step(&[0.2], f64::INFINITY);
    let steps = (step / longest).ceil() as usize;
    let error = relative(&run(&structure, &law, &force, step, steps), &reference);
    assert!(error < 4e-4, "{steps} steps: {error:e}");
}

#[test]
fn a_mode_above_what_moves_counts_as_one_as_far_below() {
    const FREQUENCY: f64 = 8.0;
    let one = integrator(&single(1.0, 0.0, FREQUENCY * FREQUENCY, 0), &[]);
    let all = one.longest_step(&[], f64::INFINITY);
    for (fastest, counted) in [(8.0, 8.0), (9.0, 8.0), (4.0, 2.0), (1.0, 0.125)] {
        let found = one.longest_step(&[], fastest);
        assert!((found * counted / (all * FREQUENCY) - 1.0).abs() < 1e-12, "{fastest}: {found}");
    }
    // The slower one of two masses is left as it is, the faster the less the higher.
    let two = integrator(&two_masses(0.0), &[]);
    let longest = |fastest: f64| two.longest_step(&[], fastest);
    let slower = longest(1e-6);
    let steps: Vec<f64> = (0..60).map(|k| longest(3.0 * 0.9_f64.powi(k))).collect();
    assert!(slower > 100.0 * longest(f64::INFINITY) && steps[0] == longest(f64::INFINITY));
    // No jump where a mode comes to lie above.
    assert!(steps.windows(2).all(|pair| (pair[1] / pair[0]).ln().abs() < 0.22), "{steps:?}");
}

#[test]
fn errors_fall_with_the_fourth_power_of_the_step_where_forces_are_smooth() {
    // Duffing's period by Gauss's mean: T = 2π/(√(1 + ε A²) · agm(1, √(1 − m))), m = ε A²/(2 + 2 ε A²).
    let (epsilon, amplitude) = (0.7_f64, 1.3_f64);
    let hardening = epsilon * amplitude * amplitude;
    let modulus = hardening / (2.0 + 2.0 * hardening);
    let (mut a, mut g) = (1.0, (1.0 - modulus).sqrt());
    for _ in 0..6 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    let period = std::f64::consts::TAU / ((1.0 + hardening).sqrt() * a);
    let errors = [50, 100, 200].map(|steps| {
        let law = shared(CubicSpring::new(0.0, epsilon).unwrap());
        let (x, v) = free_motion(&single(1.0, 0.0, 1.0, 1), &[law], (amplitude, 0.0), period, steps);
        (x - amplitude).abs() + v.abs()
    });
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((3.5..4.5).contains(&order), "{errors:?}");
    }
    assert!(errors[2] < 1e-6, "{errors:?}");
}

#[test]
fn drag_alone_slows_a_mass_as_its_closed_form_says() {
    let (q, v0, t) = (0.8_f64, -2.0_f64, 3.0);
    let slowed = 1.0 + q * v0.abs() * t;
    let errors = [100, 400].map(|steps| {
        let law = shared(Drag::new(q).unwrap());
        let (x, v) = free_motion(&single(1.0, 0.0, 0.0, 1), &[law], (0.0, v0), t, steps);
        (v - v0 / slowed).abs() + (x + slowed.ln() / q).abs()
    });
    assert!(errors[1] < 5e-5 && errors[1] < errors[0] / 14.0, "{errors:?}");
}

#[test]
fn two_laws_on_one_mass_act_as_their_sum() {
    let whole = [shared(CubicSpring::new(0.5, 0.8).unwrap())];
    let parts = [shared(CubicSpring::new(0.5, 0.2).unwrap()), shared(CubicSpring::new(0.0, 0.6).unwrap())];
    let one = free_motion(&single(1.0, 0.1, 1.0, 1), &whole, (1.0, 0.0), 10.0, 100);
    let two = free_motion(&single(1.0, 0.1, 1.0, 2), &parts, (1.0, 0.0), 10.0, 100);
    assert!((one.0 - two.0).abs() + (one.1 - two.1).abs() < 1e-10, "{one:?} {two:?}");
}

#[test]
fn the_work_of_the_drive_is_stored_or_dissipated() {
    let (stiffness, friction) = (3.0, 0.5);
    let mut integrator =
        integrator(&single(1.0, 0.0, 1.0, 1), &[shared(Jenkins::new(stiffness, friction).unwrap())]);
    let mut inputs = integrator.held_inputs();
    let drive = 2.0;
    inputs[0] = Ramp::held(drive);
    let mut motion = integrator.rest(&inputs).unwrap();
    for _ in 0..10_000 {
        integrator.march(&mut motion, 0.002, &inputs, 1).unwrap();
        let (x, v) = (integrator.displacement(&motion)[0], integrator.velocity(&motion)[0]);
        let contact = motion.contact(0);
        let stored = 0.5 * (x * x + v * v + contact.force * contact.force / stiffness);
        let taken = stored + contact.dissipated_energy;
        assert!((drive * x - taken).abs() < 2e-5, "{} {taken}", drive * x);
    }
    assert!(motion.contact(0).dissipated_energy > 1.0);
}

#[test]
fn a_copied_state_continues_bit_by_bit_and_a_lifted_contact_lets_go() {
    let mut integrator = integrator(&two_masses(0.1), &[shared(Jenkins::new(0.2, 0.02).unwrap())]);
    let mut motion = integrator.rest(&integrator.held_inputs()).unwrap();
    let load = |k: u32| 3.0 - 0.05 * f64::from(k);
    let mut step = |motion: &mut Motion, k: u32| {
        let force = f64::from(k) * 0.01;
        let inputs = [Ramp::line(force, force + 0.01), Ramp::line(load(k), load(k + 1))];
        integrator.march(motion, 0.1, &inputs, 1).unwrap();
    };
    (0..40).for_each(|k| step(&mut motion, k));
    assert!(motion.contact(0).force != 0.0);
    let mut copy = motion.clone();
    (40..80).for_each(|k| step(&mut motion, k));
    (40..80).for_each(|k| step(&mut copy, k));
    assert_eq!(motion, copy);
    assert_eq!(motion.contact(0).force, 0.0);
}

#[test]
fn a_motion_that_grows_without_bound_is_told_and_not_followed() {
    let pushing = [shared(CubicSpring::new(0.0, -1.0).unwrap())];
    let mut integrator = integrator(&single(1.0, 0.0, 1.0, 1), &pushing);
    let inputs = integrator.held_inputs();
    let mut motion = integrator.moving(&[3.0], &[1.0], &inputs, &[0.0]).unwrap();
    assert!((0..10_000).any(|_| integrator.march(&mut motion, 0.1, &inputs, 1).is_err()));
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(integrator.march(&mut motion, step, &inputs, 1).is_err(), "{step}");
    }
}
