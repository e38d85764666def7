//! Lumped oscillators in time: the exact flow by its laws, the integrator and the Runge–Kutta scheme
//! against it.

use std::f64::consts::TAU;
use std::sync::Arc;

use stickslip::contact::{Backlash, ContactLaw, CubicSpring, Jenkins, ParallelSliders, Unilateral, Valanis};
use stickslip::system::LinearStructure;
use stickslip::time::{
    self, Excitation, Integrator, LoadedContact, Motion, OscillatorError, OscillatorFlow, Ramp, RungeKutta,
    ShootingSettings, shoot,
};

use crate::common::oscillator::{chain, single, two_masses};

fn attached(law: &dyn ContactLaw) -> LoadedContact<'_> {
    LoadedContact { law, normal_load: 1.0 }
}

fn waveform() -> Excitation {
    Excitation::Periodic {
        angular_frequency: 0.37,
        level: 1.3,
        coefficients: vec![0.1, 1.0, 0.2, -0.3, 0.5, 0.0, 0.4],
    }
}

#[test]
fn the_work_of_the_excitation_is_what_is_stored_and_taken() {
    let jenkins = Jenkins::new(1.3, 0.2).unwrap();
    let sliders = ParallelSliders::new(&[(0.4, 0.02), (0.4, 0.1), (0.4, 0.1), (0.2, 9.0)]).unwrap();
    let backlash = Backlash::new(3.0, 0.15, 0.08).unwrap();
    let stop = Unilateral::new(25.0, 0.1).unwrap();
    let pairs: [(&dyn ContactLaw, &dyn ContactLaw); 4] =
        [(&jenkins, &sliders), (&sliders, &backlash), (&backlash, &jenkins), (&stop, &jenkins)];
    for (first, second) in pairs {
        let mut flow = OscillatorFlow::new(&chain(5, 0.01), &[attached(first), attached(second)]).unwrap();
        let mut motion = flow.rest();
        let passage = flow.advance(&mut motion, 300.0, &waveform()).unwrap();
        assert!(passage.events > 100, "{}", passage.events);
        assert!(passage.dissipated_energy.iter().all(|energy| *energy >= 0.0));
        let taken = passage.total_dissipated_energy() + passage.viscous_energy + flow.energy(&motion);
        let error = (taken - passage.work) / passage.work;
        assert!(error.abs() < 1e-11, "{first:?} {second:?}: {error:e}");
    }
}

#[test]
fn a_free_linear_vibration_is_the_closed_form() {
    let mut flow = OscillatorFlow::new(&single(2.0, 0.3, 5.0, 0), &[]).unwrap();
    let mut motion = flow.motion(0.0, &[0.4], &[-1.1], &[]).unwrap();
    let (decay, natural) = (0.3 / 4.0, (2.5f64 - 0.075 * 0.075).sqrt());
    for k in 1..=40 {
        flow.advance(&mut motion, 0.731, &Excitation::none()).unwrap();
        let t = 0.731 * f64::from(k);
        let b = (-1.1 + decay * 0.4) / natural;
        let expected = (-decay * t).exp() * (0.4 * (natural * t).cos() + b * (natural * t).sin());
        assert!((flow.displacement(&motion)[0] - expected).abs() < 1e-14, "{t}");
    }
}

#[test]
fn a_motion_is_the_same_in_one_piece_and_in_many() {
    let law = ParallelSliders::new(&[(0.4, 0.02), (0.4, 0.1), (0.2, 0.3)]).unwrap();
    let stop = Unilateral::new(25.0, 0.1).unwrap();
    let mut flow = OscillatorFlow::new(&chain(4, 0.02), &[attached(&law), attached(&stop)]).unwrap();
    let (mut whole, mut pieces) = (flow.rest(), flow.rest());
    flow.advance(&mut whole, 60.0, &waveform()).unwrap();
    for _ in 0..977 {
        flow.advance(&mut pieces, 60.0 / 977.0, &waveform()).unwrap();
    }
    for (a, b) in flow.displacement(&whole).iter().zip(flow.displacement(&pieces)) {
        assert!((a - b).abs() < 1e-11, "{a} {b}");
    }
    assert_eq!(flow.sliders(&whole).len(), 4);
}

/// Den Hartog's motion without stops under Coulomb friction: β = 0.8, f = 0.3 (m = k = 1). A contact of
/// stiffness k takes a time of order k^-1/2 to reverse its force; that order is extrapolated.
#[test]
fn coulomb_friction_gives_the_amplitude_of_den_hartog() {
    let [soft, stiff] = [1e4, 1e6].map(|stiffness| {
        let law = Jenkins::new(stiffness, 0.3).unwrap();
        let mut flow = OscillatorFlow::new(&single(1.0, 0.0, 1.0, 1), &[attached(&law)]).unwrap();
        let found =
            shoot(&mut flow, &Excitation::cosine(0.8, 1.0), None, &ShootingSettings::default()).unwrap();
        assert!((found.passage.total_dissipated_energy() / found.passage.work - 1.0).abs() < 1e-9);
        found.passage.amplitude(0) - 2.626_104_88
    });
    assert!((stiff / soft - 0.1).abs() < 0.01, "{soft} {stiff}");
    assert!(((10.0 * stiff - soft) / 9.0).abs() < 2e-5, "{soft} {stiff}");
}

/// A stuck oscillator whose force exceeds the limit by a part in 10⁹: both events lie within one step.
#[test]
fn a_short_slip_between_two_steps_is_found() {
    let (stiffness, damping, omega) = (1.7, 0.2, 0.6);
    let dynamic = 2.7 - omega * omega;
    let size = 1.0 / f64::hypot(dynamic, damping * omega);
    for (fraction, slips) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
        let law = Jenkins::new(stiffness, stiffness * size * fraction).unwrap();
        let mut flow = OscillatorFlow::new(&single(1.0, damping, 1.0, 1), &[attached(&law)]).unwrap();
        let scale = size * size;
        let (q, v) = (dynamic * scale, damping * omega * omega * scale);
        let mut motion = flow.motion(0.0, &[q], &[v], &[0.0]).unwrap();
        let passage = flow.advance(&mut motion, TAU / omega, &Excitation::cosine(omega, 1.0)).unwrap();
        assert_eq!(passage.slipped[0], slips, "{fraction}: {passage:?}");
    }
}

#[test]
fn an_infinite_end_is_an_error_and_changes_nothing() {
    let law = Jenkins::new(1.0, 0.1).unwrap();
    let mut flow = OscillatorFlow::new(&single(1.0, 0.1, 1.0, 1), &[attached(&law)]).unwrap();
    flow.set_step_limit(5);
    let mut motion = flow.rest();
    let refused = flow.advance(&mut motion, 100.0, &Excitation::cosine(1.0, 1.0));
    assert!(matches!(refused, Err(OscillatorError::TooManySteps { limit: 5, .. })), "{refused:?}");
    assert_eq!(motion, flow.rest());
    let valanis = Valanis::new(1.0, 0.1, 0.3, 0.0).unwrap();
    let refused = OscillatorFlow::new(&single(1.0, 0.1, 1.0, 1), &[attached(&valanis)]);
    assert!(matches!(refused, Err(OscillatorError::NotPiecewiseLinear { contact: 0 })));
    let massless = single(0.0, 0.1, 1.0, 1);
    assert!(matches!(
        OscillatorFlow::new(&massless, &[attached(&law)]),
        Err(OscillatorError::MassNotPositive)
    ));
    assert!(flow.advance(&mut motion, f64::NAN, &Excitation::none()).is_err());
    assert!(flow.advance(&mut motion, 1.0, &Excitation::cosine(1.0, f64::INFINITY)).is_err());
}

#[test]
fn runge_kutta_approaches_the_exact_flow() {
    let law = Backlash::new(0.8, 0.05, 0.06).unwrap();
    let excitation = Excitation::cosine(0.9, 0.4);
    let mut flow = OscillatorFlow::new(&two_masses(0.1), &[attached(&law)]).unwrap();
    let mut motion = flow.rest();
    // The area of a loop is the energy taken only once the loop closes.
    flow.advance(&mut motion, 59.0 * TAU / 0.9, &excitation).unwrap();
    let exact = flow.advance(&mut motion, TAU / 0.9, &excitation).unwrap();
    let scheme = RungeKutta::new(&two_masses(0.1), &[attached(&law)]).unwrap();
    let errors = [100, 1000].map(|steps| {
        let last = scheme.from_rest(&excitation, 60, steps).unwrap().pop().unwrap();
        (last.dissipated_energy[0] / exact.total_dissipated_energy() - 1.0).abs()
            + (last.amplitude[1] / exact.amplitude(1) - 1.0).abs()
    });
    assert!(errors[1] < 1e-4 && errors[1] < 0.1 * errors[0], "{errors:?}");
}

/// An integrator of `structure` whose contacts have these laws under a unit load.
fn integrator(structure: &LinearStructure, laws: Vec<Arc<dyn ContactLaw>>) -> Integrator {
    let system = structure.system(laws.into_iter().map(|law| (law, 1.0)).collect());
    Integrator::new(&system).unwrap()
}

/// Moves from rest under forces that run linearly between `values`, `interval` (s) apart; also the number of steps.
fn run(integrator: &mut Integrator, interval: f64, values: &[f64], tolerance: f64) -> (Motion, usize) {
    let mut inputs = integrator.held_inputs();
    let mut motion = integrator.rest(&inputs).unwrap();
    let settings = time::Settings { tolerance, ..Default::default() };
    let mut steps = 0;
    for pair in values.windows(2) {
        inputs[0] = Ramp::line(pair[0], pair[1]);
        steps += integrator.advance(&mut motion, interval, &inputs, &settings).unwrap();
    }
    (motion, steps)
}

#[test]
fn the_integrator_follows_the_exact_flow_of_jenkins() {
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let interval = 2.0;
    let values: Vec<f64> = (0..=20).map(|k| 0.4 * (0.5 * interval * f64::from(k)).cos()).collect();
    let mut flow = OscillatorFlow::new(&two_masses(0.1), &[attached(&law)]).unwrap();
    let mut exact = flow.rest();
    let excitation = Excitation::Sampled { interval, values: values.clone() };
    let passage = flow.advance(&mut exact, 40.0, &excitation).unwrap();
    let mut errors = vec![];
    for tolerance in [1e-5, 1e-8] {
        let mut integrator = integrator(&two_masses(0.1), vec![Arc::new(law)]);
        let (motion, steps) = run(&mut integrator, interval, &values, tolerance);
        let (found, expected) = (integrator.displacement(&motion), flow.displacement(&exact));
        let error = (found[0] - expected[0]).abs().max((found[1] - expected[1]).abs());
        let energy = motion.contact(0).dissipated_energy / passage.total_dissipated_energy() - 1.0;
        println!("tolerance {tolerance:e}: {steps} steps, error {error:e}, energy {energy:e}");
        assert!(error < 20.0 * tolerance && energy.abs() < 20.0 * tolerance, "{error:e} {energy:e}");
        errors.push(error);
    }
    assert!(errors[1] < 0.02 * errors[0]);
}

/// Springs with dampers of their own, which no modes diagonalise, and contacts at both ends.
#[test]
fn two_contacts_on_a_chain_of_unlike_dampers_follow_the_exact_flow() {
    let mut structure = chain(5, 0.01);
    structure.damping.push((2, 2, 0.3));
    let laws = (Jenkins::new(1.3, 0.2).unwrap(), ParallelSliders::new(&[(0.4, 0.02), (0.4, 0.1)]).unwrap());
    let interval = 0.5;
    let values: Vec<f64> = (0..=120).map(|k| 0.9 * (0.37 * interval * f64::from(k)).sin()).collect();
    let mut flow = OscillatorFlow::new(&structure, &[attached(&laws.0), attached(&laws.1)]).unwrap();
    let mut exact = flow.rest();
    let excitation = Excitation::Sampled { interval, values: values.clone() };
    let passage = flow.advance(&mut exact, 60.0, &excitation).unwrap();
    assert!(passage.events > 20, "{}", passage.events);
    let mut integrator = integrator(&structure, vec![Arc::new(laws.0), Arc::new(laws.1.clone())]);
    let (motion, steps) = run(&mut integrator, interval, &values, 1e-8);
    let (found, expected) = (integrator.displacement(&motion), flow.displacement(&exact));
    let size = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let error = found.iter().zip(&expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    println!("{steps} steps, error {error:e} of {size}");
    assert!(error < 2e-7 * size, "{error:e}");
    for (place, energy) in passage.dissipated_energy.iter().enumerate() {
        assert!((motion.contact(place).dissipated_energy / energy - 1.0).abs() < 2e-7);
    }
}

#[test]
fn the_integrator_converges_with_order_four_at_least() {
    let run = |tolerance: f64| {
        let law = CubicSpring::new(0.3, 2.0).unwrap();
        let mut integrator = integrator(&single(1.0, 0.05, 1.0, 1), vec![Arc::new(law)]);
        let inputs = [Ramp::held(0.6), Ramp::held(1.0)];
        let mut motion = integrator.moving(&[0.8], &[0.3], &inputs, &[]).unwrap();
        let settings = time::Settings { tolerance, ..Default::default() };
        let steps = integrator.advance(&mut motion, 12.0, &inputs, &settings).unwrap();
        (steps as f64, integrator.displacement(&motion)[0])
    };
    let exact = run(1e-13).1;
    let (coarse, fine) = (run(1e-5), run(1e-10));
    let order = ((coarse.1 - exact) / (fine.1 - exact)).abs().ln() / (fine.0 / coarse.0).ln();
    println!("{coarse:?} {fine:?} {exact} order {order}");
    assert!((4.0..7.5).contains(&order), "order {order}");
    assert!((fine.1 - exact).abs() < 1e-9);
}
