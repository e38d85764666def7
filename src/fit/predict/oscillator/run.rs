//! One oscillator under the drives of one record.

use super::inputs::Inputs;
use crate::model::Model;
use crate::time::{Drive, SampledIntegrator};

/// Most steps from one sample to the next: a structure much faster than the sampling is not seen by it either.
const MOST_SUBSTEPS: usize = 64;

/// What is observed of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observed {
    /// Place of the mass.
    pub mass: usize,
    /// Times the displacement is differentiated.
    pub order: usize,
}

/// An integrator for one model and one record, with room for its inputs.
pub(super) struct Run<'i> {
    inputs: &'i Inputs,
    pub integrator: SampledIntegrator,
    substeps: usize,
    /// Constant normal load (N), and the share of the measured change that is added to it.
    load: (f64, f64),
    /// Whether the model has a contact of its own, which is then the first.
    contact: bool,
    drives: Vec<Drive>,
    forces: Vec<f64>,
    loads: Vec<f64>,
    accelerations: Vec<f64>,
}

impl<'i> Run<'i> {
    pub fn new(model: &Model, inputs: &'i Inputs) -> Result<Self, String> {
        let assembled = model.assembled().map_err(|error| error.to_string())?;
        let joint = model.changes().joint;
        // In stick; what is added to the structure is soft.
        let stiffest = model.contact.as_ref().map_or(0.0, |contact| contact.tangential_stiffness);
        let mut stiffness = vec![0.0; assembled.structure.contacts.len()];
        let contact = assembled.law.is_some();
        if contact {
            stiffness[0] = stiffest + joint.residual_stiffness.max(0.0);
        }
        let longest = SampledIntegrator::longest_step(&assembled.structure, &stiffness)
            .map_err(|error| error.to_string())?;
        let substeps = ((inputs.step / longest).ceil() as usize).clamp(1, MOST_SUBSTEPS);
        let (normal_load, gain) = (assembled.normal_load, joint.load_gain.unwrap_or(0.0));
        let size = assembled.structure.size;
        let structure = assembled.structure.clone();
        let rows: Vec<_> = inputs.drives.iter().map(|drive| vec![(drive.mass, 1.0)]).collect();
        let integrator = SampledIntegrator::new(
            &structure,
            assembled.into_loaded().into_iter().map(|(law, _)| law).collect(),
            &rows,
            inputs.step / substeps as f64,
        )
        .map_err(|error| error.to_string())?;
        Ok(Self {
            inputs,
            integrator,
            substeps,
            load: (normal_load, gain),
            contact,
            drives: vec![Drive::default(); rows.len()],
            forces: vec![0.0; rows.len()],
            loads: vec![0.0; structure.contacts.len()],
            accelerations: vec![0.0; size],
        })
    }

    /// Degrees of freedom, hanging masses among them.
    pub fn size(&self) -> usize {
        self.accelerations.len()
    }

    /// Normal load (N) a share `along` of the way from sample `index` to the next.
    fn load(&self, index: usize, along: f64) -> f64 {
        let (constant, gain) = self.load;
        match &self.inputs.load {
            Some(measured) if gain != 0.0 => {
                let next = measured[self.inputs.after(index)];
                constant + gain * (measured[index] + along * (next - measured[index]) - constant)
            }
            _ => constant,
        }
    }

    fn set_load(&mut self, index: usize, along: f64) {
        if self.contact {
            self.loads[0] = self.load(index, along);
        }
    }

    /// The state at rest at the first sample.
    pub fn rest(&mut self) -> Vec<f64> {
        self.set_load(0, 0.0);
        let mut state = vec![0.0; self.integrator.state_len()];
        self.integrator.rest(&self.loads, &mut state);
        state
    }

    /// The state at the first sample with these displacements (m), velocities (m/s) and contact force (N).
    pub fn begin(&mut self, displacement: &[f64], velocity: &[f64], force: f64) -> Vec<f64> {
        self.set_load(0, 0.0);
        let mut state = vec![0.0; self.integrator.state_len()];
        let mut forces = vec![0.0; self.loads.len()];
        if self.contact {
            forces[0] = force;
        }
        self.integrator.begin(displacement, velocity, &forces, &self.loads, &mut state);
        state
    }

    /// Advances `state` from sample `index` to the next.
    pub fn advance(&mut self, state: &mut [f64], index: usize) -> Result<(), String> {
        let next = self.inputs.after(index);
        let share = 1.0 / self.substeps as f64;
        for k in 0..self.substeps {
            let (from, to) = (k as f64 * share, (k + 1) as f64 * share);
            for (drive, measured) in self.drives.iter_mut().zip(&self.inputs.drives) {
                let (start, end, bow) = (measured.values[index], measured.values[next], measured.bows[index]);
                let at = |s: f64| start + (end - start) * s + bow * s * (1.0 - s);
                *drive = Drive { start: at(from), end: at(to), bow: bow * share * share };
            }
            self.set_load(index, to);
            if !self.integrator.step(state, &self.drives, &self.loads) {
                let time = index as f64 * self.inputs.step;
                return Err(format!("the motion cannot be followed beyond {time} s: it grows without bound"));
            }
        }
        Ok(())
    }

    /// Runs `state` over samples `0 .. samples − 1` and writes what is observed at each, `stride` apart.
    pub fn observe(
        &mut self,
        state: &mut [f64],
        samples: usize,
        observed: &[Observed],
        out: &mut [f64],
        stride: usize,
    ) -> Result<(), String> {
        let accelerates = observed.iter().any(|observed| observed.order == 2);
        for index in 0..samples {
            if index > 0 {
                self.advance(state, index - 1)?;
            }
            if accelerates {
                for (force, drive) in self.forces.iter_mut().zip(&self.inputs.drives) {
                    *force = drive.values[index];
                }
                self.integrator.acceleration(state, &self.forces, &mut self.accelerations);
            }
            for (channel, Observed { mass, order }) in observed.iter().enumerate() {
                out[channel * stride + index] = match order {
                    0 => self.integrator.displacement(state)[*mass],
                    1 => self.integrator.velocity(state)[*mass],
                    _ => self.accelerations[*mass],
                };
            }
        }
        Ok(())
    }

    /// Brings the contacts to where the structure now is, under the load of the first sample.
    pub fn settle(&mut self, state: &mut [f64]) {
        self.set_load(0, 0.0);
        self.integrator.settle(state, &self.loads);
    }
}
