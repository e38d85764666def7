//! A disturbance where the force of a contact jumps: it jumps sooner or later, which is an impulse.
//!
//! With the jump `c u̇` at the displacement u*, the impulse is `|c| (δu − ∂u*/∂state δstate)`. On the grid it is a stiffness
//! at one phase alone, so large that over the steps on either side it is that impulse.

use std::f64::consts::TAU;

use super::signal::{evaluate, root, turning_points};
use super::step::Step;
use crate::contact::{Inputs, Period, PeriodicSolver, StateTangents};
use crate::time::LoadedContact;

/// How far beside a jump the law is looked at, as a fraction of the displacement.
const BESIDE: f64 = 1e-9;

/// The impulse of a jump.
#[derive(Debug)]
pub(super) struct Impulse {
    /// Where the force jumps (m).
    pub displacement: f64,
    /// N s/m.
    damping: f64,
    /// −∂displacement/∂state.
    by_state: Vec<f64>,
}

impl Impulse {
    /// That on the way from `state` at the displacement `from` to `to`.
    pub fn on_the_way(contact: &LoadedContact, state: &[f64], from: f64, to: Inputs) -> Option<Self> {
        let jump = contact.law.jump(state, to)?;
        let ahead = (to.displacement - from).signum() * jump.damping.signum();
        let closed = jump.displacement + BESIDE * jump.displacement.abs() * ahead;
        let inputs = Inputs { displacement: closed, ..to };
        let (mut tangents, mut next) = (StateTangents::default(), state.to_vec());
        let response = contact.law.force_and_tangents(state, inputs, &mut next, &mut tangents);
        let stiffness = response.tangents.displacement;
        let by_state = tangents.force_by_state.iter().map(|by_state| by_state / stiffness).collect();
        (stiffness > 0.0).then_some(Self {
            displacement: jump.displacement,
            damping: jump.damping.abs(),
            by_state,
        })
    }

    /// Acts within a step of the grid, which counts for `duration` (s).
    pub fn act(&self, duration: f64, step: &mut Step) {
        let stiffness = self.damping / duration;
        step.by_displacement += stiffness;
        step.state
            .force_by_state
            .iter_mut()
            .zip(&self.by_state)
            .for_each(|(into, by)| *into += stiffness * by);
    }
}

/// Phases in [0, 2π) at which the force jumps; and, of a law whose force does, its tangents too.
pub(super) fn phases(contact: &LoadedContact, coefficients: &[f64], angular_frequency: f64) -> [Vec<f64>; 2] {
    let [mut of_force, mut of_tangents] = [Vec::new(), Vec::new()];
    let mut turnings = turning_points(coefficients);
    let Some(first) = turnings.first() else { return [of_force, of_tangents] };
    turnings.push(first + TAU);
    let displacement: Vec<f64> = turnings.iter().map(|phase| evaluate(coefficients, *phase).0).collect();
    let still = vec![0.0; displacement.len() - 1];
    let loads = [contact.normal_load];
    let period = Period { displacement: &displacement[1..], velocity: &still, normal_load: &loads };
    let law = contact.law;
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, contact.normal_load, 0.0, &mut state);
    // Without a periodic state the history says so.
    if PeriodicSolver::new().solve(law, &period, &mut state).is_err() {
        return [of_force, of_tangents];
    }
    let at = |phase: f64| {
        let (displacement, slope) = evaluate(coefficients, phase);
        Inputs { displacement, velocity: angular_frequency * slope, normal_load: contact.normal_load }
    };
    let mut legs = Vec::new();
    for (turning, displacement) in turnings.windows(2).zip(&displacement[1..]) {
        let end = Inputs { displacement: *displacement, velocity: 0.0, normal_load: contact.normal_load };
        if let Some(jump) = law.jump(&state, end) {
            let beyond = |phase| at(phase).displacement - jump.displacement;
            of_force.push(root(beyond, turning[0], turning[1]).rem_euclid(TAU));
        }
        legs.push((turning, state.clone()));
        law.advance(&mut state, end);
    }
    if !of_force.is_empty() {
        for (turning, start) in legs {
            let mut tangents = |phase: f64| {
                let tangents = law.step(&start, at(phase), &mut state).tangents;
                [tangents.displacement, tangents.velocity]
            };
            jumps_between(turning[0], turning[1], &mut tangents, &mut of_tangents);
        }
    }
    [of_force, of_tangents]
}

/// Phases between `from` and `to` at which `tangents` jump.
fn jumps_between(from: f64, to: f64, tangents: &mut impl FnMut(f64) -> [f64; 2], out: &mut Vec<f64>) {
    const INTERVALS: usize = 64;
    /// Fractions of a tangent by which it changes over an interval, and by which it jumps.
    const CHANGES: f64 = 1e-2;
    const JUMPS: f64 = 1e-3;
    let changes = |a: &[f64; 2], b: &[f64; 2], fraction: f64| {
        a.iter().zip(b).any(|(a, b)| (a - b).abs() > fraction * a.abs().max(b.abs()))
    };
    let phase = |k: usize| from + (to - from) * (k as f64 + 1e-6) / (INTERVALS as f64 + 2e-6);
    let mut before = tangents(phase(0));
    for k in 1..=INTERVALS {
        let after = tangents(phase(k));
        if changes(&before, &after, CHANGES) {
            let (mut low, mut high, mut near, mut far) = (phase(k - 1), phase(k), before, after);
            while high - low > 1e-12 * to.abs().max(1.0) {
                let middle = 0.5 * (low + high);
                let here = tangents(middle);
                if changes(&near, &here, JUMPS) {
                    (high, far) = (middle, here)
                } else {
                    (low, near) = (middle, here)
                }
            }
            if changes(&near, &far, JUMPS) {
                out.push(high.rem_euclid(TAU));
            }
        }
        before = after;
    }
}
