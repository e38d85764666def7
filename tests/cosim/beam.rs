//! Beam and contact coupled, against the same in one piece.

use stickslip::cosim::{Algorithm, Method, Settings};

use crate::common::cosim::*;

/// Friction settles the motion well within the run.
const SHAKER: Shaker = Shaker { amplitude: 6.0, omega: 324.0, growth: 0.1 };

fn steady_amplitude(rows: &Rows, from: f64) -> f64 {
    amplitude(rows.iter().filter(|(time, _)| *time >= from).map(|(_, values)| values[3]))
}

#[test]
fn strong_coupling_keeps_the_steady_amplitude_where_plain_jacobi_does_not() {
    let (step, stop, from) = (1e-4, 1.0, 0.9);
    for contact in [VALANIS, JENKINS] {
        let exact = monolithic(contact, SHAKER, 1e-5, stop, 10);
        let exact = amplitude(exact.iter().filter(|row| row[0] >= from).map(|row| row[2]));
        let error = |algorithm| {
            let (rows, _) = record(beam_with(contact, SHAKER), Settings::new(algorithm, step, stop)).unwrap();
            (steady_amplitude(&rows, from) / exact - 1.0).abs()
        };
        let strong = error(strong(Method::Anderson { depth: 5 }));
        let jacobi = error(JACOBI);
        assert!(strong < 1e-3, "{strong:e}");
        assert!(jacobi > 20.0 * strong, "{jacobi:e} {strong:e}");
    }
}

/// Largest error of the displacement at the shaker at every millisecond, over its largest value, and the
/// relative energy residual.
fn error(contact: &str, algorithm: Algorithm, step: f64, exact: &[[f64; 3]]) -> [f64; 2] {
    let stop = exact.last().unwrap()[0];
    let settings = Settings { tolerance: Some(1e-9), ..Settings::new(algorithm, step, stop) };
    let (rows, report) = record(beam_with(contact, FAST), settings).unwrap();
    assert_eq!(report.unconverged, 0);
    let every = (1e-3 / step).round() as usize;
    let pairs = rows.iter().step_by(every).zip(exact);
    let worst = pairs.map(|((_, values), exact)| (values[3] - exact[2]).abs()).fold(0.0, f64::max);
    let size = exact.iter().map(|row| row[2].abs()).fold(0.0, f64::max);
    [worst / size, report.energy[0].magnitude / report.energy[0].exchanged]
}

/// Slips within a few periods.
const FAST: Shaker = Shaker { amplitude: 60.0, omega: 324.0, growth: 0.02 };

#[test]
fn errors_fall_with_the_order_of_the_algorithm() {
    for contact in [VALANIS, JENKINS] {
        let exact = monolithic(contact, FAST, 5e-6, 0.05, 200);
        let orders = |algorithm: &Algorithm, steps: [f64; 2]| {
            let [coarse, fine] = steps.map(|step| error(contact, algorithm.clone(), step, &exact));
            let order = |what: usize| (coarse[what] / fine[what]).ln() / (steps[0] / steps[1]).ln();
            // Forces held at the middle do in the mean exactly the work that the contact takes: nothing is left to fall.
            [order(0), if fine[1] < 1e-9 { f64::INFINITY } else { order(1) }]
        };
        for algorithm in [JACOBI, GAUSS_SEIDEL] {
            let [error, energy] = orders(&algorithm, [5e-5, 1.25e-5]);
            assert!(error > 0.9 && energy > 0.9, "{algorithm:?} {error} {energy}");
        }
        for algorithm in [
            Algorithm::Jacobi { extrapolation: 1 },
            Algorithm::GaussSeidel { extrapolation: 1, order: None },
            strong(Method::Anderson { depth: 5 }),
            strong(Method::Newton),
        ] {
            let [error, energy] = orders(&algorithm, [1e-4, 2.5e-5]);
            assert!(error > 1.75, "{algorithm:?} {error}");
            // What Jacobi expects of Jenkins' force at a corner is far off, and is taken back in the next step.
            let rings = contact == JENKINS && matches!(algorithm, Algorithm::Jacobi { .. });
            assert!(rings || energy > 1.75, "{algorithm:?} {energy}");
        }
    }
}

#[test]
fn every_method_finds_the_same_motion_and_derivatives_need_hardly_more_evaluations_than_any() {
    let run = |method, step| {
        let settings = Settings::new(strong(method), step, 0.05);
        let (rows, report) = record(beam_with(VALANIS, FAST), settings).unwrap();
        assert_eq!(report.unconverged, 0, "{method:?}");
        (rows, report.evaluations as f64 / report.steps as f64)
    };
    for step in [1e-3, 1e-4] {
        let (expected, newton) = run(Method::Newton, step);
        for method in [Method::FixedPoint, Method::Aitken, Method::Anderson { depth: 5 }] {
            let (rows, repetitions) = run(method, step);
            let size = amplitude(expected.iter().map(|(_, values)| values[3]));
            for ((_, values), (_, other)) in rows.iter().zip(&expected) {
                assert!((values[3] - other[3]).abs() < 1e-6 * size, "{method:?}");
            }
            // Of slopes at the end of a step, which are unknowns as well, derivatives tell a part; differences tell all.
            let allowance = if matches!(method, Method::Anderson { .. }) { 1.05 } else { 1.0 };
            assert!(newton < allowance * repetitions, "{method:?} {repetitions} {newton}");
        }
    }
}
