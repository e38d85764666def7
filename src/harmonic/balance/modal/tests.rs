//! Derivatives of the beam's balance against differences; the contact on it against closed forms.

use std::sync::Arc;

use super::*;
use crate::contact::{
    ContactLaw, Inputs, Jenkins, Joint, JointChanges, Response, SlipState, StateTangents, Tangents, Valanis,
};
use crate::system::{Element, HangingMass, ModalBeam};

fn beam() -> ModalBeam {
    ModalBeam {
        angular_frequency: vec![300.0, 900.0],
        damping_ratio: vec![0.01, 0.02],
        contact_shape: vec![-0.06, 0.115],
        excitation_shape: vec![0.35, -0.7],
        shortening: vec![32.0, -4.0, -4.0, 110.0],
        axial_flexibility: 2e-8,
        stretching_stiffness: 0.0,
        hung: Vec::new(),
        quadratic_damping: 0.0,
        sensors: Vec::new(),
        contact_points: Vec::new(),
    }
}

/// A rate-dependent law without memory: a spring and a damper.
#[derive(Debug)]
struct Damper(f64, f64);

impl ContactLaw for Damper {
    fn state_len(&self) -> usize {
        0
    }

    fn set_state(&self, _: f64, _: f64, _: f64, _: &mut [f64]) {}

    fn step(&self, _: &[f64], inputs: Inputs, _: &mut [f64]) -> Response {
        let tangents = Tangents { displacement: self.0, velocity: self.1, normal_load: 0.0 };
        Response {
            force: self.0 * inputs.displacement + self.1 * inputs.velocity,
            tangents,
            dissipated_energy: 0.0,
            slip_state: SlipState::Stick,
        }
    }

    fn state_tangents(&self, _: &[f64], _: Inputs, out: &mut StateTangents) {
        out.reset(0);
    }

    fn limit(&self, _: f64) -> f64 {
        f64::INFINITY
    }
}

/// Largest difference between Jacobian and central differences, as a fraction of the largest entry of
/// each column; the last columns are those of the scalars.
fn jacobian_error(beam: &ModalBeam, law: Arc<dyn ContactLaw>, size: f64) -> f64 {
    const SCALARS: [Scalar; 3] = [Scalar::AngularFrequency, Scalar::Level, Scalar::SelfExcitation];
    let assembly = Assembly {
        waveform: vec![0.0, 30.0, 5.0],
        ..Assembly::new(beam.system(Some((law, 100.0))).unwrap())
    };
    let mut balance = Balance::new(&assembly, 3, Method::Sampled { samples: 64 }).unwrap();
    balance.equations.derivative_error = 1e-10;
    let n = balance.unknowns();
    let mut x: Vec<f64> = (0..n).map(|k| size * [0.1, 0.4, 1.0, -0.2, 0.1, 0.15, -0.05][k % 7]).collect();
    let at = Operating { self_excitation: 0.004, ..Operating::forced(290.0, 1.2) };
    balance.evaluate(&x, &at, &SCALARS).unwrap();
    // A second evaluation nearby starts from the first: its derivative must be just as good.
    x[2] *= 1.001;
    balance.evaluate(&x, &at, &SCALARS).unwrap();
    let jacobian = balance.jacobian().clone();
    let by = SCALARS.map(|scalar| balance.by(scalar).to_vec());
    let mut seen = Observation::default();
    balance.observe(0, 1, &mut seen);
    let seen_size = seen.by_unknowns.iter().flatten().fold(0.0_f64, |m, d| m.max(d.abs()));
    let mut worst = 0.0_f64;
    for j in 0..n + 3 {
        let step = if j < n { 1e-6 * size } else { 1e-6 * [290.0, 1.2, 0.1][j - n] };
        let mut side = |sign: f64| {
            let (mut moved, mut there) = (x.clone(), at);
            if j < n {
                moved[j] += sign * step;
            } else {
                there.set(SCALARS[j - n], there.get(SCALARS[j - n]) + sign * step);
            }
            balance.forget();
            balance.evaluate(&moved, &there, &[]).unwrap();
            let mut rows = balance.residual().to_vec();
            let mut there = Observation::default();
            balance.observe(0, 1, &mut there);
            rows.extend(there.value);
            rows
        };
        let (up, down) = (side(1.0), side(-1.0));
        let exact = |i: usize| match (i < n, j < n) {
            (true, true) => jacobian[(i, j)],
            (true, false) => by[j - n][i],
            (false, true) => seen.by_unknowns[i - n][j],
            (false, false) => seen.by_scalars[i - n][SCALARS[j - n].index()],
        };
        for rows in [0..n, n..n + 2] {
            // What an output does not depend on is as small as rounding makes it.
            let of_outputs = if rows.start == n && j < n { 1e-3 * seen_size } else { 0.0 };
            let largest = rows.clone().fold(of_outputs, |m, i| m.max(exact(i).abs()));
            for i in rows {
                let difference = (up[i] - down[i]) / (2.0 * step);
                let error = (exact(i) - difference).abs() / largest.max(1e-12);
                worst = worst.max(error);
            }
        }
    }
    worst
}

#[test]
fn jacobian_equals_central_differences() {
    let weakening = JointChanges { weakening: Some((0.4, 0.02)), ..JointChanges::default() };
    let weakening = |base| Arc::new(Joint::new(base, weakening).unwrap());
    let cases: [(Arc<dyn ContactLaw>, f64); 8] = [
        (Arc::new(Valanis::new(5e6, 0.9, 0.3, 0.0).unwrap()), 3e-5),
        (Arc::new(Valanis::new(5e6, 0.9, 0.3, 0.0).unwrap()), 5e-4),
        (Arc::new(Valanis::new(5e6, 0.9, 0.7, 4e5).unwrap()), 5e-4),
        (Arc::new(Jenkins::new(5e6, 0.9).unwrap()), 1e-5),
        (Arc::new(Jenkins::new(5e6, 0.9).unwrap()), 5e-4),
        (Arc::new(Damper(3e6, 2e3)), 3e-4),
        (weakening(Jenkins::new(5e6, 0.9).unwrap()), 1e-5),
        (weakening(Jenkins::new(5e6, 0.9).unwrap()), 5e-4),
    ];
    let mut hung = beam();
    hung.hung = vec![HangingMass { mass: 5.0, frequency: 40.0 }, HangingMass { mass: 1.0, frequency: 120.0 }];
    for (law, size) in cases {
        for beam in [&beam(), &hung] {
            let error = jacobian_error(beam, law.clone(), size);
            assert!(error < 3e-6, "{law:?} at {size}, {:?}: {error}", beam.hung);
        }
    }
}

#[test]
fn a_limit_that_follows_the_velocity_behind_a_flexibility_shares_its_port_with_no_other_law() {
    let changes = JointChanges { weakening: Some((0.4, 0.02)), ..JointChanges::default() };
    let weakening: Arc<dyn ContactLaw> =
        Arc::new(Joint::new(Jenkins::new(5e6, 0.9).unwrap(), changes).unwrap());
    let other: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(5e6, 0.9).unwrap());
    for (first, second, possible) in [
        (&weakening, None, true),
        (&weakening, Some(&other), false),
        (&other, Some(&weakening), false),
        (&other, Some(&other), true),
    ] {
        let mut system = beam().system(Some((first.clone(), 100.0))).unwrap();
        let port = system.elements[0].ports()[0];
        let beside = second.map(|law| Element::Law { port, law: law.clone(), normal_load: 100.0 });
        system.elements.extend(beside);
        let made = Balance::new(&Assembly::new(system), 3, Method::Exact);
        let refused = made.err().map(|error| error.to_string());
        assert_eq!(refused.is_none(), possible, "{refused:?}");
        assert!(refused.is_none_or(|why| why.contains("a port of its own")));
    }
}

#[test]
fn many_solutions_are_each_as_precise_as_derivatives_need() {
    let system = ModalSystem::new(&beam().system(None).unwrap()).unwrap();
    let mut random = fastrand::Rng::with_seed(1);
    // The beam buckles at some 3 kN. Far beyond that a small residual, of which minimal residuals make sure, says little.
    for size in [0.1, 10.0, 100.0, 1e3, 3e3, 1e4].repeat(5) {
        let force: Vec<f64> = (0..coefficient_count(24))
            .map(|k| size * (random.f64() - 0.5) / (1.0 + 0.5 * k as f64))
            .collect();
        let at = Operating::forced(50.0 + 300.0 * random.f64(), 1.0);
        // Many are solved together where rounds are slow, a few by minimal residuals; so are few harmonics.
        for (harmonics, columns) in [(12, 50), (12, 2), (2, 10), (1, 6)] {
            let mut equations = ModalEquations::new(&system, harmonics);
            if harmonics < 12 {
                // Nothing is precise enough: small products must not be made.
                equations.derivative_error = 0.0;
            }
            assert!(equations.set(&at, &force[..coefficient_count(2 * harmonics)]));
            let unknowns = 2 * coefficient_count(harmonics);
            let all = DMatrix::<f64>::identity(unknowns, unknowns);
            let mut one = vec![0.0; unknowns];
            for first in (0..unknowns).step_by(columns) {
                let (right, mut many) =
                    (all.columns(first, columns).into_owned(), DMatrix::zeros(unknowns, columns));
                // That of a low harmonic tells little of the others.
                assert!(equations.solve(all.column(2).into_owned().as_slice(), &mut one));
                equations.solve_many(&right, &mut many);
                for (right, many) in right.column_iter().zip(many.column_iter()) {
                    assert!(equations.solve(right.as_slice(), &mut one));
                    let largest = one.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    let error = many.iter().zip(&one).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                    assert!(
                        error < 1e-2 * largest,
                        "{size} N, {harmonics}, {columns}: {error:e} of {largest:e}"
                    );
                }
            }
        }
    }
}

/// Dissipation of the contact alone under `u = U sin θ`.
fn loop_of(law: impl ContactLaw + 'static, load: f64, amplitude: f64, samples: usize) -> f64 {
    let mut beam = beam();
    beam.axial_flexibility = 0.0;
    let assembly = Assembly::new(beam.system(Some((Arc::new(law), load))).unwrap());
    let mut balance = Balance::new(&assembly, 2, Method::Sampled { samples }).unwrap();
    balance.moved[2] = amplitude;
    let u = balance.displacement().to_vec();
    balance.contact_force(300.0, &u, 0.0).unwrap();
    work_per_cycle(balance.force(), balance.displacement())
}

#[test]
fn jenkins_loop_area_equals_4_limit_times_slip() {
    let law = Jenkins::new(5e6, 0.9).unwrap();
    let exact = 4.0 * 90.0 * (6e-5 - 90.0 / 5e6);
    let error = |samples: usize| (loop_of(law, 100.0, 6e-5, samples) / exact - 1.0).abs();
    assert!(error(128) < 2e-3 && error(1024) < 3e-5, "{} {}", error(128), error(1024));
    assert!(loop_of(law, 100.0, 1e-5, 128).abs() < 1e-18, "a stuck contact dissipates nothing");
}

#[test]
fn valanis_periodic_loops_have_the_reference_areas() {
    // Published parameters; areas from an independent solution. At 1 µm marching alone would need
    // twenty cycles.
    let law = Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15).unwrap();
    for (amplitude, area) in [(1e-6, 6.40993067e-7), (1e-5, 5.82422872e-4), (5e-5, 1.39860743e-2)] {
        let found = loop_of(law, 147.15, amplitude, 1024);
        assert!((found / area - 1.0).abs() < 2e-4, "{amplitude}: {found}");
    }
}
