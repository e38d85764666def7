//! Characteristic solution against finite elements, and the laws both must obey.

use std::f64::consts::TAU;

use proptest::prelude::*;
use stickslip::model::{Beam, PointMass};
use stickslip::system::ModalBeam;
use stickslip::system::beam::{BeamModes, FiniteElementModes};

use crate::common::beam::{frictional_support, mass_of, steel};

/// Integral over the beam by Simpson's rule between the masses, where the modes are smooth.
fn integrate(beam: &Beam, function: impl Fn(f64) -> f64) -> f64 {
    let mut breaks: Vec<f64> = beam.point_masses.iter().map(|point| point.position).collect();
    breaks.extend([0.0, beam.length]);
    breaks.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for ends in breaks.windows(2) {
        let pieces = 200;
        let step = (ends[1] - ends[0]) / f64::from(pieces);
        for point in 0..=pieces {
            let weight = match point {
                0 => 1.0,
                _ if point == pieces => 1.0,
                _ if point % 2 == 1 => 4.0,
                _ => 2.0,
            };
            sum += weight * step / 3.0 * function(ends[0] + f64::from(point) * step);
        }
    }
    sum
}

#[test]
fn characteristic_and_finite_element_frequencies_agree_to_a_millihertz() {
    let soft_clamp = Beam { clamp_stiffness: Some(2e3), ..frictional_support(125.4) };
    for beam in [frictional_support(197.4), soft_clamp] {
        let exact = BeamModes::new(&beam, 4).unwrap();
        let elements = FiniteElementModes::new(&beam, 60, 4).unwrap();
        for (mode, (a, b)) in exact.angular_frequency().iter().zip(elements.angular_frequency()).enumerate() {
            assert!((a - b).abs() < 1e-3 * TAU, "mode {}: {} {} Hz", mode + 1, a / TAU, b / TAU);
            // The elements are a Ritz method: never below.
            assert!(b - a > -1e-9 * a);
        }
    }
}

#[test]
fn finite_elements_converge_to_the_exact_solution_with_the_fourth_power() {
    let beam = frictional_support(197.4);
    let exact = BeamModes::new(&beam, 3).unwrap().angular_frequency()[2];
    // 12 and 24 elements of 50 and 25 mm: the masses are on nodes of both.
    let error =
        |elements| FiniteElementModes::new(&beam, elements, 3).unwrap().angular_frequency()[2] / exact - 1.0;
    let order = (error(12) / error(24)).log2();
    assert!((order - 4.0).abs() < 0.1, "{order}");
}

#[test]
fn characteristic_and_finite_element_shapes_agree() {
    let beam = frictional_support(73.6);
    let exact = BeamModes::new(&beam, 4).unwrap();
    let elements = FiniteElementModes::new(&beam, 60, 4).unwrap();
    for mode in 0..4 {
        for x in [0.0, 0.05, 0.1, 0.283, 0.3, 0.55, 0.5999, 0.6] {
            let (a, b) = (exact.displacement(mode, x).unwrap(), elements.displacement(mode, x).unwrap());
            assert!((a - b).abs() < 1e-5, "mode {mode} at {x}: {a} {b}");
            let (a, b) = (exact.slope(mode, x).unwrap(), elements.slope(mode, x).unwrap());
            assert!((a - b).abs() < 1e-2, "slope of mode {mode} at {x}: {a} {b}");
        }
    }
    for (a, b) in exact.shortening().iter().zip(elements.shortening()) {
        assert!((a - b).abs() < 2e-5 * exact.shortening()[0], "{a} {b}");
    }
}

#[test]
fn modes_are_orthonormal_with_the_point_masses() {
    for beam in [steel(), frictional_support(58.7), Beam { clamp_stiffness: Some(300.0), ..steel() }] {
        let modes = BeamModes::new(&beam, 8).unwrap();
        let shape = |mode, x| modes.displacement(mode, x).unwrap();
        for i in 0..8 {
            for j in 0..=i {
                let distributed =
                    mass_of(&beam) / beam.length * integrate(&beam, |x| shape(i, x) * shape(j, x));
                let points: f64 = beam
                    .point_masses
                    .iter()
                    .map(|p| p.mass * shape(i, p.position) * shape(j, p.position))
                    .sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((distributed + points - expected).abs() < 1e-7, "{i} {j}: {}", distributed + points);
            }
        }
    }
}

#[test]
fn forty_modes_are_orthogonal_at_the_pin_and_satisfy_the_supports() {
    let beam = steel();
    let modes = BeamModes::new(&beam, 40).unwrap();
    for mode in 0..40 {
        assert_eq!(modes.displacement(mode, beam.length), Some(0.0));
        assert_eq!(modes.displacement(mode, 0.0), Some(0.0));
        assert_eq!(modes.slope(mode, 0.0), Some(0.0));
        assert!(modes.slope(mode, beam.length).unwrap() > 0.0);
    }
    assert_eq!(modes.displacement(40, 0.3), None);
}

#[test]
fn stiffness_energy_of_a_mode_is_its_squared_frequency() {
    // Eq. A7: ∫ EI φᵢ''φⱼ'' dx + k_θ φᵢ'(L) φⱼ'(L) = ωᵢ² δᵢⱼ, curvature by differences of the slope.
    let beam = frictional_support(167.1);
    let modes = BeamModes::new(&beam, 4).unwrap();
    let h = 1e-6;
    let curvature = |mode, x: f64| {
        let (left, right) = ((x - h).max(0.0), (x + h).min(beam.length));
        (modes.slope(mode, right).unwrap() - modes.slope(mode, left).unwrap()) / (right - left)
    };
    let tip: Vec<f64> = modes.tip_slopes().collect();
    let omega = modes.angular_frequency();
    for i in 0..4 {
        for j in 0..=i {
            let bending = crate::common::beam::bending_stiffness(&beam)
                * integrate(&beam, |x| curvature(i, x) * curvature(j, x));
            let energy = (bending + beam.rotational_stiffness * tip[i] * tip[j]) / (omega[i] * omega[j]);
            assert!((energy - f64::from(u8::from(i == j))).abs() < 1e-4, "{i} {j}: {energy}");
        }
    }
}

#[test]
fn shortening_is_the_integral_of_slope_products_symmetric_and_positive_definite() {
    let beam = Beam { modes: 12, ..steel() };
    let modes = BeamModes::new(&beam, 12).unwrap();
    let modal = ModalBeam::new(&beam).unwrap();
    let matrix = nalgebra::DMatrix::from_row_slice(12, 12, &modal.shortening);
    assert_eq!(matrix, matrix.transpose());
    assert!(nalgebra::Cholesky::new(matrix.clone()).is_some());
    for (i, j) in [(0, 0), (1, 0), (3, 2), (5, 5), (4, 1)] {
        let integral = integrate(&beam, |x| modes.slope(i, x).unwrap() * modes.slope(j, x).unwrap());
        let size = (matrix[(i, i)] * matrix[(j, j)]).sqrt();
        assert!((matrix[(i, j)] - integral).abs() < 1e-6 * size, "{i} {j}: {} {integral}", matrix[(i, j)]);
    }
    // More modes refine the division of the beam; the integrals must not notice.
    let finer = ModalBeam::new(&Beam { modes: 40, ..steel() }).unwrap();
    for i in 0..12 {
        for j in 0..12 {
            let size = (matrix[(i, i)] * matrix[(j, j)]).sqrt();
            assert!((finer.shortening[40 * i + j] - matrix[(i, j)]).abs() < 1e-11 * size, "{i} {j}");
        }
    }
}

#[test]
fn modal_beam_is_the_modes_at_its_places() {
    let beam = Beam { rotational_stiffness: 100.0, offset: -0.004, ..steel() };
    let modes = BeamModes::new(&beam, 6).unwrap();
    let modal = ModalBeam::new(&beam).unwrap();
    assert_eq!(modal.angular_frequency, modes.angular_frequency());
    for mode in 0..6 {
        let slope = modes.slope(mode, beam.length).unwrap();
        assert_eq!(modal.contact_shape[mode], -0.004 * slope);
        assert_eq!(modal.excitation_shape[mode], modes.displacement(mode, 0.55).unwrap());
        for (sensor, x) in modal.sensors.iter().zip([0.55, 0.3, 0.1]) {
            assert_eq!((sensor.position, sensor.shape[mode]), (x, modes.displacement(mode, x).unwrap()));
        }
    }
    let stiffness = 197e9 * 0.04 * 0.005 / 0.6;
    assert!((modal.axial_flexibility * stiffness - 1.0).abs() < 1e-14);
    let positions: Vec<f64> = ModalBeam::new(&Beam { sensors: vec![], ..beam })
        .unwrap()
        .sensors
        .iter()
        .map(|s| s.position)
        .collect();
    assert_eq!(positions, [0.2, 0.47]);
}

prop_compose! {
    fn any_beam()(
        masses in proptest::collection::vec((0.0..=1.0_f64, -3.0..0.5_f64), 0..5),
        length in 0.1..3.0_f64,
        spring in proptest::option::of(-1.0..4.0_f64),
        clamp in proptest::option::of(0.0..5.0_f64),
    ) -> Beam {
        let bare = Beam { length, ..crate::common::beam::bare() };
        Beam {
            point_masses: masses
                .into_iter()
                .map(|(position, size)| PointMass {
                    position: position * length,
                    mass: 10_f64.powf(size) * mass_of(&bare),
                })
                .collect(),
            rotational_stiffness: spring.map_or(0.0, |size| 10_f64.powf(size)),
            clamp_stiffness: clamp.map(|size| 10_f64.powf(size)),
            excitation_position: 0.0,
            sensors: vec![],
            contact_points: vec![],
            ..bare
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mode_is_missed_on_any_beam(beam in any_beam()) {
        let exact = BeamModes::new(&beam, 6).unwrap();
        let elements = FiniteElementModes::new(&beam, 48, 6).unwrap();
        for (mode, (a, b)) in exact.angular_frequency().iter().zip(elements.angular_frequency()).enumerate() {
            // The elements' own error grows with the mode and stays above zero.
            prop_assert!(b / a > 1.0 - 1e-7 && b / a < 1.0 + 2e-3, "mode {}: {} {}", mode + 1, a, b);
        }
    }

    #[test]
    fn frequencies_fall_with_mass_and_rise_with_support_stiffness(
        beam in any_beam(), place in 0.05..0.95_f64, mass in 0.001..1.0_f64, factor in 1.01..10.0_f64,
    ) {
        let before = BeamModes::new(&beam, 8).unwrap();
        let mut heavier = beam.clone();
        heavier.point_masses.push(PointMass { position: place * beam.length, mass });
        let stiffer = Beam { rotational_stiffness: factor * beam.rotational_stiffness + 1.0, ..beam.clone() };
        let heavier = BeamModes::new(&heavier, 8).unwrap();
        let stiffer = BeamModes::new(&stiffer, 8).unwrap();
        for mode in 0..8 {
            let [low, middle, high] = [&heavier, &before, &stiffer].map(|modes| modes.angular_frequency()[mode]);
            prop_assert!(low <= middle * (1.0 + 1e-12) && middle <= high * (1.0 + 1e-12), "{low} {middle} {high}");
        }
        prop_assert!(before.angular_frequency()[0] < stiffer.angular_frequency()[0]);
        prop_assert!(heavier.angular_frequency()[0] < before.angular_frequency()[0]);
        // Cauchy: one mass more and the frequencies interlace.
        for mode in 1..8 {
            let above = heavier.angular_frequency()[mode];
            prop_assert!(above >= before.angular_frequency()[mode - 1] * (1.0 - 1e-12));
        }
    }

    #[test]
    fn modes_have_unit_mass_and_one_node_more_each(beam in any_beam()) {
        let modes = BeamModes::new(&beam, 12).unwrap();
        for mode in 0..12 {
            let shape = |x: f64| modes.displacement(mode, x).unwrap();
            let points: f64 = beam.point_masses.iter().map(|p| p.mass * shape(p.position).powi(2)).sum();
            let distributed = mass_of(&beam) / beam.length * integrate(&beam, |x| shape(x).powi(2));
            prop_assert!((distributed + points - 1.0).abs() < 1e-5, "{}", distributed + points);
            // The oscillation theorem of Gantmacher and Krein: mode n changes sign n − 1 times.
            let samples: Vec<f64> = (1..1000).map(|k| shape(f64::from(k) / 1000.0 * beam.length)).collect();
            let changes = samples.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
            prop_assert_eq!(changes, mode);
        }
    }
}
