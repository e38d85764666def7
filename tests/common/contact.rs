//! What the tests of contact laws share: histories, single steps, and derivatives by differences.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, Inputs, Response, StateTangents, Valanis};

/// Normal load of the published contact (N).
pub const LOAD: f64 = 147.15;

/// The published contact, Table 3 of "Nonlinear model identification of a frictional contact support".
pub fn published() -> Valanis {
    Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, LOAD).unwrap()
}

/// A law at the end of a beam under `normal_load` (N).
pub fn loaded(law: impl ContactLaw + 'static, normal_load: f64) -> Option<(Arc<dyn ContactLaw>, f64)> {
    Some((Arc::new(law), normal_load))
}

/// One step in place.
pub fn go(law: &dyn ContactLaw, state: &mut [f64], displacement: f64, normal_load: f64) -> Response {
    let mut next = vec![0.0; state.len()];
    let response = law.step(state, Inputs { displacement, velocity: 0.0, normal_load }, &mut next);
    state.copy_from_slice(&next);
    response
}

/// A contact that is carried along with its state.
pub struct ContactHistory<'a> {
    pub law: &'a dyn ContactLaw,
    pub state: Vec<f64>,
}

impl<'a> ContactHistory<'a> {
    /// At rest without force at displacement zero.
    pub fn at_rest(law: &'a dyn ContactLaw, normal_load: f64) -> Self {
        Self::from(law, 0.0, normal_load, 0.0)
    }

    pub fn from(law: &'a dyn ContactLaw, displacement: f64, normal_load: f64, force: f64) -> Self {
        let mut state = vec![0.0; law.state_len()];
        law.set_state(displacement, normal_load, force, &mut state);
        Self { law, state }
    }

    /// One step.
    pub fn go(&mut self, displacement: f64, normal_load: f64) -> Response {
        go(self.law, &mut self.state, displacement, normal_load)
    }

    /// Energy dissipated in the last of `periods` closed loops of the amplitude, two steps each, and the
    /// force at the upper tip.
    pub fn last_loop(&mut self, amplitude: f64, normal_load: f64, periods: usize) -> (f64, f64) {
        let mut last = (0.0, 0.0);
        self.go(amplitude, normal_load);
        for _ in 0..periods {
            let down = self.go(-amplitude, normal_load);
            let up = self.go(amplitude, normal_load);
            last = (down.dissipated_energy + up.dissipated_energy, up.force);
        }
        last
    }
}

pub fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a:e} and {b:e} differ by more than {tolerance:e}");
}

/// Start and end loads (N): in contact, falling below the force, separation, re-contact, apart.
pub const LOADS: [(f64, f64); 8] = [
    (150.0, 150.0),
    (150.0, 400.0),
    (150.0, 40.0),
    (150.0, 3.0),
    (150.0, -20.0),
    (-50.0, 150.0),
    (-50.0, 20.0),
    (-50.0, -20.0),
];

/// Every derivative of a step against central differences. The step must not start or end on a kink.
/// `lengths` names the components of the state that are displacements; the others are loads.
pub fn check_derivatives(
    law: &dyn ContactLaw,
    state: &[f64],
    inputs: Inputs,
    lengths: &dyn Fn(usize) -> bool,
) {
    let n = state.len();
    let step = |state: &[f64], inputs: Inputs| {
        let mut next = vec![0.0; n];
        (law.step(state, inputs, &mut next), next)
    };
    let (response, _) = step(state, inputs);
    let mut tangents = StateTangents::default();
    law.state_tangents(state, inputs, &mut tangents);
    let size = |index: usize| if index < n && lengths(index) || index == n { 1e-6 } else { 1.0 };
    for column in 0..n + 2 {
        let h = 1e-5 * size(column);
        let moved = |sign: f64| {
            let (mut state, mut inputs) = (state.to_vec(), inputs);
            match column {
                c if c < n => state[c] += sign * h,
                c if c == n => inputs.displacement += sign * h,
                _ => inputs.normal_load += sign * h,
            }
            step(&state, inputs)
        };
        let ((more, next_more), (less, next_less)) = (moved(1.0), moved(-1.0));
        let same = |found: f64, difference: f64, unit: f64, what: &str| {
            let error = (found - difference).abs() * size(column) / unit;
            assert!(
                error < 1e-4,
                "{what}, column {column}: {found:e}, difference {difference:e}, {law:?} {state:?} {inputs:?}"
            );
        };
        let by_force = match column {
            c if c < n => tangents.force_by_state[c],
            c if c == n => response.tangents.displacement,
            _ => response.tangents.normal_load,
        };
        same(by_force, (more.force - less.force) / (2.0 * h), 1.0, "force");
        for row in 0..n {
            let found = match column {
                c if c < n => tangents.next_by_state[row * n + c],
                c if c == n => tangents.next_by_displacement[row],
                _ => tangents.next_by_normal_load[row],
            };
            let difference = (next_more[row] - next_less[row]) / (2.0 * h);
            same(found, difference, size(row), &format!("next {row}"));
        }
    }
    assert!(tangents.next_by_velocity.iter().all(|value| *value == 0.0));
}

/// One step against many with displacement and load linear: force, energy, state.
pub fn check_one_step_equals_many(
    law: &dyn ContactLaw,
    start: &ContactHistory,
    displacement: f64,
    normal_load: f64,
    from: (f64, f64),
) {
    let mut once = ContactHistory::at_rest(law, 1.0);
    once.state.clone_from(&start.state);
    let mut often = ContactHistory::at_rest(law, 1.0);
    often.state.clone_from(&start.state);
    let whole = once.go(displacement, normal_load);
    let (mut dissipated, mut last, parts) = (0.0, whole, 37);
    for i in 1..=parts {
        let s = i as f64 / parts as f64;
        let load = if i == parts { normal_load } else { from.1 + s * (normal_load - from.1) };
        last = often.go(from.0 + s * (displacement - from.0), load);
        dissipated += last.dissipated_energy;
    }
    close(whole.force, last.force, 1e-9);
    close(whole.dissipated_energy, dissipated, 1e-14);
    for (a, b) in once.state.iter().zip(&often.state) {
        close(*a, *b, 1e-15 + 1e-15 * a.abs());
    }
}

/// Work into the contact = energy kept + dissipated over a history with reversals, changes of the load
/// and separations, and no step dissipates less than nothing.
pub fn check_energy_balance(law: &dyn ContactLaw, stored: &dyn Fn(&[f64]) -> f64) {
    let mut contact = ContactHistory::at_rest(law, 150.0);
    let (mut work, mut dissipated, mut force, mut before) = (0.0, 0.0, 0.0, 0.0);
    let samples = 40_000;
    for i in 1..=samples {
        let t = 6.0 * i as f64 / samples as f64;
        let displacement = 60e-6 * (1.7 * t).sin() + 30e-6 * (5.1 * t).sin();
        let response = contact.go(displacement, 100.0 + 160.0 * (2.3 * t).cos());
        assert!(response.dissipated_energy >= 0.0);
        work += 0.5 * (force + response.force) * (displacement - before);
        (force, before) = (response.force, displacement);
        dissipated += response.dissipated_energy;
    }
    close(work / (stored(&contact.state) + dissipated), 1.0, 1e-6);
    assert!(dissipated > 0.0);
}
