//! Published levels, simulated by harmonic balance, inverted.

use std::sync::Arc;

use super::{Doubts, SteadyMotion, invert};
use crate::contact::{ContactLaw, LawKind, Valanis};
use crate::harmonic::{CurveSettings, Resonance, phase_resonance};
use crate::identify::{expand, fit_law};
use crate::numeric::fourier::time_derivative;
use crate::system::{Beam, Damping, ModalBeam, PointMass, rotational_stiffness_from_frequency};

/// The published beam with the published contact.
pub(in crate::identify) fn beam(modes: usize) -> ModalBeam {
    ModalBeam::new(&description(modes)).unwrap()
}

pub(in crate::identify) fn description(modes: usize) -> Beam {
    let mass = |position, mass| PointMass { position, mass };
    Beam {
        length: 0.6,
        width: 0.04,
        thickness: 0.005,
        density: 7850.0,
        youngs_modulus: 197.1e9,
        modes,
        static_correction: true,
        damping: Damping::Uniform(0.003),
        point_masses: vec![mass(0.55, 0.02515), mass(0.3, 0.005), mass(0.1, 0.005)],
        offset: 0.006,
        rotational_stiffness: 0.0,
        clamp_stiffness: None,
        excitation_position: 0.55,
        sensors: vec![0.55, 0.3, 0.1],
        contact_points: vec![],
    }
}

pub(in crate::identify) fn resonance(beam: &ModalBeam, amplitude: f64) -> Resonance {
    let law: Arc<dyn ContactLaw> = Arc::new(Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15).unwrap());
    let settings = CurveSettings { harmonics: 9, ..CurveSettings::default() };
    phase_resonance(&beam.system(Some((law, 147.15))).unwrap(), amplitude, &settings, None).unwrap()
}

pub(in crate::identify) fn measured(beam: &ModalBeam, at: &Resonance) -> SteadyMotion {
    let modes: Vec<&[f64]> = at.coefficients.chunks_exact(19).collect();
    let acceleration = |shape: &[f64]| -> Vec<f64> {
        let sum = |k: usize| shape.iter().zip(&modes).map(|(s, q)| s * q[k]).sum::<f64>();
        time_derivative(&(0..19).map(sum).collect::<Vec<_>>(), 2, at.angular_frequency)
    };
    let accelerations: Vec<Vec<f64>> = beam.sensors.iter().map(|s| acceleration(&s.shape)).collect();
    SteadyMotion {
        angular_frequency: at.angular_frequency,
        excitation: vec![0.0, at.force_amplitude, 0.0],
        excitation_errors: vec![0.0; 3],
        errors: accelerations.iter().map(|a| vec![1e-6; a.len()]).collect(),
        accelerations,
    }
}

/// Of a measuring chain without a fault, and of one that may be 1 % off.
const CERTAIN: Doubts = Doubts { excitation_gain: 0.0, sensor_gain: 0.0, sensor_mass: 0.0, force: 1e4 };
const DOUBTFUL: Doubts = Doubts { excitation_gain: 0.01, sensor_gain: 0.01, sensor_mass: 0.0, force: 150.0 };

pub(in crate::identify) fn error(a: &[f64], b: &[f64]) -> f64 {
    let square = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>();
    (square(&mut a.iter().zip(b).map(|(a, b)| a - b)) / square(&mut b.iter().copied())).sqrt()
}

/// Stiffness, friction and smoothness of the contact.
const TABLE_3: [f64; 3] = [7.9e6, 7.9e6 / 8.7e4 / 147.15, 0.3];

pub(in crate::identify) const LEVELS: [f64; 6] = [20.0, 30.0, 40.0, 50.0, 60.0, 70.0];

/// The published levels on a beam of 30 modes, with every channel's noise as a fraction of its root mean square, and gains
/// of the accelerometers and the load cell.
fn records(
    beam: &ModalBeam,
    truths: &[Resonance],
    noise: f64,
    gains: [f64; 4],
    seed: u64,
) -> Vec<SteadyMotion> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let mut spoilt = |truth: &Resonance| {
        let mut motion = measured(beam, truth);
        let deviation = noise * motion.excitation[1] / 2.0_f64.sqrt();
        motion.excitation[1..].iter_mut().for_each(|f| *f = gains[3] * *f + deviation * normal());
        motion.excitation_errors[1..].fill(deviation);
        for ((gain, a), errors) in gains.iter().zip(&mut motion.accelerations).zip(&mut motion.errors) {
            let deviation = noise * (a.iter().map(|x| x * x).sum::<f64>() / 2.0).sqrt();
            a.iter_mut().for_each(|x| *x = gain * *x + deviation * normal());
            errors.fill(deviation.max(1e-6));
        }
        motion
    };
    truths.iter().map(&mut spoilt).collect()
}

pub(in crate::identify) fn truths(beam: &ModalBeam) -> Vec<Resonance> {
    LEVELS.iter().map(|level| resonance(beam, *level)).collect()
}

#[test]
fn force_and_motion_of_the_contact_come_back_at_every_level() {
    let beam = beam(30);
    let truths = truths(&beam);
    let found = invert(&beam, &records(&beam, &truths, 0.0, [1.0; 4], 1), 9, &CERTAIN).unwrap();
    for (found, truth) in found.periods.iter().zip(&truths) {
        assert!(error(&found.force, &truth.contact_force[..19]) < 1e-4);
        // The truth's displacement is that of contact and series spring.
        let series =
            |k: usize| truth.contact_displacement[k] - beam.axial_flexibility * truth.contact_force[k];
        let own: Vec<f64> = (1..19).map(series).collect();
        assert!(error(&found.displacement[1..], &own) < 1e-4);
    }
}

#[test]
fn gains_of_the_measuring_chain_are_told_from_the_force() {
    let beam = beam(30);
    let truths = truths(&beam);
    let gains = [1.01, 0.99, 1.01, 0.99];
    // Told to be exact, the chain's faults become a force.
    let spoilt = records(&beam, &truths, 3e-4, gains, 2);
    let worst = |doubts: &Doubts| {
        let found = invert(&beam, &spoilt, 9, doubts).unwrap();
        let errors =
            found.periods.iter().zip(&truths).map(|(f, t)| error(&f.force[1..], &t.contact_force[1..19]));
        (errors.fold(0.0, f64::max), found)
    };
    assert!(worst(&CERTAIN).0 > 0.08);
    let (error, found) = worst(&DOUBTFUL);
    assert!(error < 0.015, "{error}");
    assert!((found.misfit - 1.0).abs() < 0.2, "{}", found.misfit);
    for (gain, [told, deviation]) in gains.iter().zip(&found.sensor_gains) {
        assert!((told - gain.ln()).abs() < 3.0 * deviation);
    }
}

/// Of many records of random noise and random gains the true coefficients lie within 1.96 standard errors in nineteen of
/// twenty, and so do the true parameters of the law that is fitted to them: the intervals are neither too narrow nor too wide.
#[test]
fn intervals_of_force_and_law_are_what_they_scatter_by() {
    let beam = beam(12);
    let truths: Vec<Resonance> = [30.0, 60.0].map(|level| resonance(&beam, level)).to_vec();
    let mut random = fastrand::Rng::with_seed(5);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let valanis = LawKind::find("valanis").unwrap();
    let (mut coefficients, mut parameters) = (Vec::new(), Vec::new());
    for seed in 0..40 {
        let gains = [0; 4].map(|_| (0.01 * normal()).exp());
        let found = invert(&beam, &records(&beam, &truths, 1e-3, gains, seed), 9, &DOUBTFUL).unwrap();
        for (found, truth) in found.periods.iter().zip(&truths) {
            let off = |k: usize| (found.force[k] - truth.contact_force[k]) / found.covariance[(k, k)].sqrt();
            coefficients.extend((1..19).map(off));
        }
        let law = fit_law(valanis, 147.15, &found.periods, &[1], None).unwrap();
        for (found, truth) in law.parameters.iter().zip(TABLE_3) {
            let half = 0.5 * (found.interval[1] / found.interval[0]).ln();
            parameters.push(1.96 * (found.value / truth).ln() / half);
        }
    }
    check_scatter(&coefficients, 0.92..0.98, 0.9..1.1);
    check_scatter(&parameters, 0.89..1.0, 0.8..1.25);
}

/// Deviations from the truth over their standard errors: how many lie within the 95 % interval, and their root mean square.
fn check_scatter(deviations: &[f64], share: std::ops::Range<f64>, size: std::ops::Range<f64>) {
    let count = deviations.len() as f64;
    let inside = deviations.iter().filter(|x| x.abs() < 1.96).count() as f64 / count;
    let square = (deviations.iter().map(|x| x * x).sum::<f64>() / count).sqrt();
    assert!(share.contains(&inside) && size.contains(&square), "{inside} of {count} inside, {square}");
}

#[test]
fn a_law_fitted_at_the_highest_level_predicts_the_others() {
    let beam = beam(30);
    let truths = truths(&beam);
    // Noise of 1 % leaves 3e-4 in the coefficients of 2000 samples.
    for (noise, gains, bound) in [(0.0, [1.0; 4], 0.02), (3e-4, [1.01, 0.99, 1.01, 0.99], 0.05)] {
        let doubts = if noise == 0.0 { CERTAIN } else { DOUBTFUL };
        let found = invert(&beam, &records(&beam, &truths, noise, gains, 3), 9, &doubts).unwrap();
        let law = fit_law(LawKind::find("valanis").unwrap(), 147.15, &found.periods, &[5], None).unwrap();
        for (found, truth) in law.parameters.iter().zip(TABLE_3) {
            assert!((found.value / truth - 1.0).abs() < 0.02, "{found:?}");
        }
        assert!(law.errors.iter().all(|error| error.unwrap() < bound), "{:?}", law.errors);
    }
}

/// Two modes lack what a moment at the end does to the others: the reason why receptances are inverted.
#[test]
fn two_modes_at_the_amplitude_are_less_exact() {
    let fine = beam(30);
    for level in LEVELS {
        let truth = resonance(&fine, level);
        let mut coarse = description(2);
        let frequency = truth.angular_frequency / std::f64::consts::TAU;
        coarse.rotational_stiffness = rotational_stiffness_from_frequency(&coarse, frequency).unwrap();
        let found = expand(&coarse, &measured(&fine, &truth), 9).unwrap();
        let off = error(&found.force[1..], &truth.contact_force[1..19]);
        assert!((0.03..0.12).contains(&off), "{level}: {off}");
        assert!(found.conditioning < 2.0 && found.unexplained < 0.05);
    }
}
