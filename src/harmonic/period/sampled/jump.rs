//! A jump of the force between two samples.

use super::SampledCycle;
use super::march::differentiate_functions;
use crate::contact::{Inputs, StateTangents};
use crate::harmonic::period::PeriodicContact;
use crate::harmonic::period::closure::add_scaled;

/// How far beyond a jump the law is looked at, as a fraction of the step.
const BESIDE: f64 = 1e-6;

/// What is kept for the jumps.
#[derive(Debug, Clone, Default)]
pub(super) struct Workspace {
    /// What every sample is given (N).
    pub given: Vec<f64>,
    tangents: StateTangents,
    next: Vec<f64>,
    /// Derivatives of the place of the jump within the step, and of what it adds.
    place: Vec<f64>,
    added: Vec<f64>,
}

/// A jump of the force between two samples.
#[derive(Debug, Clone, Copy)]
struct Placed {
    /// Its place within the step.
    place: f64,
    /// Height of the jump (N), and that by the velocity (N s/m).
    height: f64,
    damping: f64,
    /// Slope of the force beside it (N/m).
    stiffness: f64,
    /// Displacement over the step (m).
    travel: f64,
}

impl SampledCycle {
    /// Samples tell of a jump only that it is between two of them. In the mean over the step it counts from its place θ
    /// on: the samples before and after it are given what the sum over samples is short of, `(½ − θ)` of the jump,
    /// in fractions that go over into those of the next step.
    ///
    /// Called after the step to the sample `k`, before the state is that there; `carried` where that step has carried
    /// its sensitivities.
    pub(super) fn place_jump(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        k: usize,
        carried: bool,
    ) {
        let before = (k + self.samples - 1) % self.samples;
        let (from, to) = (self.displacement[before], self.displacement[k]);
        let normal_load = self.load[k];
        let velocity = angular_frequency * self.rate[k];
        let at = |displacement| Inputs { displacement, velocity, normal_load };
        let Some(jump) = contact.law.jump(&self.state, at(to)) else { return };
        let damping = jump.damping.abs();
        let place = (jump.displacement - from) / (to - from);
        if !(0.0..=1.0).contains(&place) {
            return;
        }
        let Workspace { given, tangents, next, .. } = &mut self.jump;
        // The side on which the damper holds is closed: there the force tells what the place depends on.
        let closed = BESIDE * (to - from) * jump.damping.signum();
        next.resize(self.state_len, 0.0);
        let inputs = at(jump.displacement + closed);
        let response = contact.law.force_and_tangents(&self.state, inputs, next, tangents);
        let stiffness = response.tangents.displacement;
        if stiffness <= 0.0 {
            return;
        }
        let (height, short) = (damping * velocity, 0.5 - place);
        given[before] += (1.0 - place) * height * short;
        given[k] += place * height * short;
        if carried {
            let jump = Placed { place, damping, height, stiffness, travel: to - from };
            self.differentiate_jump(angular_frequency, [before, k], &jump);
        }
    }

    /// Adds what the jump gives to the sensitivities of the samples before and after it.
    fn differentiate_jump(&mut self, angular_frequency: f64, [before, k]: [usize; 2], jump: &Placed) {
        let Placed { place, damping, height, stiffness, travel } = *jump;
        let (wide, short) = (self.wide, 0.5 - place);
        let columns = wide + 1 + self.state_len;
        let Workspace { tangents, place: by_place, added, .. } = &mut self.jump;
        // θ = (u* − u₀)/(u₁ − u₀), the displacements at the samples by the coefficients alone, u* by the state.
        by_place.clear();
        by_place.resize(columns, 0.0);
        let functions = self.basis.functions(before).iter().zip(self.basis.functions(k));
        for (by_place, (earlier, later)) in by_place.iter_mut().zip(functions) {
            *by_place = -(1.0 - place) * earlier - place * later;
        }
        for (weight, row) in tangents.force_by_state.iter().zip(self.state_sensitivity.chunks_exact(columns))
        {
            add_scaled(by_place, -weight / stiffness, row);
        }
        by_place.iter_mut().for_each(|by_place| *by_place /= travel);
        differentiate_functions(self.basis.functions(k), angular_frequency, &mut self.velocity_row);
        self.velocity_row[wide] = self.rate[k];
        self.velocity_row[wide + 1..].fill(0.0);
        added.clear();
        added.extend(
            by_place
                .iter()
                .zip(&self.velocity_row)
                .map(|(by_place, by_velocity)| damping * by_velocity * short - height * by_place),
        );
        for (sample, fraction, sign) in [(before, 1.0 - place, -1.0), (k, place, 1.0)] {
            let column = &mut self.sensitivity.as_mut_slice()[sample * columns..(sample + 1) * columns];
            add_scaled(column, fraction, added);
            add_scaled(column, sign * height * short, by_place);
        }
    }
}
