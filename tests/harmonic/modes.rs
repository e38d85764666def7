//! Nonlinear modes against closed forms: linear structures, the Duffing oscillator, Jenkins' element under
//! equivalent linearisation, and the two-mass system with friction between its stuck and its sliding limit.

use std::f64::consts::PI;

use stickslip::contact::{ContactLaw, CubicSpring, Jenkins};
use stickslip::harmonic::{
    CurveSettings, HarmonicError, ModeRange, NonlinearMode, TrackedQuantity, Tracking, nonlinear_mode,
    track_levels,
};
use stickslip::system::LinearStructure;

use crate::common::oscillator::{in_contact, settings, single, two_masses};

/// The mode under one law, with so many harmonics.
fn mode(
    structure: &LinearStructure,
    law: impl ContactLaw + 'static,
    range: &ModeRange,
    harmonics: usize,
) -> NonlinearMode {
    let assembly = in_contact(structure, law);
    let settings = settings(harmonics);
    nonlinear_mode(&assembly, range, &settings, &mut |_| true).unwrap()
}

#[test]
fn a_linear_structure_has_its_natural_frequency_and_damping_ratio_at_every_amplitude() {
    let structure = two_masses(0.1);
    let spring = CubicSpring::new(0.2, 0.0).unwrap();
    // Damping in proportion to mass: the damped modes are the undamped ones, ζ = c/(2 m ω).
    // K = [[1.5, −0.5], [−0.5, 0.7]] with the spring of the contact.
    let radius = (0.4_f64.powi(2) + 0.5_f64.powi(2)).sqrt();
    for (number, square) in [1.1 - radius, 1.1 + radius].into_iter().enumerate() {
        let omega = square.sqrt();
        let range = ModeRange { mode: number, node: 0, amplitudes: [1e-4, 1e3], points: 8 };
        let mode = mode(&structure, spring, &range, 3);
        assert!((mode.angular_frequency / omega - 1.0).abs() < 1e-12, "{}", mode.angular_frequency);
        for point in &mode.points {
            assert!((point.angular_frequency / mode.angular_frequency - 1.0).abs() < 1e-9);
            assert!((point.damping_ratio - 0.05 / point.angular_frequency).abs() < 1e-9);
            assert!((point.point.amplitude[0] / point.amplitude - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn duffing_backbone_of_one_harmonic_is_three_quarters_of_the_cubic() {
    let structure = single(1.0, 0.03, 2.0, 1);
    for cubic in [0.7, -0.3] {
        let law = CubicSpring::new(0.0, cubic).unwrap();
        let range = ModeRange { mode: 0, node: 0, amplitudes: [1e-3, 1.5], points: 15 };
        for point in mode(&structure, law, &range, 1).points {
            let square = 2.0 + 0.75 * cubic * point.amplitude.powi(2);
            assert!((point.angular_frequency / square.sqrt() - 1.0).abs() < 1e-9);
            assert!((2.0 * point.damping_ratio * point.angular_frequency - 0.03).abs() < 1e-9);
        }
    }
}

#[test]
fn duffing_backbone_of_many_harmonics_is_the_elliptic_integral() {
    let structure = single(1.0, 0.0, 1.0, 1);
    for cubic in [1.0, -0.1] {
        let law = CubicSpring::new(0.0, cubic).unwrap();
        let range = ModeRange { mode: 0, node: 0, amplitudes: [0.01, 2.0], points: 12 };
        for point in mode(&structure, law, &range, 25).points {
            let exact = duffing_frequency(1.0, cubic, point.point.amplitude[0]);
            let error = (point.angular_frequency / exact - 1.0).abs();
            assert!(error < 1e-8, "{cubic} {}: {error:.1e}", point.amplitude);
            assert!(point.damping_ratio.abs() < 1e-9);
        }
    }
}

/// `ẍ + α x + β x³ = 0` of amplitude X: `ω = π √(α + β X²)/(2 K(m))`, `m = β X²/(2 (α + β X²))`, with the
/// complete elliptic integral as an arithmetic-geometric mean, `K(m) = π/(2 agm(1, √(1 − m)))`.
fn duffing_frequency(linear: f64, cubic: f64, amplitude: f64) -> f64 {
    let square = linear + cubic * amplitude * amplitude;
    let (mut a, mut g) = (1.0, (1.0 - 0.5 * cubic * amplitude * amplitude / square).sqrt());
    for _ in 0..20 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    square.sqrt() * a
}

/// Describing function of Jenkins' element: real and imaginary stiffness at an amplitude.
fn jenkins_stiffness(stiffness: f64, limit: f64, amplitude: f64) -> [f64; 2] {
    if stiffness * amplitude <= limit {
        return [stiffness, 0.0];
    }
    // Phase from the reversal to the onset of slip.
    let phase = (1.0 - 2.0 * limit / (stiffness * amplitude)).acos();
    let lost = 4.0 * limit * (amplitude - limit / stiffness);
    [stiffness / PI * (phase - 0.5 * (2.0 * phase).sin()), lost / (PI * amplitude * amplitude)]
}

#[test]
fn one_harmonic_mode_of_a_jenkins_element_is_its_describing_function() {
    let (stiffness, damping, contact, limit) = (1.0, 0.02, 0.4, 0.1);
    let structure = single(1.0, damping, stiffness, 1);
    let law = Jenkins::new(contact, limit).unwrap();
    let range = ModeRange { mode: 0, node: 0, amplitudes: [1e-3, 1e3], points: 41 };
    for point in mode(&structure, law, &range, 1).points {
        let [real, imaginary] = jenkins_stiffness(contact, limit, point.amplitude);
        let omega = (stiffness + real).sqrt();
        let zeta = (damping * omega + imaginary) / (2.0 * omega * omega);
        assert!((point.angular_frequency / omega - 1.0).abs() < 1e-8, "a = {}", point.amplitude);
        assert!((point.damping_ratio / zeta - 1.0).abs() < 1e-7, "a = {}", point.amplitude);
    }
}

#[test]
fn damping_ratio_is_the_energy_lost_over_4_pi_times_the_kinetic_energy() {
    let (damping, limit) = (0.02, 0.1);
    let structure = single(1.0, damping, 1.0, 1);
    let law = Jenkins::new(0.4, limit).unwrap();
    let range = ModeRange { mode: 0, node: 0, amplitudes: [1e-2, 1e2], points: 15 };
    for point in mode(&structure, law, &range, 31).points {
        // ∮ q̇² dt = π Ω Σ k² a_k²: the artificial damping gives 2 ζ Ω times it, the damper takes c times it.
        let coefficients = &point.point.nodes[0];
        let squares: f64 = (1..coefficients.len())
            .map(|place| (place.div_ceil(2) as f64 * coefficients[place]).powi(2))
            .sum();
        let (omega, zeta) = (point.angular_frequency, point.damping_ratio);
        let lost = point.dissipated_energy + damping * PI * omega * squares;
        let kinetic = 0.5 * omega * omega * squares;
        assert!((lost / (4.0 * PI * kinetic * zeta) - 1.0).abs() < 1e-5, "a = {}", point.amplitude);
    }
}

#[test]
fn two_mass_modes_go_from_stuck_to_free_sliding() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    for (number, stuck, free) in [(0, 0.6780026, 0.5411961), (1, 1.3192090, 1.3065630)] {
        let range = ModeRange { mode: number, node: 1, amplitudes: [1e-3, 1e4], points: 71 };
        let mode = mode(&structure, law, &range, 9);
        let (first, last) = (&mode.points[0], &mode.points[70]);
        assert!((first.angular_frequency - stuck).abs() < 1e-7, "{}", first.angular_frequency);
        assert!((last.angular_frequency - free).abs() < 1e-6, "{}", last.angular_frequency);
        for point in [first, last] {
            assert!((point.damping_ratio * point.angular_frequency - 0.05).abs() < 1e-5);
        }
        // Between them friction damps, and the frequency falls all the way.
        let most = mode.points.iter().map(|p| p.damping_ratio * p.angular_frequency).fold(0.0, f64::max);
        assert!(most > 0.053, "{most}");
        for pair in mode.points.windows(2) {
            assert!(pair[1].angular_frequency < pair[0].angular_frequency + 1e-9);
        }
    }
}

#[test]
fn lightly_damped_resonances_lie_on_the_mode() {
    let structure = two_masses(0.002);
    let law = Jenkins::new(0.02, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    let settings = settings(9);
    let tracking = Tracking { quantity: TrackedQuantity::Phase, node: 0, angular_frequency: 0.5554 };
    let levels: Vec<f64> = (0..12).map(|k| 1e-3 * 1.6_f64.powi(k)).collect();
    let resonances = track_levels(&assembly, &tracking, &levels, &settings, &mut |_| true).unwrap().points;
    let mut frequencies = Vec::new();
    for resonance in &resonances {
        let amplitude = resonance.first_harmonic()[0];
        let range = ModeRange { mode: 0, node: 0, amplitudes: [1e-2 * amplitude, amplitude], points: 2 };
        let point = nonlinear_mode(&assembly, &range, &settings, &mut |_| true).unwrap().points.remove(1);
        let difference = point.angular_frequency / resonance.angular_frequency - 1.0;
        assert!(difference.abs() < 1e-3, "{amplitude}: {difference:.1e}");
        frequencies.push(point.angular_frequency);
    }
    assert!(frequencies[0] / frequencies[11] > 1.01, "{frequencies:?}");
}

#[test]
fn a_mode_does_not_depend_on_the_way_its_amplitudes_are_walked() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let walk = |amplitudes, points| {
        mode(&structure, law, &ModeRange { mode: 0, node: 1, amplitudes, points }, 9).points
    };
    let (fine, coarse) = (walk([0.01, 10.0], 31), walk([0.01, 10.0], 4));
    for (k, point) in coarse.iter().enumerate() {
        let same = &fine[10 * k];
        assert!((point.amplitude / same.amplitude - 1.0).abs() < 1e-12);
        assert!((point.angular_frequency / same.angular_frequency - 1.0).abs() < 1e-8);
        assert!((point.damping_ratio / same.damping_ratio - 1.0).abs() < 1e-7);
    }
}

#[test]
fn modes_that_are_not_there_are_refused() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    let range = ModeRange { mode: 0, node: 0, amplitudes: [1e-3, 1.0], points: 5 };
    let wrong = [
        ModeRange { mode: 2, ..range },
        ModeRange { node: 2, ..range },
        ModeRange { amplitudes: [0.0, 1.0], ..range },
        ModeRange { amplitudes: [1.0, f64::NAN], ..range },
        ModeRange { points: 0, ..range },
    ];
    for range in wrong {
        let result = nonlinear_mode(&assembly, &range, &CurveSettings::default(), &mut |_| true);
        assert!(matches!(result, Err(HarmonicError::InvalidInput(_))), "{range:?}");
    }
}

#[test]
fn harmonics_grow_until_a_mode_is_resolved() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    let range = ModeRange { mode: 0, node: 1, amplitudes: [0.05, 2.0], points: 5 };
    let settings =
        CurveSettings { harmonics: 1, truncation: Some(1e-3), max_harmonics: 51, ..CurveSettings::default() };
    let found = nonlinear_mode(&assembly, &range, &settings, &mut |_| true).unwrap();
    let exact = mode(&structure, law, &range, 51);
    assert_eq!(found.points.len(), 5);
    for (point, exact) in found.points.iter().zip(&exact.points) {
        assert!(point.point.resolved && point.point.harmonics < 51, "{}", point.point.error_estimate);
        assert!((point.angular_frequency / exact.angular_frequency - 1.0).abs() < 1e-3);
    }
    assert!(found.points.iter().any(|point| point.point.harmonics > 1));
}
