//! The rig that slips and slaps, under a dual sine: reference values, energy, and the same motion in time.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use stickslip::harmonic::fourier::{time_derivative, value};
use stickslip::harmonic::{
    Assembly, Control, CurveSettings, HeldTone, Point, dual_tone_response, periodic_response,
};
use stickslip::system::{Core, PinRig, System};
use stickslip::time::{ClassicalSteps, Energies, SteppedMotion};

use crate::common::pin_rig::{model_b, observed};
use stickslip::model::Model;

const FREQUENCY: f64 = 52.0;
/// 1.850 sin ωt + 6.200 sin 3ωt (N).
const FORCE: [f64; 7] = [0.0, 0.0, 1.85, 0.0, 0.0, 0.0, 6.2];

/// The rig of the reference values and its response with 13 harmonics, computed once for all tests.
fn reference() -> &'static (System, Point) {
    static REFERENCE: OnceLock<(System, Point)> = OnceLock::new();
    REFERENCE.get_or_init(|| {
        let system = observed(&model_b());
        let mut assembly = Assembly::new(system.clone());
        assembly.waveform = FORCE.to_vec();
        let at = TAU * FREQUENCY;
        let point = periodic_response(&assembly, at, &Control::Level(1.0), &settings(), None).unwrap();
        (system, point)
    })
}

fn settings() -> CurveSettings {
    CurveSettings { harmonics: 13, max_step: 0.1, ..CurveSettings::default() }
}

/// Amplitude (m/s²) of a harmonic of the acceleration where the force acts.
fn acceleration(point: &Point, order: usize) -> f64 {
    let driven = point.nodes.last().unwrap();
    (order as f64 * point.angular_frequency).powi(2) * driven[2 * order - 1].hypot(driven[2 * order])
}

/// Lowest and highest value over a period.
fn range(coefficients: &[f64]) -> [f64; 2] {
    let values = (0..2048).map(|k| value(coefficients, TAU * f64::from(k) / 2048.0));
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

fn half_range(coefficients: &[f64]) -> f64 {
    let [low, high] = range(coefficients);
    0.5 * (high - low)
}

fn near(what: &str, value: f64, reference: f64, tolerance: f64) {
    assert!((value - reference).abs() <= tolerance, "{what} is {value}, not {reference} ± {tolerance}");
}

/// Energy (J) that the modes' damping takes per cycle.
fn viscous(system: &System, modes: &[Vec<f64>], speed: f64) -> f64 {
    let Core::Modal { angular_frequency, damping_ratio } = &system.core else { panic!("modal") };
    let of = |((omega, zeta), q): ((&f64, &f64), &Vec<f64>)| {
        let squares: f64 =
            (1..=q.len() / 2).map(|h| (h * h) as f64 * (q[2 * h - 1].powi(2) + q[2 * h].powi(2))).sum();
        2.0 * zeta * omega * speed * PI * squares
    };
    angular_frequency.iter().zip(damping_ratio).zip(modes).map(of).sum()
}

/// Coefficients of the modes, which are the sensors after those of the rig.
fn modes<'p>(rig: &PinRig, point: &'p Point) -> &'p [Vec<f64>] {
    let first = rig.beam.point_masses.len();
    &point.nodes[first..first + rig.beam.modes]
}

#[test]
fn dual_sine_gives_the_reference_values_and_its_energy_balances() {
    let rig = model_b();
    let (system, point) = reference();
    let speed = point.angular_frequency;
    near("a1 (m/s²)", acceleration(point, 1), 20.0, 0.2);
    near("a3 (m/s²)", acceleration(point, 3), 50.0, 0.2);
    let [tangential, normal] = [&point.contacts[0], &point.contacts[1]];
    let [low, high] = range(&tangential.force);
    near("lowest S (N)", low, -31.5, 1.0);
    near("highest S (N)", high, 53.0, 1.0);
    near("mean S (N)", tangential.force[0], 11.3, 1.0);
    near("N (N)", half_range(&normal.force), 24.3, 0.5);
    near("ξ (µm)", 1e6 * half_range(&tangential.displacement), 18.9, 0.2);
    near("η (µm)", 1e6 * half_range(&normal.displacement), 1.03, 0.03);
    near("least N_c (N)", rig.preload() - range(&normal.force)[1], 44.0, 1.0);
    // What the force does is dissipated by the modes' damping and, along both directions, by the contact.
    let loops: f64 =
        [tangential, normal].map(|contact| work(&contact.force, &contact.displacement)).iter().sum();
    let taken = viscous(system, modes(&rig, point), speed) + loops;
    near("work over dissipation", point.work / taken, 1.0, 1e-6);
    // The contact's own account, step by step.
    let own = tangential.dissipated_energy + normal.dissipated_energy;
    near("loops over friction and impacts", loops / own, 1.0, 1e-3);
}

fn work(force: &[f64], displacement: &[f64]) -> f64 {
    let velocity = time_derivative(displacement, 1, 1.0);
    force[1..].iter().zip(&velocity[1..]).map(|(f, v)| PI * f * v).sum()
}

/// The motion of `point` at `phase` (rad).
fn motion(rig: &PinRig, point: &Point, phase: f64, steps: &mut ClassicalSteps) -> SteppedMotion {
    let there = |order: usize| -> Vec<f64> {
        let derivative = |q: &Vec<f64>| time_derivative(q, order, point.angular_frequency);
        modes(rig, point).iter().map(|q| value(&derivative(q), phase)).collect()
    };
    steps.moving(&there(0), &there(1))
}

/// Force (N) at the start, the middle and the end of step `k` of so many in a period.
fn force(k: usize, of: usize) -> [f64; 3] {
    [0.0, 0.5, 1.0].map(|part| value(&FORCE, TAU * (k as f64 + part) / of as f64))
}

#[test]
fn the_motion_in_time_is_that_of_the_balance() {
    let rig = model_b();
    let (system, point) = reference();
    let mut steps = ClassicalSteps::new(system).unwrap();
    let (periods, of) = (3, 4000);
    // A slider that sticks all through keeps what the first loading left: to the largest displacement, as in the balance.
    let far = |k: &usize| value(&point.contacts[0].displacement, TAU * *k as f64 / of as f64).abs();
    let first = (0..of).max_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
    let mut motion = motion(&rig, point, TAU * first as f64 / of as f64, &mut steps);
    let step = TAU / point.angular_frequency / of as f64;
    for k in first..first + (periods - 1) * of {
        steps.advance(&mut motion, step, force(k, of));
    }
    motion.energies = Energies::default();
    // Squares of the differences, and of the values of the balance: ξ and S, η and N.
    let mut squares = [[0.0; 2]; 4];
    for k in first..first + of {
        steps.advance(&mut motion, step, force(k, of));
        let phase = TAU * (k + 1) as f64 / of as f64;
        for (direction, balance) in point.contacts.iter().enumerate() {
            let time = &motion.contacts[0];
            let pairs = [
                (value(&balance.displacement, phase), time.displacement[direction]),
                (value(&balance.force, phase), time.force[direction]),
            ];
            for (sums, (balance, time)) in squares[2 * direction..].iter_mut().zip(pairs) {
                *sums = [sums[0] + (time - balance).powi(2), sums[1] + balance.powi(2)];
            }
        }
    }
    for (name, [difference, size]) in ["ξ", "S", "η", "N"].iter().zip(squares) {
        let relative = (difference / size).sqrt();
        assert!(relative < 0.003, "{name} in time differs by {relative}");
    }
    let Energies { work, viscous, friction, impact } = motion.energies;
    near("work over dissipation", work / (viscous + friction + impact), 1.0, 1e-3);
    near("work in time over that of the balance", work / point.work, 1.0, 1e-3);
}

/// Both harmonics of the acceleration where the force acts are held by two sines, as in the paper's tests.
#[test]
fn two_tones_hold_two_harmonics() {
    let (system, reference) = reference();
    let assembly = Assembly::new(system.clone());
    let node = assembly.nodes().len() - 1;
    let held = |amplitudes: [f64; 2]| {
        let tones = [(1, amplitudes[0]), (3, amplitudes[1])];
        let tones = tones.map(|(order, amplitude)| HeldTone { order, amplitude, phase: 0.0 });
        dual_tone_response(&assembly, TAU * FREQUENCY, node, tones, &settings()).unwrap()
    };
    // The amplitudes of a response to known forces are held by those forces.
    let known = held([acceleration(reference, 1), acceleration(reference, 3)]);
    near("force of the first tone (N)", known.force[0], 1.85, 1e-6);
    near("force of the second tone (N)", known.force[1], 6.2, 1e-6);
    let preload = model_b().preload();
    let (mut swing, mut loss) = (0.0, 0.0);
    for amplitudes in [[14.0, 34.0], [17.5, 42.5], [20.0, 50.0]] {
        let point = held(amplitudes).point;
        near("a1 (m/s²)", acceleration(&point, 1), amplitudes[0], 1e-6);
        near("a3 (m/s²)", acceleration(&point, 3), amplitudes[1], 1e-6);
        // Normal force and friction grow with the motion, and the pin stays on its support.
        let [tangential, normal] = [&point.contacts[0], &point.contacts[1]];
        let now = (half_range(&normal.force), work(&tangential.force, &tangential.displacement));
        assert!(now.0 > swing && now.1 > loss, "{amplitudes:?}: {now:?}");
        assert!(range(&normal.force)[1] < preload);
        (swing, loss) = now;
    }
}

/// At the published preload the pin never leaves its support; under less than a third of it, it slaps.
#[test]
fn a_lower_preload_lets_the_pin_slap() {
    let mut rig = model_b();
    rig.string.mass = 1.5;
    let system = observed(&rig);
    let mut steps = ClassicalSteps::new(&system).unwrap();
    let mut motion = steps.rest();
    let of = 4000;
    let step = 1.0 / FREQUENCY / of as f64;
    let (mut apart, mut partings) = (0.0_f64, 0);
    for k in 0..12 * of {
        let before = motion.contacts[0].separation > 0.0;
        steps.advance(&mut motion, step, force(k, of));
        let now = motion.contacts[0];
        assert!(now.normal_force >= 0.0 && (now.separation == 0.0 || now.normal_force == 0.0));
        partings += usize::from(now.separation > 0.0 && !before);
        apart = apart.max(now.separation);
    }
    assert!(partings >= 3, "{partings} partings");
    assert!((1e-8..1e-3).contains(&apart), "{apart} m apart");
    // Impacts take energy.
    assert!(motion.energies.impact > 0.0);
}

#[test]
fn the_model_file_of_the_examples_has_the_reference_values() {
    let model = Model::parse(include_str!("../../examples/slip-slap/model.toml")).unwrap();
    let mut assembly = Assembly::new(model.system().unwrap());
    assembly.waveform = FORCE.to_vec();
    let at = TAU * FREQUENCY;
    let point = periodic_response(&assembly, at, &Control::Level(1.0), &settings(), None).unwrap();
    near("a1 (m/s²)", acceleration(&point, 1), 20.0, 0.2);
    near("a3 (m/s²)", acceleration(&point, 3), 50.0, 0.2);
    let [tangential, normal] = [&point.contacts[0], &point.contacts[1]];
    let [low, high] = range(&tangential.force);
    near("lowest S (N)", low, -31.5, 1.0);
    near("highest S (N)", high, 53.0, 1.0);
    near("N (N)", half_range(&normal.force), 24.3, 0.5);
    near("ξ (µm)", 1e6 * half_range(&tangential.displacement), 18.9, 0.2);
    near("η (µm)", 1e6 * half_range(&normal.displacement), 1.03, 0.03);
}
