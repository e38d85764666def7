//! Derivatives of the condensed balance against differences.

use std::sync::Arc;

use super::*;
use crate::contact::{ContactLaw, Jenkins, Unilateral, Valanis};
use crate::harmonic::balance::varied::Varied;
use crate::harmonic::newton::system::{Observation, PeriodicSystem};

/// Two masses, a contact on each, the excitation on the first.
fn structure() -> LinearStructure {
    let output = |name: &str, k| Output { name: name.into(), row: vec![(k, 1.0)] };
    LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.2)],
        damping: vec![(0, 0, 0.1), (1, 1, 0.07)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(0, 1.0)], vec![(1, 1.0), (0, -1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: vec![output("x", 0), output("y", 1)],
    }
}

fn assembly(laws: [&Arc<dyn ContactLaw>; 2]) -> Assembly {
    Assembly::new(structure().system(laws.map(|law| (law.clone(), 1.0)).to_vec()))
}

fn unknowns(system: &dyn PeriodicSystem) -> Vec<f64> {
    let parts = [0.02, 0.5, 0.3, -0.08, 0.11, 0.05, -0.07];
    (0..system.unknowns()).map(|k| parts[k % 7]).collect()
}

const SCALARS: [Scalar; 4] =
    [Scalar::AngularFrequency, Scalar::Level, Scalar::SelfExcitation, Scalar::Parameter];

/// Residual, then both parts of harmonics 1 and 3 of both outputs.
fn everything(system: &mut dyn PeriodicSystem, x: &[f64], at: &Operating) -> Vec<f64> {
    system.forget();
    system.evaluate(x, at, &[]).unwrap();
    let mut all = system.residual().to_vec();
    let mut seen = Observation::default();
    for (node, order) in [(0, 1), (1, 1), (0, 3), (1, 3)] {
        system.observe(node, order, &mut seen);
        all.extend(seen.value);
    }
    all
}

#[test]
fn derivatives_equal_central_differences() {
    let jenkins: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(0.8, 0.2).unwrap());
    let valanis: Arc<dyn ContactLaw> = Arc::new(Valanis::new(0.9, 0.2, 0.4, 0.0).unwrap());
    let stop: Arc<dyn ContactLaw> = Arc::new(Unilateral::new(0.7, 0.1).unwrap());
    for law in [&jenkins, &valanis, &stop] {
        let make = |p: f64| {
            let limited: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(0.8, p)?);
            Ok(assembly([law, &limited]))
        };
        let settings = CurveSettings { harmonics: 3, ..CurveSettings::default() };
        let mut system = Varied::new(&make, 0.2, 0.0, &settings).unwrap();
        let x = unknowns(&system);
        let at = Operating { angular_frequency: 0.9, level: 0.4, self_excitation: 0.03, parameter: 0.2 };
        let n = x.len();
        system.evaluate(&x, &at, &SCALARS).unwrap();
        let mut exact = vec![vec![0.0; n + 8]; n + 4];
        for (j, column) in exact.iter_mut().enumerate() {
            for (i, value) in column.iter_mut().take(n).enumerate() {
                *value = if j < n { system.jacobian()[(i, j)] } else { system.by(SCALARS[j - n])[i] };
            }
        }
        let mut seen = Observation::default();
        for (k, (node, order)) in [(0, 1), (1, 1), (0, 3), (1, 3)].into_iter().enumerate() {
            system.observe(node, order, &mut seen);
            for part in 0..2 {
                for (j, column) in exact.iter_mut().enumerate() {
                    column[n + 2 * k + part] =
                        if j < n { seen.by_unknowns[part][j] } else { seen.by_scalars[part][j - n] };
                }
            }
        }
        for (j, column) in exact.iter().enumerate() {
            const STEP: f64 = 1e-5;
            let mut side = |sign: f64| {
                let (mut x, mut at) = (x.clone(), at);
                if j < n {
                    x[j] += sign * STEP;
                } else {
                    at.set(SCALARS[j - n], at.get(SCALARS[j - n]) + sign * STEP);
                }
                everything(&mut system, &x, &at)
            };
            let (up, down) = (side(1.0), side(-1.0));
            let size = column.iter().fold(1e-3_f64, |m, d| m.max(d.abs()));
            for (i, derivative) in column.iter().enumerate() {
                let difference = (up[i] - down[i]) / (2.0 * STEP);
                assert!(
                    (derivative - difference).abs() < 2e-5 * size,
                    "{law:?} ({i}, {j}): {derivative} {difference}"
                );
            }
        }
    }
}

#[test]
fn derivatives_along_a_direction_are_those_of_the_outputs() {
    let jenkins: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(0.8, 0.2).unwrap());
    let assembly = assembly([&jenkins, &jenkins]);
    let settings = CurveSettings { harmonics: 5, ..CurveSettings::default() };
    let mut system = Condensed::new(&assembly, &settings, 0.0).unwrap();
    assert!(system.set().is_odd());
    let x = unknowns(&system);
    let at = Operating::forced(0.9, 0.4);
    let direction: Vec<f64> = (0..x.len()).map(|k| 0.3 - 0.1 * k as f64).collect();
    let scalars = [0.2, -0.4, 0.0, 0.0];
    system.evaluate(&x, &at, &SCALARS).unwrap();
    let mut along = vec![Vec::new(); 2];
    system.nodes_along(&direction, &scalars, &mut along);
    let mut seen = Observation::default();
    for (node, along) in along.iter().enumerate() {
        for order in 0..=5 {
            system.observe(node, order, &mut seen);
            for part in 0..if order == 0 { 1 } else { 2 } {
                let unknowns: f64 = seen.by_unknowns[part].iter().zip(&direction).map(|(a, b)| a * b).sum();
                let scalars: f64 = seen.by_scalars[part].iter().zip(&scalars).map(|(a, b)| a * b).sum();
                let found = along[full_place(order) + part];
                assert!((found - unknowns - scalars).abs() < 1e-12, "{node} {order}");
            }
        }
    }
}
