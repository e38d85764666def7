//! The base linear system of the rig that slips and slaps.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use stickslip::identify::{
    ContactStiffness, MeasuredFrequencies, beam_frequencies as own_frequencies, contact_stiffness,
};
use stickslip::system::{FiniteElementRigModes, ModalPinRig, PinRig, PinRigModes};

use crate::common::pin_rig::{model_b, rig, soft_string};

/// The first frequencies (Hz) of the beam's own modes, exact and by 60 finite elements.
fn beam_frequencies(rig: &PinRig) -> [Vec<f64>; 2] {
    let count = 12;
    let exact = PinRigModes::new(rig, count).unwrap();
    let elements = FiniteElementRigModes::new(rig, 60, count).unwrap();
    [
        (exact.angular_frequency(), exact.beam_fraction()),
        (elements.angular_frequency(), elements.beam_fraction()),
    ]
    .map(|(omega, fraction)| {
        let beams = omega.iter().zip(fraction).filter(|(_, fraction)| **fraction > 0.5);
        beams.map(|(omega, _)| omega / TAU).take(3).collect()
    })
}

#[test]
fn frequencies_of_the_beam_are_the_reference_values() {
    let cases = [
        (rig(), [51.0827, 158.8299, 324.3773]),
        (soft_string(), [51.0804, 158.7779, 324.1609]),
        (model_b(), [52.7873, 164.4231, 335.8551]),
    ];
    for (rig, reference) in cases {
        let [exact, elements] = beam_frequencies(&rig);
        for ((exact, elements), reference) in exact.iter().zip(&elements).zip(reference) {
            assert!((exact - reference).abs() < 1e-4, "{exact} Hz is not {reference}");
            assert!((exact - elements).abs() < 1e-3, "{exact} Hz exact, {elements} by elements");
        }
    }
}

#[test]
fn shapes_and_shortening_agree_with_finite_elements() {
    let (rig, count) = (model_b(), 8);
    let exact = PinRigModes::new(&rig, count).unwrap();
    let elements = FiniteElementRigModes::new(&rig, 200, count).unwrap();
    let (own, other) = (exact.shortening(), elements.shortening());
    for mode in 0..count {
        let at = |x: f64| [exact.displacement(mode, x).unwrap(), elements.displacement(mode, x).unwrap()];
        let sign = {
            let [a, b] = at(0.21);
            a.signum() * b.signum()
        };
        let size = (0..=20).map(|k| at(0.03 * f64::from(k))[0].abs()).fold(0.0, f64::max);
        for x in [0.05, 0.21, 0.4, 0.55, 0.6] {
            let [a, b] = at(x);
            assert!((a - sign * b).abs() < 2e-5 * size, "mode {mode} at {x}: {a} {b}");
        }
        let (a, b) = (own[mode * count + mode], other[mode * count + mode]);
        assert!((a / b - 1.0).abs() < 1e-5, "mode {mode}: {a} {b}");
        let (a, b) = (exact.beam_fraction()[mode], elements.beam_fraction()[mode]);
        assert!((a - b).abs() < 1e-5, "mode {mode}: {a} {b}");
    }
}

#[test]
fn pendulum_and_bounce_are_modes_of_the_rig_and_not_of_the_beam() {
    let modes = PinRigModes::new(&soft_string(), 5).unwrap();
    let fraction = modes.beam_fraction();
    assert_eq!(modes.beam_modes().len(), 3);
    let others: Vec<f64> =
        (0..5).filter(|mode| fraction[*mode] < 0.5).map(|mode| modes.angular_frequency()[mode]).collect();
    // Two modes: the mass swings on its string, and it bounces with √(k/m) where the contact is stiff.
    let bounce = (1e5_f64 / 7.0).sqrt();
    assert_eq!(others.len(), 2);
    assert!((others[1] / bounce - 1.0).abs() < 0.02, "{others:?} {bounce}");
}

#[test]
fn a_mode_count_that_grows_changes_no_mode() {
    let [few, many] = [5, 20].map(|count| PinRigModes::new(&model_b(), count).unwrap());
    assert_eq!(few.angular_frequency(), &many.angular_frequency()[..5]);
}

/// The paper's eq. 7 has the contact's normal force with the sign that pushes the pin on where it goes.
#[test]
fn the_printed_equation_seven_is_unstable() {
    let mut rig = model_b();
    let [_, normal_stiffness] = rig.stuck_stiffness;
    rig.stuck_stiffness[1] = 0.0;
    rig.beam.modes = 40;
    let free = ModalPinRig::new(&rig).unwrap();
    let square: Vec<f64> = free.angular_frequency.iter().map(|omega| omega * omega).collect();
    let normal = DVector::from_column_slice(&free.normal_shape);
    let least = |sign: f64| {
        let stiffness = DMatrix::from_diagonal(&DVector::from_column_slice(&square))
            + sign * normal_stiffness * &normal * normal.transpose();
        SymmetricEigen::new(stiffness).eigenvalues.min()
    };
    assert!(least(1.0) > 0.0);
    // q̈ + λ q = 0 with λ < 0 grows with √−λ.
    let growth = (-least(-1.0)).sqrt();
    assert!((growth / 2.1e4 - 1.0).abs() < 0.05, "{growth} 1/s");
}

/// What three frequencies, each to 0.05 %, and a Young's modulus to 0.5 % tell of the contact of `truth`, from wrong values on.
fn identified(truth: &PinRig, lever: f64) -> ContactStiffness {
    let frequencies = own_frequencies(truth, 3).unwrap();
    let mut rig = truth.clone();
    rig.beam.offset = lever;
    rig.stuck_stiffness = [2e6, 1e7];
    let measured = MeasuredFrequencies { frequencies, deviation: 5e-4, modulus_deviation: 5e-3 };
    contact_stiffness(&rig, &measured).unwrap()
}

#[test]
fn frequencies_tell_the_tangential_stiffness_and_not_the_normal_one() {
    let truth = model_b();
    let found = identified(&truth, truth.beam.offset);
    let [tangential, normal] = truth.stuck_stiffness;
    assert!((found.tangential.value / tangential - 1.0).abs() < 1e-2, "{found:?}");
    // A modulus that is 0.1 % off is made good by a normal stiffness that is 20 % off, or thereabouts.
    let mut off = truth.clone();
    off.beam.youngs_modulus *= 1.001;
    let frequencies = own_frequencies(&truth, 3).unwrap();
    let fixed = MeasuredFrequencies { frequencies, deviation: 5e-4, modulus_deviation: 1e-9 };
    let moved = contact_stiffness(&off, &fixed).unwrap();
    assert!((moved.normal.value / normal - 1.0).abs() > 0.1, "{moved:?}");
    // So its interval is wide, that of the tangential stiffness is not.
    let narrow = found.tangential.interval;
    assert!(narrow.high < 1.2 * narrow.low && found.tangential.told, "{found:?}");
    // Frequencies do not see how rigid it is, only that it is not soft.
    let wide = found.normal.interval;
    assert!((9e6..11e6).contains(&wide.low) && wide.high.is_infinite() && !found.normal.told, "{found:?}");
}

#[test]
fn the_interval_of_the_normal_stiffness_ends_where_the_frequencies_part_from_the_measured_ones() {
    let truth = model_b();
    let found = identified(&truth, truth.beam.offset);
    // χ² at a normal stiffness, the least over a grid of the other two.
    let measured = own_frequencies(&truth, 3).unwrap();
    let chi_square = |normal: f64| {
        let grid = (-20..=20).flat_map(|e| (-20..=20).map(move |t| (f64::from(e), f64::from(t))));
        let of = |(e, t): (f64, f64)| {
            let mut rig = truth.clone();
            rig.beam.youngs_modulus *= 1.0 + 1e-3 * e;
            rig.stuck_stiffness = [truth.stuck_stiffness[0] * (1.0 + 1e-2 * t), normal];
            let own = own_frequencies(&rig, 3).unwrap();
            let off = own.iter().zip(&measured).map(|(a, b)| ((a / b - 1.0) / 5e-4).powi(2));
            off.sum::<f64>() + (1e-3 * e / 5e-3).powi(2)
        };
        grid.map(of).fold(f64::INFINITY, f64::min)
    };
    let end = found.normal.interval.low;
    assert!(chi_square(0.95 * end) > 3.84 && chi_square(1.1 * end) < 3.84, "{end}");
    assert!(chi_square(1e3 * truth.stuck_stiffness[1]) < 3.84);
}

#[test]
fn a_normal_stiffness_is_found_from_a_value_far_off() {
    let truth = model_b();
    let near = identified(&truth, truth.beam.offset);
    for factors in [[1.0, 1e-4], [1e-4, 1.0], [1e3, 1e3]] {
        let mut rig = truth.clone();
        rig.stuck_stiffness.iter_mut().zip(factors).for_each(|(k, factor)| *k *= factor);
        let frequencies = own_frequencies(&truth, 3).unwrap();
        let measured = MeasuredFrequencies { frequencies, deviation: 5e-4, modulus_deviation: 5e-3 };
        let found = contact_stiffness(&rig, &measured).unwrap();
        assert!(found.fits && found.chi_square < 0.1, "{factors:?} {found:?}");
        let [here, there] = [&found, &near].map(|found| found.normal.interval.low);
        assert!((here / there - 1.0).abs() < 0.02, "{factors:?}: {here} {there}");
    }
}

#[test]
fn frequencies_that_no_stiffness_gives_tell_none() {
    let truth = model_b();
    let told = |frequencies: &[f64]| {
        let frequencies = frequencies.to_vec();
        contact_stiffness(
            &truth,
            &MeasuredFrequencies { frequencies, deviation: 5e-4, modulus_deviation: 5e-3 },
        )
    };
    for wrong in [[52.787, 169.0, 335.86], [45.0, 150.0, 310.0], [52.787, 164.42, 345.0]] {
        let found = told(&wrong).unwrap();
        assert!(!found.fits && !found.normal.told && !found.tangential.told && !found.youngs_modulus.told);
    }
    assert!(told(&[52.787, 52.787, 335.86]).is_err() && told(&[335.86, 164.42, 52.787]).is_err());
    let many: Vec<f64> = (0..60).map(|k| 50.0 + 100.0 * f64::from(k)).collect();
    assert!(told(&many).is_err() || !told(&many).unwrap().fits);
    // What says nothing gives back what was assumed, and does not tell it.
    let frequencies = own_frequencies(&truth, 3).unwrap();
    let vague = MeasuredFrequencies { frequencies, deviation: 10.0, modulus_deviation: 5e-3 };
    let found = contact_stiffness(&truth, &vague).unwrap();
    assert!(!found.youngs_modulus.told && !found.tangential.told && !found.normal.told, "{found:?}");
    for modulus_deviation in [5e-3, 1e-5] {
        let found =
            contact_stiffness(&truth, &MeasuredFrequencies { modulus_deviation, ..vague.clone() }).unwrap();
        let half = 1.96 * modulus_deviation * found.youngs_modulus.value;
        for end in [found.youngs_modulus.interval.low, found.youngs_modulus.interval.high] {
            assert!(((end - truth.beam.youngs_modulus).abs() / half - 1.0).abs() < 0.03, "{found:?}");
        }
    }
}

#[test]
fn of_the_tangential_stiffness_only_its_product_with_the_lever_squared_is_known() {
    let truth = model_b();
    let [short, long] = [0.006, 0.0085].map(|lever| identified(&truth, lever));
    assert!((long.rotational.value / short.rotational.value - 1.0).abs() < 0.1, "{short:?} {long:?}");
    assert!(long.tangential.value < 0.6 * short.tangential.value);
    for (a, b) in long.frequencies.iter().zip(&short.frequencies) {
        assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    }
}
