//! The contact forces at the end of a step, which fit the motion that they themselves change.

use std::sync::Arc;

use super::hold::Hold;
use crate::contact::{ContactLaw, Inputs, Response, SlipState, Tangents};
use crate::time::solve::solve;

/// Newton steps before the balance is given up.
const NEWTON: usize = 60;
/// Residual accepted, as a fraction of the forces: far below the steps of finite differences.
const BALANCED: f64 = 1e-12;
/// Halvings of a Newton step that makes matters worse, with several contacts.
const HALVINGS: usize = 8;

/// Room for the balance of a step.
#[derive(Debug)]
pub(super) struct Balance {
    /// Where the memory of each law begins, and the length of all.
    offsets: Vec<usize>,
    next: Vec<f64>,
    /// Displacement and velocity of each contact without the forces at the end of the step.
    pub free: Vec<(f64, f64)>,
    pub responses: Vec<Response>,
    /// Bow of each contact force over the step, as [`super::Drive::bow`].
    pub bow: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
    correction: Vec<f64>,
    base: Vec<f64>,
    direction: Vec<f64>,
    matrix: Vec<f64>,
}

const NOTHING: Response = Response {
    force: 0.0,
    tangents: Tangents { displacement: 0.0, velocity: 0.0, normal_load: 0.0 },
    dissipated_energy: 0.0,
    slip_state: SlipState::Stick,
};

impl Balance {
    pub fn new(laws: &[Arc<dyn ContactLaw>]) -> Self {
        let mut offsets = vec![0];
        offsets.extend(laws.iter().scan(0, |sum, law| {
            *sum += law.state_len();
            Some(*sum)
        }));
        let count = laws.len();
        Self {
            next: vec![0.0; offsets[count]],
            offsets,
            free: Vec::with_capacity(count),
            responses: vec![NOTHING; count],
            bow: vec![0.0; count],
            velocity: vec![0.0; count],
            force: vec![0.0; count],
            correction: vec![0.0; count],
            base: vec![0.0; count],
            direction: vec![0.0; count],
            matrix: vec![0.0; count * count],
        }
    }

    pub fn memory_len(&self) -> usize {
        self.next.len()
    }

    /// The part of `memory` that is law `i`'s.
    pub fn part<'m>(&self, memory: &'m [f64], i: usize) -> &'m [f64] {
        &memory[self.offsets[i]..self.offsets[i + 1]]
    }

    /// Calls `visit` with every law, its part of `memory` and its place.
    pub fn remember(
        &self,
        laws: &[Arc<dyn ContactLaw>],
        memory: &mut [f64],
        mut visit: impl FnMut(&dyn ContactLaw, &mut [f64], usize),
    ) {
        for (i, law) in laws.iter().enumerate() {
            visit(law.as_ref(), &mut memory[self.offsets[i]..self.offsets[i + 1]], i);
        }
    }

    /// One step of every law to the inputs that `inputs` gives it.
    pub fn settle(
        &mut self,
        laws: &[Arc<dyn ContactLaw>],
        memory: &mut [f64],
        inputs: impl Fn(usize) -> Inputs,
    ) {
        for (i, law) in laws.iter().enumerate() {
            let place = self.offsets[i]..self.offsets[i + 1];
            self.responses[i] = law.step(&memory[place.clone()], inputs(i), &mut self.next[place]);
        }
        memory.copy_from_slice(&self.next);
    }

    /// Finds the forces at the end of a step of `h` (s) and puts forces, rates and memories in the place of those at
    /// its start.
    pub fn find(
        &mut self,
        laws: &[Arc<dyn ContactLaw>],
        hold: &Hold,
        (force, rate): (&mut [f64], &mut [f64]),
        memory: &mut [f64],
        loads: &[f64],
        h: f64,
    ) -> bool {
        for (i, guess) in self.force.iter_mut().enumerate() {
            *guess = force[i] + h * rate[i];
        }
        let found = match laws {
            [law] => self.find_one(law.as_ref(), hold, memory, loads[0]),
            _ => self.find_all(laws, hold, memory, loads),
        };
        for (i, response) in self.responses.iter().enumerate() {
            // The load runs linearly: what it changes does not bend the force.
            let after = response.tangents.displacement * self.velocity[i];
            self.bow[i] = 0.5 * h * (rate[i] - after);
            rate[i] = after;
            force[i] = self.force[i];
        }
        memory.copy_from_slice(&self.next);
        found
    }

    /// One contact: the residual falls with the force, so that a bracket closes in on its zero.
    fn find_one(&mut self, law: &dyn ContactLaw, hold: &Hold, memory: &[f64], load: f64) -> bool {
        let (compliance, mobility, free) = (hold.compliance[0], hold.mobility[0], self.free[0]);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut force = self.force[0];
        for _ in 0..NEWTON {
            let inputs = Inputs {
                displacement: free.0 - compliance * force,
                velocity: free.1 - mobility * force,
                normal_load: load,
            };
            let response = law.step(memory, inputs, &mut self.next);
            let residual = response.force - force;
            (self.responses[0], self.velocity[0], self.force[0]) = (response, inputs.velocity, force);
            if residual.abs() <= BALANCED * size(&response, force, &inputs) {
                return true;
            }
            if residual > 0.0 {
                low = force
            } else {
                high = force
            }
            let Tangents { displacement, velocity, .. } = response.tangents;
            let slope = 1.0 + displacement * compliance + velocity * mobility;
            let next = force + residual / slope;
            force = if slope > 0.0 && next > low && next < high {
                next
            } else if low.is_finite() && high.is_finite() {
                0.5 * (low + high)
            } else {
                // Steeper than it should be, and only one end known: away from it.
                force + 2.0 * residual
            };
            if force == self.force[0] {
                return true;
            }
            if !force.is_finite() {
                return false;
            }
        }
        // A jump in the law: the bracket has closed in on it.
        low.is_finite() && high.is_finite()
    }

    /// Residuals of all contacts at `self.force`; the largest over its size.
    fn residuals(&mut self, laws: &[Arc<dyn ContactLaw>], hold: &Hold, memory: &[f64], loads: &[f64]) -> f64 {
        let count = laws.len();
        let mut largest = 0.0_f64;
        let mut sizes = 0.0_f64;
        for (i, law) in laws.iter().enumerate() {
            let along = |matrix: &[f64]| -> f64 {
                matrix[i * count..(i + 1) * count].iter().zip(&self.force).map(|(a, f)| a * f).sum()
            };
            let inputs = Inputs {
                displacement: self.free[i].0 - along(&hold.compliance),
                velocity: self.free[i].1 - along(&hold.mobility),
                normal_load: loads[i],
            };
            let place = self.offsets[i]..self.offsets[i + 1];
            let response = law.step(&memory[place.clone()], inputs, &mut self.next[place]);
            self.velocity[i] = inputs.velocity;
            self.responses[i] = response;
            self.correction[i] = response.force - self.force[i];
            largest = largest.max(self.correction[i].abs());
            sizes = sizes.max(size(&response, self.force[i], &inputs));
            if !self.correction[i].is_finite() {
                return f64::NAN;
            }
        }
        if largest == 0.0 { 0.0 } else { largest / sizes }
    }

    fn find_all(&mut self, laws: &[Arc<dyn ContactLaw>], hold: &Hold, memory: &[f64], loads: &[f64]) -> bool {
        let count = laws.len();
        let mut worst = self.residuals(laws, hold, memory, loads);
        for _ in 0..NEWTON {
            if worst <= BALANCED {
                return true;
            }
            for i in 0..count {
                let Tangents { displacement, velocity, .. } = self.responses[i].tangents;
                for j in 0..count {
                    let k = i * count + j;
                    let unit = if i == j { 1.0 } else { 0.0 };
                    self.matrix[k] = unit + displacement * hold.compliance[k] + velocity * hold.mobility[k];
                }
            }
            if !solve(&mut self.matrix, &mut self.correction) {
                return false;
            }
            self.base.copy_from_slice(&self.force);
            self.direction.copy_from_slice(&self.correction);
            let mut share = 1.0;
            for _ in 0..HALVINGS {
                for (i, force) in self.force.iter_mut().enumerate() {
                    *force = self.base[i] + share * self.direction[i];
                }
                let now = self.residuals(laws, hold, memory, loads);
                let better = now < worst;
                worst = now;
                if better || now <= BALANCED {
                    break;
                }
                share *= 0.5;
            }
        }
        worst <= BALANCED.sqrt()
    }
}

/// What a residual is measured by: the forces, and the rounding of the displacement in them.
fn size(response: &Response, force: f64, inputs: &Inputs) -> f64 {
    response.force.abs() + force.abs() + (response.tangents.displacement * inputs.displacement).abs()
}
