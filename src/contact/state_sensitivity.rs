//! What becomes of a small change as a law goes from step to step.

use super::{ContactLaw, Inputs, StateTangents};

/// A law's memory, and how it changes when the inputs of all steps so far change by given amounts, to first order.
#[derive(Debug, Clone, Default)]
pub(crate) struct StateSensitivity {
    pub memory: Vec<f64>,
    pub change: Vec<f64>,
    next: Vec<f64>,
    next_change: Vec<f64>,
    tangents: StateTangents,
}

/// To first order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Change {
    /// Of the force (N).
    pub force: f64,
    /// Of ∂force/∂displacement (N/m).
    pub tangent: f64,
    /// Of the energy dissipated in the step (J).
    pub dissipated_energy: f64,
}

/// Half the span of the differences that stand for derivatives of tangent and dissipated energy, relative to the inputs.
const SPAN: f64 = 1e-6;
/// How much better the tangents fit the force on one side than on the other where they are those of that side.
const CORNER: f64 = 30.0;
/// Displacement (m), velocity (m/s) and load (N) below which the span is not made smaller.
const SMALLEST: [f64; 3] = [1e-8, 1e-4, 1e-3];

impl StateSensitivity {
    /// Begins with `memory`, which does not change.
    pub fn begin(&mut self, memory: &[f64]) {
        self.memory.clear();
        self.memory.extend_from_slice(memory);
        self.no_change();
    }

    /// Begins at rest under a load (N) that changes by `load_change` (N).
    pub fn rest(&mut self, law: &dyn ContactLaw, load: f64, load_change: f64) {
        self.memory.resize(law.state_len(), 0.0);
        self.no_change();
        law.set_state(0.0, load, 0.0, &mut self.memory);
        // At rest without force the memory is proportional to the load.
        law.set_state(0.0, load + 1.0, 0.0, &mut self.next);
        for ((change, next), memory) in self.change.iter_mut().zip(&self.next).zip(&self.memory) {
            *change = (next - memory) * load_change;
        }
    }

    fn no_change(&mut self) {
        let n = self.memory.len();
        for buffer in [&mut self.change, &mut self.next, &mut self.next_change] {
            buffer.resize(n, 0.0);
        }
        self.change.fill(0.0);
    }

    /// Change of the force (N) at `inputs` because of the memory alone.
    pub fn force_by_memory(&mut self, law: &dyn ContactLaw, inputs: Inputs) -> f64 {
        if self.change.iter().all(|change| *change == 0.0) {
            return 0.0;
        }
        law.state_tangents(&self.memory, inputs, &mut self.tangents);
        dot(&self.tangents.force_by_state, &self.change)
    }

    /// The step to `inputs`, which change by `by`.
    pub fn step(&mut self, law: &dyn ContactLaw, inputs: Inputs, by: Inputs) -> Change {
        let change = self.look(law, inputs, by);
        self.carry(law, inputs, by);
        change
    }

    /// As [`StateSensitivity::step`], for what it makes of memory and change alone.
    pub fn carry(&mut self, law: &dyn ContactLaw, inputs: Inputs, by: Inputs) {
        law.step_and_tangents(&self.memory, inputs, &mut self.next, &mut self.tangents);
        let (t, n) = (&self.tangents, self.memory.len());
        for row in 0..n {
            self.next_change[row] = dot(&t.next_by_state[row * n..(row + 1) * n], &self.change)
                + t.next_by_displacement[row] * by.displacement
                + t.next_by_velocity[row] * by.velocity
                + t.next_by_normal_load[row] * by.normal_load;
        }
        std::mem::swap(&mut self.memory, &mut self.next);
        std::mem::swap(&mut self.change, &mut self.next_change);
    }

    /// What becomes of the change in a step to `inputs`, which change by `by`, if it were taken.
    pub fn look(&mut self, law: &dyn ContactLaw, inputs: Inputs, by: Inputs) -> Change {
        let force = self.force(law, inputs, by);
        let (tangent, dissipated_energy) = self.differences(law, inputs, by, force);
        Change { force, tangent, dissipated_energy }
    }

    /// As [`StateSensitivity::look`], for the force (N) alone.
    pub fn force(&mut self, law: &dyn ContactLaw, inputs: Inputs, by: Inputs) -> f64 {
        let t = law.step(&self.memory, inputs, &mut self.next).tangents;
        t.displacement * by.displacement
            + t.velocity * by.velocity
            + t.normal_load * by.normal_load
            + self.force_by_memory(law, inputs)
    }

    /// Changes of ∂force/∂displacement and of the dissipated energy, beside that of the force. No law knows these
    /// derivatives: differences of steps that are exact.
    fn differences(&mut self, law: &dyn ContactLaw, inputs: Inputs, by: Inputs, force: f64) -> (f64, f64) {
        let share = |change: f64, of: f64, least: f64| change.abs() / of.abs().max(least);
        let most = share(by.displacement, inputs.displacement, SMALLEST[0])
            .max(share(by.velocity, inputs.velocity, SMALLEST[1]))
            .max(share(by.normal_load, inputs.normal_load, SMALLEST[2]));
        let by_memory = || self.change.iter().fold(0.0_f64, |most, change| most.max(change.abs()));
        let most = if most > 0.0 { most } else { by_memory() / inputs.displacement.abs().max(SMALLEST[0]) };
        if most == 0.0 {
            return (0.0, 0.0);
        }
        let span = SPAN / most;
        let mut at = |span: f64| {
            for ((at, memory), change) in self.next_change.iter_mut().zip(&self.memory).zip(&self.change) {
                *at = memory + span * change;
            }
            let inputs = Inputs {
                displacement: inputs.displacement + span * by.displacement,
                velocity: inputs.velocity + span * by.velocity,
                normal_load: inputs.normal_load + span * by.normal_load,
            };
            law.step(&self.next_change, inputs, &mut self.next)
        };
        let (ahead, here, behind) = (at(span), at(0.0), at(-span));
        // At a corner the derivatives are those of one side: the one whose force changes as the tangents say.
        let off = |after: f64, before: f64| ((after - before) / span - force).abs();
        let (off_ahead, off_behind) = (off(ahead.force, here.force), off(here.force, behind.force));
        let (after, before, between) = if off_behind > CORNER * off_ahead {
            (ahead, here, span)
        } else if off_ahead > CORNER * off_behind {
            (here, behind, span)
        } else {
            (ahead, behind, 2.0 * span)
        };
        (
            (after.tangents.displacement - before.tangents.displacement) / between,
            (after.dissipated_energy - before.dissipated_energy) / between,
        )
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
