//! What becomes of a small change as a contact in two directions goes from step to step.

use crate::contact::{SlipSlap, SlipSlapInputs, SlipSlapResponse, SlipSlapTangents, SlipSlapWork};

/// A contact's state, and how it changes when the inputs of all steps so far change by given amounts, to first order.
#[derive(Debug, Clone, Default)]
pub(super) struct Carried {
    pub state: Vec<f64>,
    /// Change of the tangential force (N) in the last step because of the state before it.
    pub force_by_state: f64,
    change: Vec<f64>,
    next: Vec<f64>,
    next_change: Vec<f64>,
    tangents: SlipSlapTangents,
    work: SlipSlapWork,
}

/// Half the span of the differences that stand for derivatives of dissipated energies, relative to these displacements (m)
/// and velocities (m/s).
const SPAN: f64 = 1e-6;
const SCALES: [f64; 2] = [1e-5, 1e-2];

impl Carried {
    /// Begins with `state`, which does not change.
    pub fn begin(&mut self, state: &[f64]) {
        self.state.clear();
        self.state.extend_from_slice(state);
        for buffer in [&mut self.change, &mut self.next, &mut self.next_change] {
            buffer.clear();
            buffer.resize(state.len(), 0.0);
        }
    }

    /// The response of the step to `inputs`, which is not taken.
    pub fn look(&mut self, contact: &SlipSlap, inputs: SlipSlapInputs) -> SlipSlapResponse {
        let Self { state, change, next, tangents, work, .. } = self;
        self.force_by_state = 0.0;
        if change.iter().all(|change| *change == 0.0) {
            return contact.step(state, inputs, next, work);
        }
        let response = contact.step_and_tangents(state, inputs, next, tangents, work);
        self.force_by_state = dot(&tangents.force_by_state[..state.len()], change);
        response
    }

    /// The step to `inputs`, which change by `by`.
    pub fn step(&mut self, contact: &SlipSlap, inputs: SlipSlapInputs, by: SlipSlapInputs) {
        let Self { state, change, next, tangents, work, .. } = self;
        let n = state.len();
        contact.step_and_tangents(state, inputs, next, tangents, work);
        let t = tangents;
        for (row, next_change) in self.next_change.iter_mut().enumerate() {
            *next_change = dot(&t.next_by_state[row * n..(row + 1) * n], change)
                + dot(&t.next_by_displacement[2 * row..2 * row + 2], &by.displacement)
                + dot(&t.next_by_velocity[2 * row..2 * row + 2], &by.velocity);
        }
        std::mem::swap(state, next);
        std::mem::swap(change, &mut self.next_change);
    }

    /// Changes of the energies (J) that friction and impacts dissipate in the step to `inputs`, which change by `by`, if it were
    /// taken. No law knows their derivatives: differences of steps.
    pub fn energies(&mut self, contact: &SlipSlap, inputs: SlipSlapInputs, by: SlipSlapInputs) -> [f64; 2] {
        let most = |changes: [f64; 2], scale: f64| {
            changes.iter().fold(0.0_f64, |most, by| most.max(by.abs())) / scale
        };
        let motion = [self.change[0], self.change[1]];
        let largest = most(by.displacement, SCALES[0])
            .max(most(by.velocity, SCALES[1]))
            .max(most(motion, SCALES[0]))
            .max(most([self.change[2], self.change[3]], SCALES[1]));
        if largest == 0.0 {
            return [0.0; 2];
        }
        let span = SPAN / largest;
        let mut at = |span: f64| {
            for ((at, state), change) in self.next_change.iter_mut().zip(&self.state).zip(&self.change) {
                *at = state + span * change;
            }
            let moved = |value: [f64; 2], by: [f64; 2]| [value[0] + span * by[0], value[1] + span * by[1]];
            let inputs = SlipSlapInputs {
                displacement: moved(inputs.displacement, by.displacement),
                velocity: moved(inputs.velocity, by.velocity),
            };
            let response = contact.step(&self.next_change, inputs, &mut self.next, &mut self.work);
            [response.friction_energy, response.impact_energy]
        };
        let (ahead, behind) = (at(span), at(-span));
        [0, 1].map(|of| (ahead[of] - behind[of]) / (2.0 * span))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
