//! A fast integrator of fixed steps for identification: the structure exactly, contact forces as parabolas.

mod balance;
mod followed;
mod hold;
#[cfg(test)]
mod tests;

pub(crate) use followed::Followed;
pub use hold::MOST_STEPPED;

use std::sync::Arc;

use super::OscillatorError;
use super::exact::system::System;
use crate::contact::{ContactLaw, Inputs, Response};
use crate::system::{LinearStructure, Row};
use balance::Balance;
use hold::{Hold, Plant};

/// Radians of the fastest motion, contacts in stick, that a step may last; see [`SampledIntegrator::longest_step`].
const STEP_ANGLE: f64 = 0.2;

/// A force over a step: the parabola `start + (end − start) s + bow · s (1 − s)`, s from 0 to 1 (N).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// At the start.
    pub start: f64,
    /// At the end.
    pub end: f64,
    /// Four times its height above the straight line at the middle.
    pub bow: f64,
}

impl Drive {
    /// On a straight line.
    pub fn line(start: f64, end: f64) -> Self {
        Self { start, end, bow: 0.0 }
    }
}

/// Integrates a [`LinearStructure`] with contacts of any law by steps of one length.
///
/// A step is exact for the structure and for forces that are parabolas over it. Those of the contacts have the
/// ends that the laws give, found together with the motion by Newton's method, and the bow that the laws' rates of
/// change at the two ends have: the error is of order four while every force is smooth, and of order two
/// over stick and slip, where a corner in the force falls somewhere into a step. For one contact the balance of
/// forces is bracketed and cannot fail.
///
/// The state is a slice that the caller owns, as that of a [`ContactLaw`]: nothing is kept between steps but the
/// operators of the step's length. No allocation within a step.
///
/// ```
/// use stickslip::contact::{ContactLaw, Jenkins};
/// use stickslip::time::{Drive, SampledIntegrator};
/// use stickslip::system::LinearStructure;
///
/// let structure = LinearStructure {
///     size: 1,
///     mass: vec![(0, 0, 1.0)],
///     damping: vec![(0, 0, 0.1)],
///     stiffness: vec![(0, 0, 1.0)],
///     contacts: vec![vec![(0, 1.0)]],
///     excitation: vec![(0, 1.0)],
///     outputs: Vec::new(),
/// };
/// let law: std::sync::Arc<dyn ContactLaw> = std::sync::Arc::new(Jenkins::new(3.0, 0.5)?);
/// let mut integrator = SampledIntegrator::new(&structure, vec![law], &[vec![(0, 1.0)]], 0.05)?;
/// let mut state = vec![0.0; integrator.state_len()];
/// integrator.rest(&[1.0], &mut state);
/// for _ in 0..1000 {
///     assert!(integrator.step(&mut state, &[Drive::line(2.0, 2.0)], &[1.0]));
/// }
/// // The slider carries no more than 0.5 N: the spring keeps the rest, or what friction locks in.
/// assert!((integrator.displacement(&state)[0] - 2.0).abs() <= 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SampledIntegrator {
    plant: Plant,
    laws: Vec<Arc<dyn ContactLaw>>,
    rows: Vec<Row>,
    drives: usize,
    step: f64,
    hold: Hold,
    acceleration: Vec<f64>,
    /// What the free motion is made from: displacements, velocities, drives, forces at the start.
    known: Vec<f64>,
    moved: Vec<f64>,
    balance: Balance,
}

impl SampledIntegrator {
    /// An integrator of `structure` with one law per contact, forces along the rows `drives` (the structure's own
    /// excitation is not among them unless it is listed), and steps of `step` (s).
    ///
    /// # Errors
    /// A structure without mass somewhere, with entries out of place or with more than [`MOST_STEPPED`] degrees of
    /// freedom; not one law per contact; a step that is not above zero.
    pub fn new(
        structure: &LinearStructure,
        laws: Vec<Arc<dyn ContactLaw>>,
        drives: &[Row],
        step: f64,
    ) -> Result<Self, OscillatorError> {
        let (expected, found) = (structure.contacts.len(), laws.len());
        if expected != found {
            return Err(OscillatorError::Length { name: "contacts", expected, found });
        }
        let plant = Plant::new(structure, drives)?;
        let mut integrator = Self {
            acceleration: plant.acceleration(),
            rows: structure.contacts.clone(),
            drives: drives.len(),
            step: 0.0,
            hold: Hold::default(),
            known: vec![0.0; 2 * plant.size + 3 * drives.len() + found],
            moved: vec![0.0; 2 * plant.size],
            balance: Balance::new(&laws),
            plant,
            laws,
        };
        integrator.set_step(step)?;
        Ok(integrator)
    }

    /// Changes the length of the steps (s).
    ///
    /// # Errors
    /// A step that is not above zero, or too long for numbers.
    pub fn set_step(&mut self, step: f64) -> Result<(), OscillatorError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(OscillatorError::Input { name: "step", value: step });
        }
        if step != self.step {
            self.hold = self.plant.hold(step)?;
            self.step = step;
        }
        Ok(())
    }

    /// The longest step (s) that resolves the motion of `structure` with springs of `stiffness` (N/m) at its
    /// contacts, in stick as a rule. With a corner in the contact force at every reversal, the error is then some 1e-4
    /// of the motion.
    ///
    /// # Errors
    /// As [`SampledIntegrator::new`].
    pub fn longest_step(structure: &LinearStructure, stiffness: &[f64]) -> Result<f64, OscillatorError> {
        // `System` allows 2 radians.
        Ok(System::new(structure)?.longest_step(stiffness, 0.0) * (0.5 * STEP_ANGLE))
    }

    /// Length of the state: displacements, velocities, contact forces and their rates, and what the laws remember.
    pub fn state_len(&self) -> usize {
        2 * self.plant.size + 2 * self.laws.len() + self.balance.memory_len()
    }

    /// Displacements of the degrees of freedom (m) in a state.
    pub fn displacement<'s>(&self, state: &'s [f64]) -> &'s [f64] {
        &state[..self.plant.size]
    }

    /// Velocities of the degrees of freedom (m/s) in a state.
    pub fn velocity<'s>(&self, state: &'s [f64]) -> &'s [f64] {
        &state[self.plant.size..2 * self.plant.size]
    }

    /// Restoring forces of the contacts (N) in a state.
    pub fn contact_forces<'s>(&self, state: &'s [f64]) -> &'s [f64] {
        &state[2 * self.plant.size..2 * self.plant.size + self.laws.len()]
    }

    /// What the laws answered at the end of the last step.
    pub fn responses(&self) -> &[Response] {
        &self.balance.responses
    }

    /// Writes the state at rest without any force, under the normal loads `loads` (N); the contacts remember nothing.
    pub fn rest(&self, loads: &[f64], state: &mut [f64]) {
        state.fill(0.0);
        let memory = &mut state[2 * self.plant.size + 2 * self.laws.len()..];
        self.balance.remember(&self.laws, memory, |law, memory, i| law.set_state(0.0, loads[i], 0.0, memory));
    }

    /// Writes the state with these displacements (m) and velocities (m/s), in which the contacts carry `forces` (N),
    /// or as much of them as they can.
    pub fn begin(
        &self,
        displacement: &[f64],
        velocity: &[f64],
        forces: &[f64],
        loads: &[f64],
        state: &mut [f64],
    ) {
        let (n, contacts) = (self.plant.size, self.laws.len());
        state[..n].copy_from_slice(displacement);
        state[n..2 * n].copy_from_slice(velocity);
        let along = |row: &Row, from: &[f64]| row.iter().map(|(i, b)| b * from[*i]).sum::<f64>();
        let (dynamic, memory) = state[2 * n..].split_at_mut(2 * contacts);
        self.balance.remember(&self.laws, memory, |law, memory, i| {
            let (u, v) = (along(&self.rows[i], displacement), along(&self.rows[i], velocity));
            law.set_state(u, loads[i], forces[i], memory);
            // The force it really carries there, and how fast that changes.
            let inputs = Inputs { displacement: u, velocity: v, normal_load: loads[i] };
            let mut unused = vec![0.0; memory.len()];
            let response = law.step(memory, inputs, &mut unused);
            dynamic[i] = response.force;
            dynamic[contacts + i] = response.tangents.displacement * v;
        });
    }

    /// Moves the contacts at once to where the structure of `state` now stands, after it was changed by hand.
    pub fn settle(&mut self, state: &mut [f64], loads: &[f64]) {
        let (n, contacts) = (self.plant.size, self.laws.len());
        let (motion, rest) = state.split_at_mut(2 * n);
        let (dynamic, memory) = rest.split_at_mut(2 * contacts);
        self.balance.settle(&self.laws, memory, |i| {
            let along = |from: usize| self.rows[i].iter().map(|(j, b)| b * motion[from + j]).sum::<f64>();
            Inputs { displacement: along(0), velocity: along(n), normal_load: loads[i] }
        });
        for (i, response) in self.balance.responses.iter().enumerate() {
            let velocity: f64 = self.rows[i].iter().map(|(j, b)| b * motion[n + j]).sum();
            dynamic[i] = response.force;
            dynamic[contacts + i] = response.tangents.displacement * velocity;
        }
    }

    /// One step of `state` under one drive per row and the normal loads `loads` (N) reached at its end. False where
    /// the forces find no balance or the motion leaves all bounds: the state is then lost.
    pub fn step(&mut self, state: &mut [f64], drives: &[Drive], loads: &[f64]) -> bool {
        let (n, contacts) = (self.plant.size, self.laws.len());
        let (motion, memory) = state.split_at_mut(2 * n + 2 * contacts);
        let (motion, rest) = motion.split_at_mut(2 * n);
        let (force, rate) = rest.split_at_mut(contacts);
        let (before, after) = self.known.split_at_mut(2 * n);
        before.copy_from_slice(motion);
        let (driven, forced) = after.split_at_mut(3 * self.drives);
        for (known, Drive { start, end, bow }) in driven.chunks_exact_mut(3).zip(drives) {
            known.copy_from_slice(&[*start, *end, *bow]);
        }
        forced.copy_from_slice(force);
        multiply(&self.hold.free, &self.known, motion);
        if contacts > 0 {
            self.balance.free.clear();
            for row in &self.rows {
                let along = |from: usize| row.iter().map(|(i, b)| b * motion[from + i]).sum::<f64>();
                self.balance.free.push((along(0), along(n)));
            }
            let found = self.balance.find(&self.laws, &self.hold, (force, rate), memory, loads, self.step);
            if !found {
                return false;
            }
            multiply(&self.hold.by_end, force, &mut self.moved);
            motion.iter_mut().zip(&self.moved).for_each(|(motion, moved)| *motion += moved);
            multiply(&self.hold.by_bow, &self.balance.bow, &mut self.moved);
            motion.iter_mut().zip(&self.moved).for_each(|(motion, moved)| *motion += moved);
        }
        motion.iter().all(|value| value.is_finite())
    }

    /// Accelerations of the degrees of freedom (m/s²) in a state under the drives' present values (N).
    pub fn acceleration(&mut self, state: &[f64], drives: &[f64], out: &mut [f64]) {
        let (n, contacts) = (self.plant.size, self.laws.len());
        let known = &mut self.known[..2 * n + self.drives + contacts];
        known[..2 * n].copy_from_slice(&state[..2 * n]);
        known[2 * n..2 * n + self.drives].copy_from_slice(drives);
        known[2 * n + self.drives..].copy_from_slice(&state[2 * n..2 * n + contacts]);
        multiply(&self.acceleration, known, out);
    }
}

/// `out = matrix · by`, the matrix row by row.
fn multiply(matrix: &[f64], by: &[f64], out: &mut [f64]) {
    for (out, row) in out.iter_mut().zip(matrix.chunks_exact(by.len())) {
        *out = row.iter().zip(by).map(|(a, b)| a * b).sum();
    }
}
