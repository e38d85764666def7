//! What becomes of a small change of forces and loads over the steps of the sampled integrator.

use super::{Drive, SampledIntegrator, multiply};
use crate::contact::{Carried, Inputs};

/// A change of the motion, to first order, that goes along with it from step to step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Followed {
    /// Changes of displacements (m) and velocities (m/s).
    pub motion: Vec<f64>,
    /// Of the contact forces (N).
    pub force: Vec<f64>,
    /// Of the energy dissipated in each contact (J).
    pub dissipated_energy: Vec<f64>,
    rate: Vec<f64>,
    laws: Vec<Carried>,
    known: Vec<f64>,
    moved: Vec<f64>,
    free: Vec<(f64, f64)>,
    matrix: Vec<f64>,
    bow: Vec<f64>,
}

impl SampledIntegrator {
    /// No change yet of the motion in `state`.
    pub(crate) fn begin_change(&self, state: &[f64], followed: &mut Followed) {
        let (n, contacts) = (self.plant.size, self.laws.len());
        let memory = &state[2 * n + 2 * contacts..];
        let zeros = |buffer: &mut Vec<f64>, length: usize| {
            buffer.clear();
            buffer.resize(length, 0.0);
        };
        zeros(&mut followed.motion, 2 * n);
        zeros(&mut followed.moved, 2 * n);
        zeros(&mut followed.known, self.known.len());
        for buffer in
            [&mut followed.force, &mut followed.rate, &mut followed.bow, &mut followed.dissipated_energy]
        {
            zeros(buffer, contacts);
        }
        zeros(&mut followed.matrix, contacts * contacts);
        followed.laws.resize(contacts, Carried::default());
        for (i, carried) in followed.laws.iter_mut().enumerate() {
            carried.begin(self.balance.part(memory, i));
        }
    }

    /// [`SampledIntegrator::settle`], with loads that change by `load_changes` (N).
    pub(crate) fn settle_change(
        &mut self,
        state: &mut [f64],
        loads: &[f64],
        load_changes: &[f64],
        followed: &mut Followed,
    ) {
        self.settle(state, loads);
        for (i, law) in self.laws.iter().enumerate() {
            let motion = |motion: &[f64], from: usize| self.along(i, &motion[from..]);
            let n = self.plant.size;
            let at = |values: &[f64], normal_load: f64| Inputs {
                displacement: motion(values, 0),
                velocity: motion(values, n),
                normal_load,
            };
            let by = at(&followed.motion, load_changes[i]);
            let change = followed.laws[i].step(law.as_ref(), at(state, loads[i]), by);
            followed.force[i] = change.force;
            followed.dissipated_energy[i] += change.dissipated_energy;
            followed.rate[i] = self.balance.responses[i].tangents.displacement * by.velocity
                + change.tangent * motion(state, n);
        }
    }

    /// [`SampledIntegrator::step`], with drives that change by `drive_changes` and loads by `load_changes` (N).
    pub(crate) fn step_change(
        &mut self,
        state: &mut [f64],
        (drives, drive_changes): (&[Drive], &[Drive]),
        (loads, load_changes): (&[f64], &[f64]),
        followed: &mut Followed,
    ) -> bool {
        if !self.step(state, drives, loads) {
            return false;
        }
        let (n, contacts) = (self.plant.size, self.laws.len());
        let Followed { motion, force, rate, known, moved, free, matrix, bow, laws, dissipated_energy } =
            followed;
        let (before, after) = known.split_at_mut(2 * n);
        before.copy_from_slice(motion);
        let (driven, forced) = after.split_at_mut(3 * self.drives);
        for (known, Drive { start, end, bow }) in driven.chunks_exact_mut(3).zip(drive_changes) {
            known.copy_from_slice(&[*start, *end, *bow]);
        }
        forced.copy_from_slice(force);
        multiply(&self.hold.free, known, motion);
        if contacts == 0 {
            return true;
        }
        free.clear();
        free.extend((0..contacts).map(|i| (self.along(i, motion), self.along(i, &motion[n..]))));
        let forces = &state[2 * n..2 * n + contacts];
        let compliance = |i: usize| &self.hold.compliance[i * contacts..(i + 1) * contacts];
        let mobility = |i: usize| &self.hold.mobility[i * contacts..(i + 1) * contacts];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let inputs = |i: usize| Inputs {
            displacement: self.balance.free[i].0 - dot(compliance(i), forces),
            velocity: self.balance.free[i].1 - dot(mobility(i), forces),
            normal_load: loads[i],
        };
        let tangents = |i: usize| self.balance.responses[i].tangents;
        for (i, law) in self.laws.iter().enumerate() {
            let t = tangents(i);
            force[i] = t.displacement * free[i].0
                + t.velocity * free[i].1
                + t.normal_load * load_changes[i]
                + laws[i].force_by_memory(law.as_ref(), inputs(i));
            for j in 0..contacts {
                let unit = if i == j { 1.0 } else { 0.0 };
                matrix[i * contacts + j] =
                    unit + t.displacement * compliance(i)[j] + t.velocity * mobility(i)[j];
            }
        }
        if !crate::time::solve::solve(matrix, force) {
            return false;
        }
        for (i, law) in self.laws.iter().enumerate() {
            let by = Inputs {
                displacement: free[i].0 - dot(compliance(i), force),
                velocity: free[i].1 - dot(mobility(i), force),
                normal_load: load_changes[i],
            };
            let change = laws[i].step(law.as_ref(), inputs(i), by);
            dissipated_energy[i] += change.dissipated_energy;
            let rate_after = tangents(i).displacement * by.velocity + change.tangent * inputs(i).velocity;
            bow[i] = 0.5 * self.step * (rate[i] - rate_after);
            rate[i] = rate_after;
        }
        for (operator, by) in [(&self.hold.by_end, &*force), (&self.hold.by_bow, &*bow)] {
            multiply(operator, by, moved);
            motion.iter_mut().zip(&*moved).for_each(|(motion, moved)| *motion += moved);
        }
        motion.iter().all(|value| value.is_finite())
    }

    /// The part of `freedoms`, one number per degree of freedom, that contact `i` sees.
    pub(crate) fn along(&self, i: usize, freedoms: &[f64]) -> f64 {
        self.rows[i].iter().map(|(j, b)| b * freedoms[*j]).sum()
    }

    /// Rates of the contact forces (N/s) with tangents by displacement, velocity and load, at velocities (m/s) and accelerations (m/s²) of the degrees
    /// of freedom, under loads that change at `load_rates` (N/s).
    pub(crate) fn force_rates(
        &self,
        tangents: &[[f64; 3]],
        (velocity, acceleration): (&[f64], &[f64]),
        load_rates: &[f64],
        out: &mut [f64],
    ) {
        for (i, (out, [displacement, speed, load])) in out.iter_mut().zip(tangents).enumerate() {
            *out = displacement * self.along(i, velocity)
                + speed * self.along(i, acceleration)
                + load * load_rates[i];
        }
    }
}
