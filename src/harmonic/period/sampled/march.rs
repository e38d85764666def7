//! One period marched from sample to sample, with derivatives.

use super::{STEP_TOLERANCE, SampledCycle};
use crate::contact::{Inputs, Response};
use crate::harmonic::period::PeriodicContact;
use crate::harmonic::period::closure::add_scaled;
use crate::numeric::implicit::Implicit;

impl SampledCycle {
    /// One step from `state` to the sample `k` through the series spring; leaves `next` and what changes of its
    /// sensitivity, for [`SampledCycle::move_on`], and writes the force's sensitivity to column `column` if there is one.
    pub(super) fn step(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        k: usize,
        predicted: f64,
        column: Option<usize>,
    ) -> f64 {
        let (inputs, response) = self.step_alone(contact, angular_frequency, k, predicted);
        contact.law.state_tangents(&self.state, inputs, &mut self.tangents);
        self.carry(&response, contact.compliance, angular_frequency, k, column);
        response.force
    }

    /// As [`SampledCycle::step`], without sensitivities.
    pub(super) fn step_alone(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        k: usize,
        predicted: f64,
    ) -> (Inputs, Response) {
        let mut inputs = Inputs {
            displacement: 0.0,
            velocity: angular_frequency * self.rate[k],
            normal_load: self.load[k],
        };
        let mut implicit = Implicit::new(predicted);
        loop {
            inputs.displacement = self.displacement[k] - contact.compliance * implicit.force;
            let response = contact.law.step(&self.state, inputs, &mut self.next);
            let scale = self.force_scale.max(response.force.abs());
            let gradient = 1.0 + contact.compliance * response.tangents.displacement;
            if implicit.accept(response.force, gradient, contact.compliance, STEP_TOLERANCE * scale) {
                self.passed[k] = (inputs.displacement, response.slip_state);
                return (inputs, response);
            }
        }
    }

    /// Carries the derivatives through the step just made.
    fn carry(
        &mut self,
        response: &Response,
        compliance: f64,
        angular_frequency: f64,
        k: usize,
        column: Option<usize>,
    ) {
        let (n, wide) = (self.state_len, self.wide);
        let columns = wide + 1 + n;
        let rated =
            response.tangents.velocity != 0.0 || self.tangents.next_by_velocity.iter().any(|d| *d != 0.0);
        let functions = self.basis.functions(k);
        let (stiffness, damping) = (response.tangents.displacement, response.tangents.velocity);
        let row = &mut self.displacement_row;
        // Force at a held series spring …
        for (r, b) in row.iter_mut().zip(functions) {
            *r = stiffness * b;
        }
        row[wide..].fill(0.0);
        if rated {
            let velocity = &mut self.velocity_row;
            differentiate_functions(functions, angular_frequency, velocity);
            velocity[wide] = self.rate[k];
            velocity[wide + 1..].fill(0.0);
            row.iter_mut().zip(velocity.iter()).for_each(|(r, v)| *r += damping * v);
        }
        for (weight, source) in
            self.tangents.force_by_state.iter().zip(self.state_sensitivity.chunks_exact(columns))
        {
            add_scaled(row, *weight, source);
        }
        // … the spring gives way: dT (1 + a ∂T/∂u) is what was summed …
        let homotopy_compliance = 1.0 / (1.0 + compliance * stiffness);
        row.iter_mut().for_each(|r| *r *= homotopy_compliance);
        if let Some(column) = column {
            self.sensitivity.as_mut_slice()[column * columns..(column + 1) * columns].copy_from_slice(row);
        }
        // … and the contact moves by du − a dT.
        row.iter_mut().for_each(|r| *r *= -compliance);
        row.iter_mut().zip(functions).for_each(|(r, b)| *r += b);
        self.changed.clear();
        for (i, target) in self.next_sensitivity.chunks_exact_mut(columns).enumerate() {
            let (by_displacement, by_velocity) =
                (self.tangents.next_by_displacement[i], self.tangents.next_by_velocity[i]);
            let weights = &self.tangents.next_by_state[i * n..(i + 1) * n];
            if by_displacement == 0.0 && by_velocity == 0.0 && is_unit(weights, i) {
                continue;
            }
            self.changed.push(i);
            target.fill(0.0);
            add_scaled(target, by_displacement, row);
            if rated {
                add_scaled(target, by_velocity, &self.velocity_row);
            }
            for (weight, source) in weights.iter().zip(self.state_sensitivity.chunks_exact(columns)) {
                add_scaled(target, *weight, source);
            }
        }
    }

    /// Makes the step's end the start of the next, with its sensitivity.
    pub(super) fn move_on(&mut self) {
        let columns = self.wide + 1 + self.state_len;
        std::mem::swap(&mut self.state, &mut self.next);
        for i in &self.changed {
            let row = i * columns..(i + 1) * columns;
            self.state_sensitivity[row.clone()].copy_from_slice(&self.next_sensitivity[row]);
        }
    }

    /// Marches one period from `start`, which is the state at sample `origin`.
    pub(super) fn march(&mut self, contact: &PeriodicContact, angular_frequency: f64) {
        let (n, wide) = (self.state_len, self.wide);
        let columns = wide + 1 + n;
        self.state.copy_from_slice(&self.start);
        self.state_sensitivity.copy_from_slice(&self.start_sensitivity);
        for i in 0..n {
            self.state_sensitivity[i * columns + wide + 1..(i + 1) * columns].fill(0.0);
            self.state_sensitivity[i * columns + wide + 1 + i] = 1.0;
            self.state_scale[i] = self.start[i].abs();
        }
        self.jump.given.clear();
        self.jump.given.resize(self.samples, 0.0);
        let mut last = 0.0;
        let mut largest = 0.0_f64;
        for i in 1..=self.samples {
            let k = (self.origin + i) % self.samples;
            let known = self.force_samples[k];
            let predicted = if known.is_finite() { known } else { last };
            last = self.step(contact, angular_frequency, k, predicted, Some(k));
            self.force_samples[k] = last;
            // Behind a spring the force does not jump; nor does it right behind the farthest turning point.
            if contact.compliance == 0.0 && i > 1 {
                self.place_jump(contact, angular_frequency, k, true);
            }
            largest = largest.max(last.abs());
            self.move_on();
            for (scale, value) in self.state_scale.iter_mut().zip(&self.state) {
                *scale = scale.max(value.abs());
            }
        }
        self.force_scale = largest;
    }
}

/// Whether all but the weight of `i` itself, which is one, are zero.
fn is_unit(weights: &[f64], i: usize) -> bool {
    let zero = |weight: &f64| *weight == 0.0;
    weights[i] == 1.0 && weights[..i].iter().all(zero) && weights[i + 1..].iter().all(zero)
}

pub(in crate::harmonic::period) fn differentiate_functions(
    functions: &[f64],
    angular_frequency: f64,
    out: &mut [f64],
) {
    out[0] = 0.0;
    for h in 1..=functions.len() / 2 {
        out[2 * h - 1] = -(h as f64) * angular_frequency * functions[2 * h];
        out[2 * h] = h as f64 * angular_frequency * functions[2 * h - 1];
    }
}
