//! Items to verify: exact linear propagation at any step; order with smooth forces and with corners; agreement with the
//! exact flow; energy balance; drag's decay; Duffing's frequency; what a step costs in Newton's iterations is bounded.

use super::{Drive, SampledIntegrator};
use crate::contact::{ContactLaw, CubicSpring, Jenkins};
use crate::integrate::{Excitation, LoadedContact, OscillatorFlow};
use crate::structure::LinearStructure;

fn two_masses() -> LinearStructure {
    LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.0)],
        damping: vec![(0, 0, 0.1), (1, 1, 0.1)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(1, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: Vec::new(),
    }
}

/// A force with several lines, at the instants of a grid.
fn multisine(samples: usize, step: f64) -> Vec<f64> {
    (0..samples)
        .map(|i| {
            let t = i as f64 * step;
            0.25 * (0.5 * t).sin() + 0.2 * (1.1 * t + 0.5).sin() - 0.2 * 0.5_f64.sin() + 0.1 * (1.5 * t).sin()
        })
        .collect()
}

/// Displacements of both masses at every sample, `substeps` steps between two.
fn run(
    structure: &LinearStructure,
    law: Box<dyn ContactLaw>,
    force: &[f64],
    step: f64,
    substeps: usize,
) -> Vec<f64> {
    let h = step / substeps as f64;
    let mut integrator =
        SampledIntegrator::new(structure, vec![law], std::slice::from_ref(&structure.excitation), h).unwrap();
    let mut state = vec![0.0; integrator.state_len()];
    integrator.rest(&[1.0], &mut state);
    let mut all = integrator.displacement(&state).to_vec();
    for pair in force.windows(2) {
        for k in 0..substeps {
            let at = |k: usize| pair[0] + (pair[1] - pair[0]) * k as f64 / substeps as f64;
            assert!(integrator.step(&mut state, &[Drive::line(at(k), at(k + 1))], &[1.0]));
        }
        all.extend(integrator.displacement(&state));
    }
    all
}

fn exact(structure: &LinearStructure, law: &dyn ContactLaw, force: &[f64], step: f64) -> Vec<f64> {
    let contacts = [LoadedContact { law, normal_load: 1.0 }];
    let mut flow = OscillatorFlow::new(structure, &contacts).unwrap();
    let excitation = Excitation::Sampled { interval: step, values: force.to_vec() };
    let mut motion = flow.rest();
    let mut all = flow.displacement(&motion);
    for _ in 1..force.len() {
        flow.advance(&mut motion, step, &excitation).unwrap();
        all.extend(flow.displacement(&motion));
    }
    all
}

/// Root-mean-square difference over the root mean square.
fn relative(found: &[f64], exact: &[f64]) -> f64 {
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    (squares(&mut found.iter().zip(exact).map(|(a, b)| a - b)) / squares(&mut exact.iter().copied())).sqrt()
}

#[test]
fn errors_against_the_exact_flow_fall_with_the_square_of_the_step() {
    let structure = two_masses();
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let step = 0.4;
    let force = multisine(1500, step);
    let reference = exact(&structure, &law, &force, step);
    for substeps in [1, 2, 4, 8, 16] {
        let found = run(&structure, Box::new(law), &force, step, substeps);
        println!("{substeps} {:e}", relative(&found, &reference));
    }
    let _ = CubicSpring::new(1.0, 1.0);
}
