//! Harmonic balance against closed forms, an exact event-driven solution, energy balances and the
//! published reference values.

use std::f64::consts::{PI, TAU};

use stickslip::contact::Jenkins;
use stickslip::harmonic::fourier::{time_derivative, value};
use stickslip::harmonic::{
    CurveSettings, HarmonicError, Method, Resonance, backbone, excited_harmonics, phase_resonance,
    whole_periods,
};
use stickslip::system::{Core, ModalBeam, Sensor, System};

use crate::common::beam::{forced_response, modal};
use crate::common::contact::{self, LOAD, loaded};
use crate::common::exact_period::{Oscillator, steady_period};

/// One mode of 50 Hz with the contact on it, without shortening and axial flexibility.
fn single_mode(damping_ratio: f64) -> ModalBeam {
    ModalBeam {
        sensors: vec![Sensor { position: 0.0, shape: vec![1.0] }],
        ..modal(&[TAU * 50.0], &[damping_ratio], &[0.06], &[1.3])
    }
}

/// Three modes with everything a beam has.
fn three_modes() -> ModalBeam {
    let omega = [TAU * 49.0, TAU * 158.0, TAU * 325.0];
    ModalBeam {
        shortening: vec![32.0, -4.0, -2.0, -4.0, 110.0, 12.0, -2.0, 12.0, 230.0],
        axial_flexibility: 1.5e-8,
        ..modal(&omega, &[0.003, 0.004, 0.005], &[-0.060, 0.115, -0.175], &[0.35, -0.7, 1.05])
    }
}

/// Sees one of three modes alone.
fn sensor_of_mode(mode: usize) -> Sensor {
    let shape = (0..3).map(|other| f64::from(u8::from(other == mode))).collect();
    Sensor { position: 0.0, shape }
}

/// Receptance of the beam alone at the excitation: (real, imaginary) part.
fn receptance(beam: &ModalBeam, frequency: f64) -> (f64, f64) {
    let mut sum = (0.0, 0.0);
    for i in 0..beam.angular_frequency.len() {
        let natural = beam.angular_frequency[i];
        let real = natural * natural - frequency * frequency;
        let imaginary = 2.0 * beam.damping_ratio[i] * natural * frequency;
        let size = beam.excitation_shape[i].powi(2) / (real * real + imaginary * imaginary);
        sum = (sum.0 + size * real, sum.1 - size * imaginary);
    }
    sum
}

#[test]
fn beam_without_contact_resonates_where_its_receptance_is_imaginary() {
    let beam = three_modes();
    let (mut low, mut high) = (TAU * 45.0, TAU * 55.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if receptance(&beam, middle).0 > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let settings =
        CurveSettings { harmonics: 3, method: Method::Sampled { samples: 64 }, ..CurveSettings::default() };
    let found = phase_resonance(&beam.system(None).unwrap(), 12.0, &settings, None).unwrap();
    assert!((found.angular_frequency / low - 1.0).abs() < 1e-10, "{}", found.angular_frequency / low - 1.0);
    let force = 12.0 / (low * low * receptance(&beam, low).1.abs());
    assert!((found.force_amplitude / force - 1.0).abs() < 1e-7);
}

#[test]
fn forced_response_without_contact_is_the_receptance() {
    let beam = three_modes();
    let settings =
        CurveSettings { harmonics: 4, method: Method::Sampled { samples: 64 }, ..CurveSettings::default() };
    let (period, force) = (0.021, [0.7, 1.0, -2.0, 0.0, 0.0, 0.5, 0.3]);
    let response = forced_response(beam.system(None).unwrap(), period, &force, &settings).unwrap();
    let displacement = &response.nodes[0];
    assert!((displacement[0] - 0.7 * receptance(&beam, 0.0).0).abs() < 1e-15);
    for h in 1..=3 {
        let (real, imaginary) = receptance(&beam, h as f64 * TAU / period);
        let (fc, fs) = (force[2 * h - 1], force[2 * h]);
        // (c − i s) = H (fc − i fs)
        let expected = (real * fc + imaginary * fs, real * fs - imaginary * fc);
        let size = expected.0.hypot(expected.1);
        assert!((displacement[2 * h - 1] - expected.0).abs() <= 1e-9 * size + 1e-18, "harmonic {h}");
        assert!((displacement[2 * h] - expected.1).abs() <= 1e-9 * size + 1e-18, "harmonic {h}");
    }
    // One accelerometer, at the times of a record.
    let speed = TAU / period;
    let acceleration = time_derivative(displacement, 2, speed);
    for t in [0.0, 0.004, 0.1] {
        let a = value(&acceleration, speed * t);
        let expected: f64 = (1..=4)
            .map(|h| {
                let phase = h as f64 * speed * t;
                let (c, s) = (displacement[2 * h - 1], displacement[2 * h]);
                -(h as f64 * speed).powi(2) * (c * phase.cos() + s * phase.sin())
            })
            .sum();
        assert!((a - expected).abs() < 1e-9 * expected.abs().max(1.0));
    }
}

#[test]
fn stuck_contact_is_a_spring_in_series_with_the_axial_one() {
    let mut beam = single_mode(0.01);
    beam.axial_flexibility = 4e-8;
    let law = Jenkins::new(5e6, 1e6).unwrap();
    let contact = loaded(law, LOAD);
    let settings =
        CurveSettings { harmonics: 3, method: Method::Sampled { samples: 64 }, ..CurveSettings::default() };
    let found = phase_resonance(&beam.system(contact.clone()).unwrap(), 10.0, &settings, None).unwrap();
    let stiffness = 5e6 / (1.0 + 4e-8 * 5e6);
    let natural = ((TAU * 50.0_f64).powi(2) + stiffness * 0.06 * 0.06).sqrt();
    assert!((found.angular_frequency / natural - 1.0).abs() < 1e-9);
    assert!(found.dissipated_energy.abs() < 1e-12 * found.viscous_energy);
    // 2 ζ ω₁ Ω q = F φ with q = a/(Ω² φ).
    let force = 2.0 * 0.01 * TAU * 50.0 * 10.0 / (natural * 1.3 * 1.3);
    assert!((found.force_amplitude / force - 1.0).abs() < 1e-7);
}

#[test]
fn jenkins_oscillator_matches_its_exact_event_driven_solution() {
    let (stiffness, limit) = (4e6, 60.0);
    let law = Jenkins::new(stiffness, limit / LOAD).unwrap();
    let contact = loaded(law, LOAD);
    let settings =
        CurveSettings { harmonics: 15, method: Method::Sampled { samples: 512 }, ..CurveSettings::default() };
    for (damping_ratio, frequency, force) in [(0.02, 52.0, 20.0), (0.05, 60.0, 40.0), (0.02, 57.0, 6.0)] {
        let beam = single_mode(damping_ratio);
        let exact = steady_period(&Oscillator {
            natural: TAU * 50.0,
            damping_ratio,
            lever: 0.06,
            stiffness,
            limit,
            force: 1.3 * force,
            frequency: TAU * frequency,
        });
        let system = beam.system(contact.clone()).unwrap();
        let found = forced_response(system, 1.0 / frequency, &[0.0, force], &settings).unwrap();
        // Of the one mode.
        let peak =
            (0..2000).map(|k| value(&found.nodes[0], TAU * k as f64 / 2000.0).abs()).fold(0.0, f64::max);
        assert!((peak / exact.amplitude - 1.0).abs() < 1e-4, "{peak} {}", exact.amplitude);
        assert!(exact.dissipated_energy > 0.0, "the case must slip");
        let ratio = found.dissipated_energy() / exact.dissipated_energy;
        assert!((ratio - 1.0).abs() < 5e-4, "{ratio}");
    }
}

fn resonance_at(amplitude: f64) -> (ModalBeam, Resonance) {
    let beam = three_modes();
    let law = contact::published();
    let contact = loaded(law, LOAD);
    let settings =
        CurveSettings { harmonics: 5, method: Method::Sampled { samples: 128 }, ..CurveSettings::default() };
    let found = phase_resonance(&beam.system(contact.clone()).unwrap(), amplitude, &settings, None).unwrap();
    (beam, found)
}

#[test]
fn excitation_work_is_dissipated_in_contact_and_modes() {
    for amplitude in [1.0, 20.0, 60.0] {
        let (_, found) = resonance_at(amplitude);
        let work = PI * found.force_amplitude * amplitude / found.angular_frequency.powi(2);
        let lost = found.dissipated_energy + found.viscous_energy;
        assert!((work / lost - 1.0).abs() < 1e-7, "{work} {lost}");
        assert!(found.dissipated_energy > 0.0);
    }
}

#[test]
fn excitation_work_balances_with_several_harmonics() {
    let mut beam = three_modes();
    beam.sensors = (0..3).map(sensor_of_mode).collect();
    let contact = loaded(contact::published(), LOAD);
    let settings =
        CurveSettings { harmonics: 7, method: Method::Sampled { samples: 128 }, ..CurveSettings::default() };
    let force = [0.0, 15.0, 4.0, 0.5, -0.4, 6.0, 8.0];
    let response = forced_response(beam.system(contact).unwrap(), 0.0195, &force, &settings).unwrap();
    let [modes @ .., displacement] = response.nodes.as_slice() else { panic!("the excitation is last") };
    let work: f64 = (1..=3)
        .map(|h| {
            PI * h as f64 * (force[2 * h - 1] * displacement[2 * h] - force[2 * h] * displacement[2 * h - 1])
        })
        .sum();
    let viscous: f64 = modes
        .iter()
        .zip(beam.angular_frequency.iter().zip(&beam.damping_ratio))
        .map(|(mode, (omega, zeta))| {
            let rate = time_derivative(mode, 1, TAU / 0.0195);
            let mean_square = rate[1..].iter().map(|c| 0.5 * c * c).sum::<f64>();
            2.0 * zeta * omega * mean_square * 0.0195
        })
        .sum();
    let lost = response.dissipated_energy() + viscous;
    assert!((work / lost - 1.0).abs() < 1e-7, "{work} {lost}");
    assert!((response.work / work - 1.0).abs() < 1e-7, "{work} {}", response.work);
}

#[test]
fn response_is_odd_without_shortening_and_not_with_it() {
    let (mut beam, with) = resonance_at(30.0);
    let even = |coefficients: &[f64]| -> f64 {
        let per_mode = coefficients.chunks_exact(11);
        per_mode.flat_map(|q| [q[0], q[3], q[4], q[7], q[8]]).fold(0.0_f64, |m, x| m.max(x.abs()))
    };
    assert!(even(&with.coefficients) > 1e-4 * with.coefficients[2].abs());
    beam.shortening.fill(0.0);
    let law = contact::published();
    let contact = loaded(law, LOAD);
    let settings =
        CurveSettings { harmonics: 5, method: Method::Sampled { samples: 128 }, ..CurveSettings::default() };
    let without = phase_resonance(&beam.system(contact.clone()).unwrap(), 30.0, &settings, None).unwrap();
    assert!(even(&without.coefficients) < 1e-9 * without.coefficients[2].abs());
}

#[test]
fn acceleration_is_held_and_displacement_lags_a_quarter_period() {
    let (beam, found) = resonance_at(30.0);
    let first =
        |k: usize| -> f64 { (0..3).map(|i| beam.excitation_shape[i] * found.coefficients[11 * i + k]).sum() };
    let amplitude = 30.0 / found.angular_frequency.powi(2);
    assert!((first(2) / amplitude - 1.0).abs() < 1e-8);
    assert!((first(1) / amplitude).abs() < 1e-8);
}

/// Published parameters and beam, four modes and five harmonics; values from independent programs.
#[test]
fn published_beam_softens_as_the_reference_does() {
    let reference = [
        (0.5, 54.04, 24.8),
        (10.0, 53.29, 4.1),
        (20.0, 51.64, 2.9),
        (30.0, 50.60, 3.1),
        (40.0, 50.07, 3.6),
        (50.0, 49.76, 4.1),
        (60.0, 49.55, 4.7),
        (70.0, 49.41, 5.2),
    ];
    let beam = crate::common::finite_elements::published_beam(4, 24);
    let law = contact::published();
    let contact = loaded(law, LOAD);
    let settings =
        CurveSettings { harmonics: 5, method: Method::Sampled { samples: 128 }, ..CurveSettings::default() };
    // Falling and rising: the caller's order is kept, and does not matter.
    let amplitudes: Vec<f64> = reference.iter().rev().map(|r| r.0).collect();
    let found = backbone(&beam.system(contact.clone()).unwrap(), &amplitudes, &settings, &[]).unwrap();
    for ((amplitude, frequency, ratio), found) in reference.iter().zip(found.iter().rev()) {
        assert_eq!(found.acceleration_amplitude, *amplitude);
        let hertz = found.angular_frequency / TAU;
        assert!((hertz - frequency).abs() < 0.01, "{hertz} Hz at {amplitude} m/s²");
        let peak = amplitude / found.force_amplitude;
        assert!((peak - ratio).abs() < 0.05 + 0.01 * ratio, "{peak} at {amplitude} m/s²");
    }
    // A cold start at one level finds the same.
    let cold = phase_resonance(&beam.system(contact.clone()).unwrap(), 40.0, &settings, None).unwrap();
    assert!((cold.angular_frequency / found[3].angular_frequency - 1.0).abs() < 1e-7);
}

#[test]
fn frequency_converges_with_the_square_of_the_sampling_step() {
    let beam = three_modes();
    let law = contact::published();
    let contact = loaded(law, LOAD);
    let at = |samples: usize| {
        let settings =
            CurveSettings { harmonics: 5, method: Method::Sampled { samples }, ..CurveSettings::default() };
        phase_resonance(&beam.system(contact.clone()).unwrap(), 20.0, &settings, None)
            .unwrap()
            .angular_frequency
    };
    let best = at(1024);
    let (coarse, fine) = ((at(128) - best).abs(), (at(512) - best).abs());
    assert!(fine < coarse / 8.0, "{coarse} {fine}");
    // In hertz: what a measured resonance frequency cannot resolve.
    assert!(fine / TAU < 1e-3, "{fine} rad/s");
}

#[test]
fn starts_do_not_change_the_answer() {
    let beam = three_modes();
    let settings =
        CurveSettings { harmonics: 5, method: Method::Sampled { samples: 128 }, ..CurveSettings::default() };
    let law = Jenkins::new(5e6, 0.8).unwrap();
    let contact = loaded(law, LOAD);
    let amplitudes = [5.0, 35.0];
    let cold = backbone(&beam.system(contact.clone()).unwrap(), &amplitudes, &settings, &[]).unwrap();
    let other_law = contact::published();
    let other = loaded(other_law, LOAD);
    let elsewhere = backbone(&beam.system(other.clone()).unwrap(), &amplitudes, &settings, &[]).unwrap();
    let warm = backbone(&beam.system(contact.clone()).unwrap(), &amplitudes, &settings, &elsewhere).unwrap();
    for (a, b) in cold.iter().zip(&warm) {
        assert!((a.angular_frequency / b.angular_frequency - 1.0).abs() < 1e-7);
        assert!((a.force_amplitude / b.force_amplitude - 1.0).abs() < 1e-6);
    }
}

#[test]
fn whole_periods_survive_noise_and_missing_fundamental() {
    let record = |periods: usize, orders: &[(usize, f64)], noise: f64| -> Vec<f64> {
        let mut numbers = fastrand::Rng::with_seed(1);
        (0..512)
            .map(|k| {
                let random = 2.0 * numbers.f64() - 1.0;
                let phase = TAU * (periods * k) as f64 / 512.0;
                let sum: f64 = orders.iter().map(|(h, a)| a * (*h as f64 * phase + 0.3).sin()).sum();
                0.2 + sum + noise * random
            })
            .collect()
    };
    assert_eq!(whole_periods(&record(4, &[(1, 1.0), (3, 0.1)], 0.02)), Some(4));
    assert_eq!(whole_periods(&record(5, &[(2, 1.0), (3, 0.4)], 0.0)), Some(5));
    assert_eq!(whole_periods(&record(1, &[(1, 1.0)], 0.0)), Some(1));
    // Noise with a long memory has its power where the harmonics are.
    let drift = |periods: usize, noise: f64| {
        let (mut values, mut slow) = (record(periods, &[(1, 1.0)], 0.0), 0.0);
        for (value, white) in values.iter_mut().zip(record(periods, &[], 1.0)) {
            slow = 0.95 * slow + noise * (white - 0.2);
            *value += slow;
        }
        values
    };
    for noise in [1e-3, 5e-3, 2e-2] {
        assert_eq!(whole_periods(&drift(4, noise)), Some(4), "{noise}");
        assert_eq!(excited_harmonics(&drift(4, noise), 4), [0, 1], "{noise}");
    }
    assert_eq!(whole_periods(&[1.0; 64]), None);
    assert_eq!(whole_periods(&[]), None);
    assert_eq!(whole_periods(&[f64::NAN; 64]), None);
}

#[test]
fn nonsense_is_refused() {
    let beam = three_modes();
    let settings = CurveSettings::default();
    let invalid = |result: Result<Resonance, HarmonicError>| {
        assert!(matches!(result, Err(HarmonicError::InvalidInput(_))), "{result:?}");
    };
    let system = beam.system(None).unwrap();
    invalid(phase_resonance(&system, 0.0, &settings, None));
    invalid(phase_resonance(&system, f64::NAN, &settings, None));
    let coarse = CurveSettings { method: Method::Sampled { samples: 16 }, ..settings };
    invalid(phase_resonance(&system, 1.0, &coarse, None));
    invalid(phase_resonance(&system, 1.0, &CurveSettings { harmonics: 0, ..settings }, None));
    let Core::Modal { angular_frequency, .. } = &system.core else { panic!("a beam is modal") };
    let core = Core::Modal { angular_frequency: angular_frequency.clone(), damping_ratio: vec![] };
    invalid(phase_resonance(&System { core, ..system.clone() }, 1.0, &settings, None));
    assert!(ModalBeam { damping_ratio: vec![], ..beam.clone() }.system(None).is_err());
    let still = ModalBeam { excitation_shape: vec![0.0; 3], ..beam.clone() };
    invalid(phase_resonance(&still.system(None).unwrap(), 1.0, &settings, None));
    let prescribed = System {
        core: Core::Modal { angular_frequency: vec![], damping_ratio: vec![] },
        shortening: vec![],
        ports: vec![],
        elements: vec![],
        driven: vec![],
        sensors: vec![],
    };
    invalid(phase_resonance(&prescribed, 1.0, &settings, None));
    assert!(forced_response(system.clone(), -1.0, &[0.0], &settings).is_err());
    assert!(forced_response(system, 1.0, &[1.0; 99], &settings).is_err());
}
