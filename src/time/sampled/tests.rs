//! Items to verify: exact linear propagation at any step; order with smooth forces and with corners; agreement with the
//! exact flow; energy balance; drag's decay; Duffing's frequency.

use std::sync::Arc;

use super::{Drive, SampledIntegrator};
use crate::contact::{ContactLaw, CubicSpring, Drag, Jenkins};
use crate::system::LinearStructure;
use crate::time::{Excitation, LoadedContact, OscillatorFlow};

fn two_masses() -> LinearStructure {
    LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.0)],
        damping: vec![(0, 0, 0.1), (1, 1, 0.1)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(1, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: Vec::new(),
    }
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

/// Displacements of both masses at every sample, `substeps` steps between two.
fn run(
    structure: &LinearStructure,
    law: Arc<dyn ContactLaw>,
    force: &[f64],
    step: f64,
    substeps: usize,
) -> Vec<f64> {
    let h = step / substeps as f64;
    let mut integrator =
        SampledIntegrator::new(structure, vec![law], std::slice::from_ref(&structure.excitation), h).unwrap();
    let mut state = vec![0.0; integrator.state_len()];
    integrator.rest(&[1.0], &mut state);
    let mut all = integrator.displacement(&state).to_vec();
    for pair in force.windows(2) {
        for k in 0..substeps {
            let at = |k: usize| pair[0] + (pair[1] - pair[0]) * k as f64 / substeps as f64;
            assert!(integrator.step(&mut state, &[Drive::line(at(k), at(k + 1))], &[1.0]));
        }
        all.extend(integrator.displacement(&state));
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

fn single(stiffness: f64, damping: f64, contacts: usize) -> LinearStructure {
    LinearStructure {
        size: 1,
        mass: vec![(0, 0, 1.0)],
        damping: vec![(0, 0, damping)],
        stiffness: vec![(0, 0, stiffness)],
        contacts: vec![vec![(0, 1.0)]; contacts],
        excitation: vec![(0, 1.0)],
        outputs: Vec::new(),
    }
}

fn boxed(law: impl ContactLaw + 'static) -> Arc<dyn ContactLaw> {
    Arc::new(law)
}

/// One mass with `laws`, from `displacement` and `velocity`, without a drive, over `steps` steps.
fn free_motion(
    structure: &LinearStructure,
    laws: Vec<Arc<dyn ContactLaw>>,
    start: (f64, f64),
    duration: f64,
    steps: usize,
) -> (f64, f64) {
    let count = laws.len();
    let mut integrator = SampledIntegrator::new(structure, laws, &[], duration / steps as f64).unwrap();
    let mut state = vec![0.0; integrator.state_len()];
    let (forces, loads) = (vec![0.0; count], vec![1.0; count]);
    integrator.begin(&[start.0], &[start.1], &forces, &loads, &mut state);
    integrator.settle(&mut state, &loads);
    for _ in 0..steps {
        assert!(integrator.step(&mut state, &[], &loads));
    }
    (integrator.displacement(&state)[0], integrator.velocity(&state)[0])
}

#[test]
fn a_parabola_of_force_on_a_damped_mass_is_followed_exactly_at_any_step() {
    let (omega, zeta) = (3.0_f64, 0.07);
    let structure = single(omega * omega, 2.0 * zeta * omega, 0);
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
    for h in [0.01, 0.5, 4.0] {
        let mut integrator = SampledIntegrator::new(&structure, Vec::new(), &[vec![(0, 1.0)]], h).unwrap();
        let mut state = vec![0.0; integrator.state_len()];
        integrator.rest(&[], &mut state);
        for k in 0..5 {
            let t = f64::from(k) * h;
            let drive = Drive { start: force(t), end: force(t + h), bow: -omega * omega * c * h * h };
            assert!(integrator.step(&mut state, &[drive], &[]));
            let (found, exact) = (integrator.displacement(&state)[0], exact(t + h));
            assert!((found - exact).abs() < 1e-11 * exact.abs().max(1.0), "h = {h}: {found} {exact}");
        }
    }
}

#[test]
fn errors_against_the_exact_flow_fall_with_the_square_of_the_step_where_forces_have_corners() {
    let structure = two_masses();
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let step = 0.4;
    let force = multisine(1500, step);
    let reference = exact(&structure, &law, &force, step);
    let errors = [2, 8, 32].map(|n| relative(&run(&structure, Arc::new(law), &force, step, n), &reference));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log(4.0);
        assert!((1.6..2.6).contains(&order), "{errors:?}");
    }
    // The length recommended: well below a thousandth.
    let longest = SampledIntegrator::longest_step(&structure, &[0.2]).unwrap();
    let substeps = (step / longest).ceil() as usize;
    let error = relative(&run(&structure, Arc::new(law), &force, step, substeps), &reference);
    assert!(error < 4e-4, "{substeps} steps: {error:e}");
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
        let law = boxed(CubicSpring::new(0.0, epsilon).unwrap());
        let (x, v) = free_motion(&single(1.0, 0.0, 1), vec![law], (amplitude, 0.0), period, steps);
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
        let law = boxed(Drag::new(q).unwrap());
        let (x, v) = free_motion(&single(0.0, 0.0, 1), vec![law], (0.0, v0), t, steps);
        (v - v0 / slowed).abs() + (x + slowed.ln() / q).abs()
    });
    assert!(errors[1] < 5e-5 && errors[1] < errors[0] / 14.0, "{errors:?}");
}

#[test]
fn two_laws_on_one_mass_act_as_their_sum() {
    let whole = vec![boxed(CubicSpring::new(0.5, 0.8).unwrap())];
    let parts = vec![boxed(CubicSpring::new(0.5, 0.2).unwrap()), boxed(CubicSpring::new(0.0, 0.6).unwrap())];
    let one = free_motion(&single(1.0, 0.1, 1), whole, (1.0, 0.0), 10.0, 100);
    let two = free_motion(&single(1.0, 0.1, 2), parts, (1.0, 0.0), 10.0, 100);
    assert!((one.0 - two.0).abs() + (one.1 - two.1).abs() < 1e-10, "{one:?} {two:?}");
}

#[test]
fn the_work_of_the_drive_is_stored_or_dissipated() {
    let (stiffness, friction, load) = (3.0, 0.5, 1.0);
    let structure = single(1.0, 0.0, 1);
    let law = boxed(Jenkins::new(stiffness, friction).unwrap());
    let h = 0.002;
    let mut integrator = SampledIntegrator::new(&structure, vec![law], &[vec![(0, 1.0)]], h).unwrap();
    let mut state = vec![0.0; integrator.state_len()];
    integrator.rest(&[load], &mut state);
    let drive = 2.0;
    let mut dissipated = 0.0;
    for _ in 0..10_000 {
        assert!(integrator.step(&mut state, &[Drive::line(drive, drive)], &[load]));
        dissipated += integrator.responses()[0].dissipated_energy;
        let (x, v) = (integrator.displacement(&state)[0], integrator.velocity(&state)[0]);
        let stretch = integrator.contact_forces(&state)[0];
        let stored = 0.5 * (x * x + v * v + stretch * stretch / stiffness);
        assert!((drive * x - stored - dissipated).abs() < 2e-5, "{} {}", drive * x, stored + dissipated);
    }
    assert!(dissipated > 1.0, "{dissipated}");
}

#[test]
fn a_copied_state_continues_bit_by_bit_and_a_lifted_contact_lets_go() {
    let structure = two_masses();
    let law = boxed(Jenkins::new(0.2, 0.02).unwrap());
    let mut integrator =
        SampledIntegrator::new(&structure, vec![law], std::slice::from_ref(&structure.excitation), 0.1)
            .unwrap();
    let mut state = vec![0.0; integrator.state_len()];
    integrator.rest(&[1.0], &mut state);
    let step = |integrator: &mut SampledIntegrator, state: &mut [f64], k: u32| {
        let force = f64::from(k) * 0.01;
        assert!(integrator.step(state, &[Drive::line(force, force + 0.01)], &[3.0 - 0.05 * f64::from(k)]));
    };
    (0..40).for_each(|k| step(&mut integrator, &mut state, k));
    assert!(integrator.contact_forces(&state)[0] != 0.0);
    let mut copy = state.clone();
    (40..80).for_each(|k| step(&mut integrator, &mut state, k));
    (40..80).for_each(|k| step(&mut integrator, &mut copy, k));
    assert_eq!(state, copy);
    assert_eq!(integrator.contact_forces(&state)[0], 0.0);
}

#[test]
fn what_cannot_be_integrated_is_refused() {
    let structure = single(1.0, 0.0, 1);
    assert!(SampledIntegrator::new(&structure, Vec::new(), &[], 0.1).is_err());
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e200] {
        assert!(SampledIntegrator::new(&single(1.0, 0.0, 0), Vec::new(), &[], step).is_err(), "{step}");
    }
    let massless = LinearStructure { mass: Vec::new(), ..single(1.0, 0.0, 0) };
    assert!(SampledIntegrator::new(&massless, Vec::new(), &[], 0.1).is_err());
    assert!(SampledIntegrator::new(&single(1.0, 0.0, 0), Vec::new(), &[vec![(1, 1.0)]], 0.1).is_err());
    // A motion that grows without bound is told, not followed.
    let pushing = vec![boxed(CubicSpring::new(0.0, -1.0).unwrap())];
    let mut integrator = SampledIntegrator::new(&structure, pushing, &[], 0.1).unwrap();
    let mut state = vec![0.0; integrator.state_len()];
    integrator.begin(&[3.0], &[1.0], &[0.0], &[1.0], &mut state);
    assert!((0..10_000).any(|_| !integrator.step(&mut state, &[], &[1.0])));
}
