//! Two masses split in two slaves: orders of convergence, energy residuals and notes, against the exact solution.

use stickslip::cosim::{Abilities, Algorithm, InputRule, Method, Settings, System};

use crate::common::cosim::*;
use crate::common::linear_slave::*;

const STOP: f64 = 2.0;
const STEPS: [f64; 3] = [0.01, 0.005, 0.0025];

/// Error at the end and energy residual, for each of the steps.
fn errors(algorithm: &Algorithm, system: impl Fn() -> System) -> Vec<[f64; 2]> {
    let exact = TWO_MASSES.exact(STOP);
    let run = |step: f64| {
        let (rows, report) = record(system(), Settings::new(algorithm.clone(), step, STOP)).unwrap();
        assert_eq!(report.unconverged, 0, "{algorithm:?}");
        let (time, end) = rows.last().unwrap();
        assert!((time - STOP).abs() < 1e-9);
        let error = (end[0] - exact[0]).abs() + (end[2] - exact[2]).abs();
        [error, report.energy[0].magnitude]
    };
    STEPS.iter().map(|step| run(*step)).collect()
}

fn orders(errors: &[[f64; 2]], what: usize) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0][what] / pair[1][what]).log2()).collect()
}

fn extrapolated(order: u32) -> [Algorithm; 2] {
    [Algorithm::Jacobi { extrapolation: order }, Algorithm::GaussSeidel { extrapolation: order, order: None }]
}

const METHODS: [Method; 4] =
    [Method::FixedPoint, Method::Aitken, Method::Anderson { depth: 3 }, Method::Newton];

fn assert_order(algorithm: &Algorithm, expected: f64, system: impl Fn() -> System) {
    let errors = errors(algorithm, &system);
    let (order, energy) = (orders(&errors, 0), orders(&errors, 1));
    // Where two errors of different signs meet, coarse steps are not yet on the way.
    assert!(order[order.len() - 1] > expected - 0.25, "{algorithm:?}: {errors:?} {order:?}");
    // Without derivatives the first step holds its inputs, whatever comes later.
    let from_the_start = system().slaves().iter().all(|slave| slave.abilities().output_derivative_order > 0);
    let expected = if from_the_start || matches!(algorithm, Algorithm::Strong(_)) { expected } else { 1.0 };
    // What is held at the middle does, in the mean over the step, exactly the work that the other side takes.
    let balanced = errors.iter().all(|[_, energy]| *energy < 1e-9);
    let falls = energy.iter().all(|order| *order > expected - 0.25);
    assert!(balanced || falls, "{algorithm:?}: energy {errors:?} {energy:?}");
}

#[test]
fn held_inputs_converge_with_the_first_order() {
    for algorithm in extrapolated(0) {
        assert_order(&algorithm, 1.0, || joined(TWO_MASSES.slaves()));
        let errors = errors(&algorithm, || joined(TWO_MASSES.slaves()));
        assert!(orders(&errors, 0).iter().all(|order| *order < 1.4), "no better either: {errors:?}");
    }
}

#[test]
fn extrapolated_inputs_converge_with_the_second_order() {
    for order in [1, 2] {
        for algorithm in extrapolated(order) {
            assert_order(&algorithm, 2.0, || joined(TWO_MASSES.slaves()));
        }
    }
}

#[test]
fn past_values_serve_where_there_are_no_derivatives() {
    let abilities = Abilities { output_derivative_order: 0, ..EVERYTHING };
    for algorithm in extrapolated(1) {
        assert_order(&algorithm, 2.0, || joined(TWO_MASSES.slaves().map(|slave| slave.with(abilities))));
    }
}

#[test]
fn strong_coupling_converges_with_the_second_order_under_every_method() {
    for method in METHODS {
        assert_order(&strong(method), 2.0, || joined(TWO_MASSES.slaves()));
    }
}

#[test]
fn slaves_that_hold_their_inputs_reach_the_second_order_too() {
    let without = Abilities { saves_state: true, variable_step: true, ..Abilities::default() };
    let derived = Abilities { directional_derivatives: true, ..without };
    for abilities in [without, derived] {
        let slaves = || TWO_MASSES.slaves().map(|slave| slave.with(abilities));
        assert_order(&strong(Method::Anderson { depth: 3 }), 2.0, || joined(slaves()));
        for algorithm in extrapolated(1) {
            assert_order(&algorithm, 2.0, || joined(slaves()));
        }
        // Nor does it matter that they do not tell what depends on what.
        let silent = || joined(slaves().map(Linear::silent));
        assert_order(&strong(Method::Anderson { depth: 3 }), 2.0, silent);
    }
}

#[test]
fn the_wrong_rule_for_inputs_costs_an_order() {
    let held = Abilities { saves_state: true, variable_step: true, ..Abilities::default() };
    let system = || {
        let mut system = joined(TWO_MASSES.slaves().map(|slave| slave.with(held)));
        system.give_inputs("first", InputRule::End).unwrap();
        system
    };
    let errors = errors(&strong(Method::Anderson { depth: 3 }), system);
    assert!(orders(&errors, 0).iter().all(|order| *order < 1.3), "{errors:?}");
}

#[test]
fn the_energy_residual_is_the_energy_that_the_coupling_feeds_in() {
    // An undamped mass on a spring of its own, and another spring as a slave: all energy there is can be told.
    let TwoMasses { mass: [mass, _], stiffness: [own, _], joint_stiffness: other, .. } = TWO_MASSES;
    let gained = |algorithm: Algorithm| {
        let [first, _] = TwoMasses { damping: [0.0; 2], ..TWO_MASSES }.slaves();
        let inputs = [("displacement", "m"), ("velocity", "m/s")];
        let answers = [other, 0.0, 1.0, 0.0];
        let outputs = [("force", "N"), ("position", "m")];
        let second = Linear::new("second", &inputs, &outputs, [&[], &[], &[], &answers], &[]);
        let mut system = joined([first, second]);
        system.observe("second", "force").unwrap();
        let (rows, report) = record(system, Settings::new(algorithm, 0.01, STOP)).unwrap();
        let energy = |values: &[f64]| {
            0.5 * (mass * values[1].powi(2) + own * values[0].powi(2) + values[3].powi(2) / other)
        };
        (energy(&rows[rows.len() - 1].1) - energy(&rows[0].1), report.energy[0].sum)
    };
    let (jacobi, _) = gained(JACOBI);
    assert!(jacobi > 0.0, "what is late feeds energy in");
    for (algorithm, accuracy) in [(JACOBI, 1e-9), (GAUSS_SEIDEL, 1e-9), (strong(Method::Newton), 1e-4)] {
        let (gain, residual) = gained(algorithm.clone());
        assert!(
            (gain - residual).abs() < accuracy * jacobi,
            "{algorithm:?} {gain:e} {residual:e} {jacobi:e}"
        );
    }
    let (strong, _) = gained(strong(Method::Newton));
    assert!(strong.abs() < 1e-2 * jacobi, "{strong:e} {jacobi:e}");
}
