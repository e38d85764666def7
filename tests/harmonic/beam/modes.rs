//! Nonlinear modes of the beam with its frictional support, and its resonances followed over the contact's parameters,
//! against the published beam's reference frequencies, closed forms and independent solutions.

use std::f64::consts::TAU;

use stickslip::contact::{ContactLaw, CubicSpring, LawError, Valanis};
use stickslip::harmonic::{
    Assembly, AssemblyAt, Control, CurveSettings, Ending, ModeRange, NonlinearMode, TrackedQuantity,
    Tracking, nonlinear_mode, parameter_response, periodic_response, phase_resonance, track_levels,
    track_parameter,
};
use stickslip::system::ModalBeam;

use crate::common::beam::published;
use crate::common::contact::{LOAD, loaded};

fn assembly(beam: &ModalBeam, law: impl ContactLaw + 'static, normal_load: f64) -> Assembly {
    Assembly::new(beam.system(loaded(law, normal_load)).unwrap())
}

fn settings(harmonics: usize) -> CurveSettings {
    CurveSettings { harmonics, tolerance: 1e-9, ..CurveSettings::default() }
}

/// Table 3 of the publication, with another coefficient of friction.
fn valanis(friction: f64) -> Result<Valanis, LawError> {
    Valanis::new(7.9e6, friction, 0.3, 0.0)
}

/// T∞ = e0/λ.
const FRICTION: f64 = 7.9e6 / 8.7e4 / LOAD;

fn mode(
    beam: &ModalBeam,
    law: impl ContactLaw + 'static,
    number: usize,
    ends: [f64; 2],
    harmonics: usize,
) -> NonlinearMode {
    let range = ModeRange { mode: number, node: beam.sensors.len(), amplitudes: ends, points: 60 };
    let mode =
        nonlinear_mode(&assembly(beam, law, LOAD), &range, &settings(harmonics), &mut |_| true).unwrap();
    assert_eq!(mode.lost, None);
    mode
}

#[test]
fn a_beam_on_a_spring_has_its_natural_frequency_and_damping_ratio() {
    // Two modes coupled by the spring: the frequencies of [[ω₁² + k c₁², k c₁ c₂], [·, ω₂² + k c₂²]].
    let beam = ModalBeam { shortening: vec![0.0; 4], ..published(2) };
    let spring = CubicSpring::new(7.9e6, 0.0).unwrap();
    let behind = 7.9e6 / (1.0 + 7.9e6 * beam.axial_flexibility);
    let (c, w) = (&beam.contact_shape, &beam.angular_frequency);
    let (a, b) = (w[0] * w[0] + behind * c[0] * c[0], w[1] * w[1] + behind * c[1] * c[1]);
    let radius = (0.25 * (a - b).powi(2) + (behind * c[0] * c[1]).powi(2)).sqrt();
    for (number, square) in [0.5 * (a + b) - radius, 0.5 * (a + b) + radius].into_iter().enumerate() {
        let mode = mode(&beam, spring, number, [1e-6, 1e-3], 3);
        assert!((mode.angular_frequency / square.sqrt() - 1.0).abs() < 1e-12);
        for point in &mode.points {
            // The modes' dampers couple the mode of the beam on its spring with the other: of second order.
            assert!(
                (point.angular_frequency / square.sqrt() - 1.0).abs() < 2e-5,
                "{}",
                point.angular_frequency
            );
            assert!(point.damping_ratio > 0.0 && point.damping_ratio < 0.0031, "{}", point.damping_ratio);
            assert!(point.dissipated_energy.abs() < 1e-12);
        }
    }
}

#[test]
fn the_backbone_of_the_published_beam_has_the_reference_frequencies() {
    // Phase resonance at so many m/s² held (Hz): four modes, five harmonics.
    let reference = [
        (0.5, 54.04),
        (10.0, 53.29),
        (20.0, 51.64),
        (30.0, 50.60),
        (40.0, 50.07),
        (50.0, 49.76),
        (60.0, 49.55),
        (70.0, 49.41),
    ];
    let (beam, law) = (published(4), valanis(FRICTION).unwrap());
    let ends = [0.4 / (TAU * 54.0).powi(2), 75.0 / (TAU * 49.4).powi(2)];
    let mode = mode(&beam, law, 0, ends, 5);
    let along: Vec<(f64, f64, f64)> = mode
        .points
        .iter()
        .map(|point| {
            (
                point.amplitude * point.angular_frequency.powi(2),
                point.angular_frequency / TAU,
                point.damping_ratio,
            )
        })
        .collect();
    for (acceleration, frequency) in reference {
        let pair =
            along.windows(2).find(|pair| pair[0].0 <= acceleration && acceleration <= pair[1].0).unwrap();
        let fraction = (acceleration / pair[0].0).ln() / (pair[1].0 / pair[0].0).ln();
        let found = pair[0].1 + fraction * (pair[1].1 - pair[0].1);
        // Forced, the other modes answer to what the contact's damping asks of them: of second order in it.
        let damping = pair[0].2.max(pair[1].2);
        let slack = 0.02 + 3.0 * damping * damping * frequency;
        assert!((found - frequency).abs() < slack, "{acceleration} m/s²: {found:.3} Hz, {frequency}");
    }
    // From the modal damping up by friction, and down again once the contact slips freely.
    let damping: Vec<f64> = mode.points.iter().map(|point| point.damping_ratio).collect();
    let largest = damping.iter().copied().fold(0.0, f64::max);
    assert!(damping[0] < 0.006 && largest > 0.03 && damping[59] < 0.9 * largest, "{damping:?}");
}

#[test]
fn with_one_mode_and_one_harmonic_the_backbone_is_phase_resonance() {
    // The damping that sustains the vibration then is a force in phase with the velocity where it acts.
    let (beam, law) = (published(1), valanis(FRICTION).unwrap());
    let balance = CurveSettings { harmonics: 1, ..CurveSettings::default() };
    let contact = loaded(law, LOAD);
    for acceleration in [2.0, 15.0, 60.0] {
        let forced =
            phase_resonance(&beam.system(contact.clone()).unwrap(), acceleration, &balance, None).unwrap();
        let amplitude = acceleration / forced.angular_frequency.powi(2);
        let mode = mode(&beam, law, 0, [1e-7, amplitude], 1);
        let last = &mode.points[mode.points.len() - 1];
        assert!((last.angular_frequency / forced.angular_frequency - 1.0).abs() < 1e-8);
        assert!((last.damping_ratio / forced.damping_ratio() - 1.0).abs() < 1e-6);
        assert!((last.dissipated_energy / forced.dissipated_energy - 1.0).abs() < 1e-7);
    }
}

#[test]
fn resonances_of_the_beam_are_followed_over_friction_and_load() {
    let beam = published(4);
    let node = beam.sensors.len();
    let tracking = Tracking { quantity: TrackedQuantity::Phase, node, angular_frequency: TAU * 51.0 };
    let friction = [FRICTION, 0.8 * FRICTION, 0.5 * FRICTION];
    let over_friction = |friction: f64| Ok(assembly(&beam, valanis(friction)?, LOAD));
    let over_load = |load: f64| Ok(assembly(&beam, valanis(FRICTION)?, load));
    let loads: Vec<f64> = friction.iter().map(|mu| LOAD * mu / FRICTION).collect();
    let track = |over: &AssemblyAt, values: &[f64]| {
        track_parameter(over, 8.0, &tracking, values, &settings(5), &mut |_| true).unwrap().points
    };
    let (by_friction, by_load) = (track(&over_friction, &friction), track(&over_load, &loads));
    assert_eq!((by_friction.len(), by_load.len()), (3, 3));
    let mut last = f64::INFINITY;
    for ((by_friction, by_load), friction) in by_friction.iter().zip(&by_load).zip(friction) {
        let alone = valanis(friction).unwrap();
        let alone = assembly(&beam, alone, LOAD);
        let start = Tracking { angular_frequency: by_friction.angular_frequency * 1.002, ..tracking };
        let expected = track_levels(&alone, &start, &[8.0], &settings(5), &mut |_| true).unwrap();
        let expected = &expected.points[0];
        for found in [by_friction, by_load] {
            let ratio = found.angular_frequency / expected.angular_frequency;
            assert!((ratio - 1.0).abs() < 1e-8, "{ratio}");
            let ratio = found.amplitude[node] / expected.amplitude[node];
            assert!((ratio - 1.0).abs() < 1e-7);
        }
        // Less friction is less stiffness.
        assert!(expected.angular_frequency < last);
        last = expected.angular_frequency;
    }
}

#[test]
fn responses_of_the_beam_over_friction_are_those_of_each_friction_alone() {
    let beam = published(3);
    let contacts = |friction: f64| Ok(assembly(&beam, valanis(friction)?, LOAD));
    let (omega, range) = (TAU * 50.5, [FRICTION, 0.3 * FRICTION]);
    let curve = parameter_response(&contacts, omega, 6.0, range, &settings(5), &mut |_| true).unwrap();
    assert_eq!(curve.ending, Ending::Complete);
    for varied in curve.points.iter().step_by(8).chain(curve.points.last()) {
        let alone = valanis(varied.parameter).unwrap();
        let control = Control::Level(6.0);
        let alone = assembly(&beam, alone, LOAD);
        let start = Some(varied);
        let expected = periodic_response(&alone, omega, &control, &settings(5), start).unwrap();
        for (found, expected) in varied.amplitude.iter().zip(&expected.amplitude) {
            assert!((found / expected - 1.0).abs() < 1e-7, "{}: {found} {expected}", varied.parameter);
        }
    }
}
