//! The characteristic solution against the closed forms of textbooks (Blevins, Formulas for Natural
//! Frequency and Mode Shape, table 8-1) and against transcendental equations written out here.

use stickslip::model::PointMass;
use stickslip::system::beam::BeamModes;
use stickslip::system::tip_rotational_compliance;

use crate::common::beam::{bare, bisect, frequency_scale, mass_of, steel};

/// βL of the first modes.
fn wave_numbers(beam: &stickslip::model::Beam, count: usize) -> Vec<f64> {
    let modes = BeamModes::new(beam, count).unwrap();
    modes.angular_frequency().iter().map(|omega| (omega / frequency_scale(beam)).sqrt()).collect()
}

fn assert_roots(found: &[f64], expected: impl IntoIterator<Item = f64>, tolerance: f64) {
    for (mode, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < tolerance * expected, "mode {}: {found} {expected}", mode + 1);
    }
}

#[test]
fn clamped_pinned_roots_of_tan_equal_tanh_to_40_modes() {
    let roots: Vec<f64> = (1..=40)
        .map(|mode| {
            // tan β = tanh β, written without the poles of the tangent.
            let middle = (f64::from(mode) + 0.25) * std::f64::consts::PI;
            bisect(|b| b.sin() - b.tanh() * b.cos(), middle - 0.5, middle + 0.5)
        })
        .collect();
    assert!((roots[0] - 3.926602).abs() < 1e-6 && (roots[1] - 7.068583).abs() < 1e-6);
    assert_roots(&wave_numbers(&bare(), 40), roots, 1e-13);
}

#[test]
fn rigid_spring_at_the_pin_gives_clamped_clamped_roots() {
    let beam = stickslip::model::Beam { rotational_stiffness: 1e15, ..bare() };
    assert_roots(&wave_numbers(&beam, 4), [4.730041, 7.853205, 10.995608, 14.137165], 2e-7);
}

#[test]
fn slope_left_by_a_stiff_spring_is_the_clamping_moment_over_its_stiffness() {
    // Clamped–clamped: EI φ''(L) = 2 EI β² / √(ρAL), the deflection's mean square being one.
    for stiffness in [1e8, 1e12, 1e16] {
        let beam = stickslip::model::Beam { rotational_stiffness: stiffness, ..bare() };
        let modes = BeamModes::new(&beam, 5).unwrap();
        for (slope, omega) in modes.tip_slopes().zip(modes.angular_frequency()) {
            let curvature =
                2.0 * omega / frequency_scale(&beam) / beam.length.powi(2) / mass_of(&beam).sqrt();
            let expected = crate::common::beam::bending_stiffness(&beam) * curvature / stiffness;
            assert!((slope / expected - 1.0).abs() < 1e-4, "{stiffness}: {slope} {expected}");
        }
    }
}

#[test]
fn vanishing_clamp_stiffness_gives_pinned_pinned_multiples_of_pi() {
    let beam = stickslip::model::Beam { clamp_stiffness: Some(1e-9), ..bare() };
    assert_roots(&wave_numbers(&beam, 20), (1..=20).map(|n| f64::from(n) * std::f64::consts::PI), 1e-10);
}

#[test]
fn stiff_clamp_spring_approaches_the_rigid_clamp() {
    let rigid = wave_numbers(&bare(), 6);
    let spring = wave_numbers(&stickslip::model::Beam { clamp_stiffness: Some(1e12), ..bare() }, 6);
    assert_roots(&spring, rigid, 1e-8);
}

#[test]
fn rotational_spring_at_the_pin_obeys_its_transcendental_equation() {
    let beam = stickslip::model::Beam { rotational_stiffness: 197.4, ..bare() };
    let spring = 197.4 * beam.length / crate::common::beam::bending_stiffness(&beam);
    // Clamped: w = A (cosh − cos) + B (sinh − sin); w(1) = 0 and w''(1) = −spring w'(1).
    let equation = |b: f64| {
        let (c, s, ch, sh) = (b.cos(), b.sin(), b.cosh(), b.sinh());
        (ch - c) * (b * (sh + s) + spring * (ch - c)) - (sh - s) * (b * (ch + c) + spring * (sh + s))
    };
    let roots = [(3.9, 4.74), (7.05, 7.86), (10.2, 11.0)].map(|(low, high)| bisect(equation, low, high));
    assert_roots(&wave_numbers(&beam, 3), roots, 1e-12);
}

#[test]
fn mass_at_mid_span_of_a_pinned_beam_obeys_its_transcendental_equation() {
    let mass = 0.7;
    let mut beam = stickslip::model::Beam { clamp_stiffness: Some(1e-9), ..bare() };
    beam.point_masses = vec![PointMass { position: beam.length / 2.0, mass }];
    let ratio = mass / mass_of(&beam);
    // Symmetric modes: 4 = (m/ρAL) βL [tan(βL/2) − tanh(βL/2)], from two halves level at the middle whose
    // shears carry the mass; antisymmetric modes keep the mass at rest and are those without it.
    let symmetric = |b: f64| {
        let h = b / 2.0;
        4.0 * h.cos() - ratio * b * (h.sin() - h.tanh() * h.cos())
    };
    let pi = std::f64::consts::PI;
    let found = wave_numbers(&beam, 4);
    let expected = [bisect(symmetric, 0.5, pi), 2.0 * pi, bisect(symmetric, 2.0 * pi, 3.0 * pi), 4.0 * pi];
    assert_roots(&found, expected, 1e-9);
    // Rayleigh's quotient with the static shape, 48 EI/L³ on m + 17/35 ρAL, is 0.1 % high at most.
    let rayleigh = (48.0 / (ratio + 17.0 / 35.0)).powf(0.25);
    assert!(found[0] < rayleigh && rayleigh < 1.001 * found[0]);
}

#[test]
fn very_heavy_mass_vibrates_on_the_static_stiffness() {
    // Clamped–pinned, mass at a: flexibility a³ (L−a)² (4L − a) / (12 EI L³).
    for mass in [1e3, 1e6] {
        let mut beam = bare();
        let position = 0.4;
        beam.point_masses = vec![PointMass { position, mass }];
        let length = beam.length;
        let flexibility =
            position.powi(3) * (length - position).powi(2) * (3.0 * length + (length - position))
                / (12.0 * crate::common::beam::bending_stiffness(&beam) * length.powi(3));
        let omega = BeamModes::new(&beam, 1).unwrap().angular_frequency()[0];
        assert!((omega * omega * flexibility * mass - 1.0).abs() < 2.0 / mass, "{omega}");
    }
}

#[test]
fn masses_at_the_ends_and_on_one_another_are_what_they_should_be() {
    let mut apart = steel();
    apart.point_masses = vec![
        PointMass { position: 0.2, mass: 0.03 },
        PointMass { position: 0.2, mass: 0.02 },
        PointMass { position: 0.0, mass: 5.0 },
        PointMass { position: apart.length, mass: 5.0 },
    ];
    let mut together = steel();
    together.point_masses = vec![PointMass { position: 0.2, mass: 0.05 }];
    assert_roots(&wave_numbers(&apart, 8), wave_numbers(&together, 8), 1e-14);
    // Nearly on one another, down to a nanometre: the frequencies depend continuously on the distance.
    for distance in [1e-9, 1e-7, 1e-5] {
        apart.point_masses[1].position = 0.2 + distance;
        assert_roots(&wave_numbers(&apart, 8), wave_numbers(&together, 8), 10.0 * distance + 1e-13);
    }
}

#[test]
fn modal_compliance_to_an_end_moment_converges_to_the_static_one() {
    let beam = bare();
    let exact = beam.length / (4.0 * crate::common::beam::bending_stiffness(&beam));
    assert!((tip_rotational_compliance(&beam).unwrap() / exact - 1.0).abs() < 1e-14);
    let modes = BeamModes::new(&beam, 40).unwrap();
    let terms =
        modes.tip_slopes().zip(modes.angular_frequency()).map(|(slope, omega)| (slope / omega).powi(2));
    let sums: Vec<f64> = terms
        .scan(0.0, |sum, term| {
            *sum += term;
            Some(*sum)
        })
        .collect();
    let missing = |modes: usize| 1.0 - sums[modes - 1] / exact;
    assert!(sums.windows(2).all(|pair| pair[0] < pair[1]));
    // φ' grows like β and ω² like β⁴, so what is missing falls like 1/n.
    assert!(missing(40) > 0.0 && missing(40) < 0.022, "{}", missing(40));
    let order = (missing(20) / missing(40)).log2();
    assert!((order - 1.0).abs() < 0.05, "{order}");
}

#[test]
fn spring_and_masses_do_not_change_the_meaning_of_the_static_compliance() {
    // Masses do not matter at rest; a spring at the pin adds its stiffness to that of the beam's end.
    let loaded = crate::common::beam::frictional_support(197.4);
    let stiffness = 4.0 * crate::common::beam::bending_stiffness(&loaded) / loaded.length + 197.4;
    assert!((tip_rotational_compliance(&loaded).unwrap() * stiffness - 1.0).abs() < 1e-13);
}
