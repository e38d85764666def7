//! Floquet multipliers of the beam's periodic responses against closed forms, the oscillator of the same modes and the
//! time integrator.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{Complex, DMatrix};
use stickslip::contact::{
    ContactLaw, CubicSpring, Inputs, Jenkins, Joint, JointChanges, ParallelSliders, Response, SlipState,
    StateTangents, Tangents,
};
use stickslip::harmonic::Resonance;
use stickslip::harmonic::stability::{Multipliers, floquet, floquet_in_modes};
use stickslip::harmonic::{
    Assembly, Control, CurveSettings, Ending, LoadedContact, frequency_response, phase_resonance,
};
use stickslip::system::{ModalBeam, System};
use stickslip::time::{Ramp, Settings};

use crate::common::time::{at_end, supported};

use crate::common::beam::published;
use crate::common::contact::{self, LOAD};

/// The same modes without shortening and axial flexibility: an oscillator.
fn rigid(modes: usize) -> ModalBeam {
    ModalBeam { shortening: vec![0.0; modes * modes], axial_flexibility: 0.0, ..published(modes) }
}

/// A law on the beam.
type Law = Arc<dyn ContactLaw>;

/// The beam with a law at its end, if there is one.
fn on(beam: &ModalBeam, law: Option<Law>) -> System {
    beam.system(law.map(|law| (law, LOAD))).unwrap()
}

/// Largest distance of an expected multiplier from all found, of those that do not vanish.
fn distance(found: &Multipliers, expected: &[Complex<f64>]) -> f64 {
    let nearest =
        |e: &Complex<f64>| found.values.iter().map(|m| (m - e).norm()).fold(f64::INFINITY, f64::min);
    expected.iter().filter(|m| m.norm() > 1e-3).map(nearest).fold(0.0, f64::max)
}

/// `exp(λT)` of `q̈ + C q̇ + (K + k c cᵀ) q = 0`.
fn closed_form(beam: &ModalBeam, stiffness: f64, period: f64) -> Vec<Complex<f64>> {
    let n = beam.angular_frequency.len();
    // Velocities in this many metres per second, so that all numbers are alike in size.
    const UNIT: f64 = 1e3;
    let matrix = DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => UNIT * f64::from(u8::from(i + n == j)),
        (false, true) => {
            let coupled = stiffness * beam.contact_shape[i - n] * beam.contact_shape[j];
            (-coupled - if i - n == j { beam.angular_frequency[j].powi(2) } else { 0.0 }) / UNIT
        }
        (false, false) if i == j => -2.0 * beam.damping_ratio[i - n] * beam.angular_frequency[i - n],
        (false, false) => 0.0,
    });
    matrix.complex_eigenvalues().iter().map(|lambda| (lambda * period).exp()).collect()
}

#[test]
fn a_linear_beam_has_the_multipliers_of_its_eigenvalues() {
    let omega = TAU * 51.0;
    let beam = published(6);
    // At rest the contact does not turn.
    let modes = vec![0.0; 6 * 3];
    let found = floquet_in_modes(&on(&beam, None), &modes, &[], omega).unwrap();
    let error = distance(&found, &closed_form(&beam, 0.0, TAU / omega));
    assert!(error < 1e-9, "{error:e}");
    assert!(found.stable());
    // A contact that sticks, behind the beam's axial flexibility.
    let stuck: Law = Arc::new(Jenkins::new(7.9e6, 1e9).unwrap());
    let spring: Law = Arc::new(CubicSpring::new(7.9e6, 0.0).unwrap());
    let behind = 7.9e6 / (1.0 + 7.9e6 * beam.axial_flexibility);
    for law in [stuck, spring] {
        let system = on(&beam, Some(law.clone()));
        let found = floquet_in_modes(&system, &modes, &[&[0.0, 0.0, 0.0]], omega).unwrap();
        let error = distance(&found, &closed_form(&beam, behind, TAU / omega));
        assert!(error < 1e-7, "{error:e} {law:?}");
    }
}

/// A spring and a damper, without memory.
#[derive(Debug)]
struct Damper(f64, f64);

impl ContactLaw for Damper {
    fn state_len(&self) -> usize {
        0
    }

    fn set_state(&self, _: f64, _: f64, _: f64, _: &mut [f64]) {}

    fn step(&self, _: &[f64], inputs: Inputs, _: &mut [f64]) -> Response {
        Response {
            force: self.0 * inputs.displacement + self.1 * inputs.velocity,
            tangents: Tangents { displacement: self.0, velocity: self.1, normal_load: 0.0 },
            dissipated_energy: 0.0,
            slip_state: SlipState::Stick,
        }
    }

    fn state_tangents(&self, _: &[f64], _: Inputs, out: &mut StateTangents) {
        out.reset(0);
    }

    fn limit(&self, _: f64) -> f64 {
        f64::INFINITY
    }
}

#[test]
fn a_damper_behind_the_flexibility_has_the_multipliers_of_its_eigenvalues() {
    // u = v + a T and T = k v + c v̇: the contact's own displacement v is one more state.
    let omega = TAU * 51.0;
    for (compliance, stiffness, damping) in [(1e-7, 5e6, 2e3), (1.5e-8, 7.9e6, 100.0)] {
        let beam = ModalBeam { axial_flexibility: compliance, ..rigid(3) };
        let (c, w) = (&beam.contact_shape, &beam.angular_frequency);
        const UNIT: f64 = 1e3;
        let matrix = DMatrix::from_fn(7, 7, |i, j| match (i, j) {
            (6, 0..3) => c[j] / (compliance * damping),
            (6, 6) => -(1.0 / compliance + stiffness) / damping,
            (0..3, _) => UNIT * f64::from(u8::from(i + 3 == j)),
            (3..6, 0..3) => {
                let own = if i - 3 == j { w[j] * w[j] } else { 0.0 };
                -(own + c[i - 3] * c[j] / compliance) / UNIT
            }
            (3..6, 6) => c[i - 3] / compliance / UNIT,
            (3..6, _) if i == j => -2.0 * beam.damping_ratio[i - 3] * w[i - 3],
            _ => 0.0,
        });
        let lambda = matrix.complex_eigenvalues();
        let expected: Vec<Complex<f64>> = lambda.iter().map(|l| (l * (TAU / omega)).exp()).collect();
        let system = on(&beam, Some(Arc::new(Damper(stiffness, damping))));
        let found = floquet_in_modes(&system, &[0.0; 9], &[&[0.0; 3]], omega).unwrap();
        let error = distance(&found, &expected);
        assert!(error < 1e-5, "{error:e} {:?} {expected:?}", found.values);
    }
}

#[test]
fn a_beam_that_does_not_turn_is_the_oscillator_of_its_modes() {
    let (omega, beam) = (TAU * 50.5, rigid(4));
    let u: &[f64] = &[1e-6, 4e-5, 1e-5, 2e-6, -1e-6, 3e-6, 1e-6];
    let modes = vec![0.0; 4 * 7];
    let laws: [Law; 4] = [
        Arc::new(contact::published()),
        Arc::new(CubicSpring::new(1e6, 1e15).unwrap()),
        Arc::new(Jenkins::new(7.9e6, 0.6).unwrap()),
        Arc::new(ParallelSliders::new(&[(3e6, 0.2), (3e6, 0.3), (1e6, 0.5)]).unwrap()),
    ];
    for law in laws {
        let (system, loaded) =
            (on(&beam, Some(law.clone())), LoadedContact { law: law.as_ref(), normal_load: LOAD });
        let expected = floquet(&system.linear_part(), &[loaded], &[u], omega).unwrap();
        let found = floquet_in_modes(&system, &modes, &[u], omega).unwrap();
        let error = distance(&found, &expected.values);
        assert!(error < 1e-6, "{error:e} {law:?}");
    }
}

/// The response at phase resonance with so much acceleration held, and the displacement that remains for the
/// contact.
fn resonance(beam: &ModalBeam, law: Law, acceleration: f64, harmonics: usize) -> (Resonance, Vec<f64>) {
    let settings = CurveSettings { harmonics, ..CurveSettings::default() };
    let found = phase_resonance(&on(beam, Some(law)), acceleration, &settings, None).unwrap();
    let pairs = found.contact_displacement.iter().zip(&found.contact_force);
    let left = pairs.map(|(u, force)| u - beam.axial_flexibility * force).collect();
    (found, left)
}

/// Multipliers of the map over a period that the time integrator makes, by differences.
fn by_integration(
    beam: &ModalBeam,
    law: impl ContactLaw + 'static,
    response: &Resonance,
) -> Vec<Complex<f64>> {
    const STEPS: usize = 200;
    let n = beam.angular_frequency.len();
    let omega = response.angular_frequency;
    let mut integrator = supported(beam, law, LOAD);
    let settings = Settings { tolerance: 1e-10, ..Settings::default() };
    let force = |k: usize| response.force_amplitude * (TAU * k as f64 / STEPS as f64).cos();
    let mut over = |start: &[f64]| -> Vec<f64> {
        let inputs = [Ramp::held(0.0), Ramp::held(LOAD)];
        let mut motion = integrator.moving(&start[..n], &start[n..2 * n], &inputs, &[start[2 * n]]).unwrap();
        for k in 0..STEPS {
            let inputs = [Ramp::line(force(k), force(k + 1)), Ramp::held(LOAD)];
            integrator.advance(&mut motion, TAU / omega / STEPS as f64, &inputs, &settings).unwrap();
        }
        [motion.modal_displacement(), motion.modal_velocity(), &[at_end(&motion).force]].concat()
    };
    let width = response.coefficients.len() / n;
    let at_zero = |place: fn(usize) -> bool, factor: &dyn Fn(usize) -> f64, coefficients: &[f64]| -> f64 {
        let kept = coefficients.iter().enumerate().filter(|(k, _)| place(*k));
        kept.map(|(k, value)| factor(k.div_ceil(2)) * value).sum()
    };
    let cosine = |k: usize| k == 0 || k % 2 == 1;
    let mut start: Vec<f64> =
        response.coefficients.chunks_exact(width).map(|q| at_zero(cosine, &|_| 1.0, q)).collect();
    start.extend(
        response
            .coefficients
            .chunks_exact(width)
            .map(|q| at_zero(|k| k > 0 && k % 2 == 0, &|order| order as f64 * omega, q)),
    );
    start.push(at_zero(cosine, &|_| 1.0, &response.contact_force));
    // The series is cut off: a few periods bring the motion to its own.
    for _ in 0..15 {
        start = over(&start);
    }
    let sizes: Vec<f64> = (0..=2 * n)
        .map(|k| {
            if k < n {
                1e-8
            } else if k < 2 * n {
                1e-8 * omega
            } else {
                1e-3
            }
        })
        .collect();
    let columns: Vec<Vec<f64>> = (0..=2 * n)
        .map(|k| {
            let mut side = |sign: f64| {
                let mut moved = start.clone();
                moved[k] += sign * sizes[k];
                over(&moved)
            };
            let (up, down) = (side(1.0), side(-1.0));
            (0..=2 * n).map(|i| (up[i] - down[i]) / (2.0 * sizes[i])).collect()
        })
        .collect();
    DMatrix::from_fn(2 * n + 1, 2 * n + 1, |i, j| columns[j][i]).complex_eigenvalues().as_slice().to_vec()
}

#[test]
fn disturbances_of_the_beam_die_out_in_time_as_the_multipliers_say() {
    let beam = published(3);
    let law = contact::published();
    for acceleration in [10.0, 40.0] {
        let mut errors = vec![];
        // The harmonics left out are missing from the turning points, whose place the multipliers depend on.
        for harmonics in [7, 28] {
            let (response, left) = resonance(&beam, Arc::new(law), acceleration, harmonics);
            let omega = response.angular_frequency;
            let modes = &response.coefficients;
            let system = on(&beam, Some(Arc::new(law)));
            let found = floquet_in_modes(&system, modes, &[&left], omega).unwrap();
            assert!(found.stable());
            errors.push(distance(&found, &by_integration(&beam, law, &response)));
        }
        assert!(errors[0] < 2e-3 && errors[1] < 0.4 * errors[0], "{acceleration}: {errors:?}");
    }
}

#[test]
fn disturbances_die_out_as_the_multipliers_say_where_a_limit_follows_the_velocity_in_front_of_a_flexibility()
{
    let beam = ModalBeam { axial_flexibility: 1e-7, ..published(3) };
    let changes = JointChanges { weakening: Some((0.2, 5e-3)), ..JointChanges::default() };
    let law = Joint::new(contact::published(), changes).unwrap();
    // The displacement behind the flexibility has kinks, which few harmonics round.
    let errors = [15, 60].map(|harmonics| {
        let (response, left) = resonance(&beam, Arc::new(law.clone()), 40.0, harmonics);
        let system = on(&beam, Some(Arc::new(law.clone())));
        let omega = response.angular_frequency;
        let found = floquet_in_modes(&system, &response.coefficients, &[&left], omega).unwrap();
        distance(&found, &by_integration(&beam, law.clone(), &response))
    });
    assert!(errors[0] < 1e-2 && errors[1] < 0.4 * errors[0], "{errors:?}");
}

/// Every point of a curve with its verdict; the folds in between.
fn verdicts(beam: &ModalBeam, law: Option<Law>, range: [f64; 2], level: f64) -> (Vec<bool>, usize) {
    let assembly = Assembly::new(on(beam, law));
    let settings =
        CurveSettings { harmonics: 7, tolerance: 1e-9, stability: true, ..CurveSettings::default() };
    let control = Control::Level(level);
    let curve =
        frequency_response(&assembly, TAU * range[0], TAU * range[1], &control, &settings, &mut |_| true)
            .unwrap();
    assert_eq!(curve.ending, Ending::Complete);
    let verdicts = curve.points.iter().map(|point| point.stable.unwrap()).collect();
    (verdicts, curve.folds.len())
}

#[test]
fn a_beam_that_stretches_is_unstable_between_its_folds_alone() {
    let beam = ModalBeam { stretching_stiffness: 1e7, ..published(2) };
    let (stable, folds) = verdicts(&beam, None, [45.0, 56.0], 1.0);
    let changes = stable.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert_eq!((folds, changes), (2, 2));
    assert!(stable[0] && stable[stable.len() - 1]);
}

#[test]
fn every_point_of_a_response_with_friction_has_a_verdict() {
    let beam = published(4);
    let valanis: Law = Arc::new(contact::published());
    let jenkins: Law = Arc::new(Jenkins::new(7.9e6, 0.6).unwrap());
    for law in [valanis, jenkins] {
        let (stable, folds) = verdicts(&beam, Some(law), [49.5, 52.0], 8.0);
        assert!(folds == 0 && stable.iter().all(|stable| *stable));
    }
}
