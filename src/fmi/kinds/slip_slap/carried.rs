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

    /// The step to `inputs`, which change by `by`: the response, and the changes of the energies (J) that friction and
    /// impacts dissipate.
    pub fn step(
        &mut self,
        contact: &SlipSlap,
        inputs: SlipSlapInputs,
        by: SlipSlapInputs,
    ) -> (SlipSlapResponse, [f64; 2]) {
        let energies = self.energies(contact, inputs, by);
        let n = self.state.len();
        let response = contact.step_and_tangents(
            &self.state,
            inputs,
            &mut self.next,
            &mut self.tangents,
            &mut self.work,
        );
        let t = &self.tangents;
        self.force_by_state = dot(&t.force_by_state[..n], &self.change);
        for (row, change) in self.next_change.iter_mut().enumerate() {
            *change = dot(&t.next_by_state[row * n..(row + 1) * n], &self.change)
                + dot(&t.next_by_displacement[2 * row..2 * row + 2], &by.displacement)
                + dot(&t.next_by_velocity[2 * row..2 * row + 2], &by.velocity);
        }
        std::mem::swap(&mut self.state, &mut self.next);
        std::mem::swap(&mut self.change, &mut self.next_change);
        (response, energies)
    }

    /// No law knows the derivatives of the energies it dissipates: differences of steps.
    fn energies(&mut self, contact: &SlipSlap, inputs: SlipSlapInputs, by: SlipSlapInputs) -> [f64; 2] {
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
