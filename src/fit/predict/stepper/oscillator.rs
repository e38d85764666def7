//! An oscillator excited as measured.

use super::Stepper;
use super::excitation::{Excitation, mass_of};
use crate::data::{Channel, Record};
use crate::fit::predict::channels::derivative_order;
use crate::model::{Model, Oscillator};
use crate::time::{Drive, SampledIntegrator};

/// Most steps from one sample to the next: a structure much faster than the sampling is not seen by it either.
const MOST_SUBSTEPS: usize = 64;

/// What excites an oscillator through one record, and what is observed of it.
///
/// Forces act on the masses that the columns `excitation:…` name, smooth between samples; a measured `normal_load`
/// counts as far as the model's effects let it.
#[derive(Debug, Clone)]
pub(in crate::fit::predict) struct ExcitedOscillator {
    pub excitation: Excitation,
    pub observed: Vec<Observed>,
    /// Masses of the model, those that hang at the contact not among them.
    pub masses: usize,
}

/// What is observed of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::fit::predict) struct Observed {
    /// Place of the mass.
    pub mass: usize,
    /// Times the displacement is differentiated.
    pub order: usize,
}

impl ExcitedOscillator {
    /// Of `channels` of `record`, for models with the masses of `oscillator`.
    ///
    /// # Errors
    /// What the record lacks, for a reader of the comparison.
    pub fn new(oscillator: &Oscillator, record: &Record, channels: &[&Channel]) -> Result<Self, String> {
        let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
        let observed = |channel: &&Channel| -> Result<Observed, String> {
            Ok(Observed { mass: mass_of(&channel.name, &names)?, order: derivative_order(channel) })
        };
        let observed = channels.iter().map(observed).collect::<Result<_, _>>()?;
        Ok(Self { observed, excitation: Excitation::new(record, &names)?, masses: names.len() })
    }

    /// `model` at the first sample, at rest.
    pub fn stepper(&self, model: &Model) -> Result<OscillatorStepper<'_>, String> {
        OscillatorStepper::new(model, self)
    }
}

/// An integrator for one model and one record, with room for its inputs.
pub(in crate::fit::predict) struct OscillatorStepper<'i> {
    oscillator: &'i ExcitedOscillator,
    integrator: SampledIntegrator,
    substeps: usize,
    /// Constant normal load (N), and the fraction of the measured change that is added to it.
    load: (f64, f64),
    /// Whether the model has a contact of its own, which is then the first.
    contact: bool,
    /// Displacements, velocities and the memory of the contacts.
    pub state: Vec<f64>,
    drives: Vec<Drive>,
    forces: Vec<f64>,
    loads: Vec<f64>,
    accelerations: Vec<f64>,
}

impl<'i> OscillatorStepper<'i> {
    fn new(model: &Model, oscillator: &'i ExcitedOscillator) -> Result<Self, String> {
        let excitation = &oscillator.excitation;
        let system = model.system().map_err(|error| error.to_string())?;
        let structure = system.linear_part();
        let joint = model.changes().joint;
        // In stick; what is added to the structure is soft.
        let mut stiffness = vec![0.0; structure.contacts.len()];
        if let Some(contact) = &model.contact {
            stiffness[0] = contact.tangential_stiffness + joint.residual_stiffness.max(0.0);
        }
        let normal_load = model.contact.as_ref().map_or(0.0, |contact| contact.normal_load);
        let longest =
            SampledIntegrator::longest_step(&structure, &stiffness).map_err(|error| error.to_string())?;
        let substeps = ((excitation.step / longest).ceil() as usize).clamp(1, MOST_SUBSTEPS);
        let gain = joint.load_gain.unwrap_or(0.0);
        let rows: Vec<_> = excitation.forces.iter().map(|force| vec![(force.mass, 1.0)]).collect();
        let integrator = SampledIntegrator::new(
            &structure,
            system.laws().map(|(_, law, _)| law.clone()).collect(),
            &rows,
            excitation.step / substeps as f64,
        )
        .map_err(|error| error.to_string())?;
        let mut stepper = Self {
            oscillator,
            integrator,
            substeps,
            load: (normal_load, gain),
            contact: model.contact.is_some(),
            drives: vec![Drive::default(); rows.len()],
            forces: vec![0.0; rows.len()],
            loads: vec![0.0; structure.contacts.len()],
            accelerations: vec![0.0; structure.size],
            state: Vec::new(),
        };
        stepper.rest();
        Ok(stepper)
    }

    /// Degrees of freedom, hanging masses among them.
    pub fn size(&self) -> usize {
        self.accelerations.len()
    }

    /// Normal load (N) a fraction `along` of the way from sample `index` to the next.
    fn load(&self, index: usize, along: f64) -> f64 {
        let (constant, gain) = self.load;
        let excitation = &self.oscillator.excitation;
        match &excitation.load {
            Some(measured) if gain != 0.0 => {
                let next = measured[excitation.after(index)];
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

    /// Goes to the first sample with these displacements (m), velocities (m/s) and contact force (N).
    pub fn begin(&mut self, displacement: &[f64], velocity: &[f64], force: f64) {
        self.set_load(0, 0.0);
        let mut forces = vec![0.0; self.loads.len()];
        if self.contact {
            forces[0] = force;
        }
        self.state.fill(0.0);
        self.integrator.begin(displacement, velocity, &forces, &self.loads, &mut self.state);
    }

    /// Brings the contacts to where the structure now is, under the load of the first sample.
    pub fn settle(&mut self) {
        self.set_load(0, 0.0);
        self.integrator.settle(&mut self.state, &self.loads);
    }
}

impl Stepper for OscillatorStepper<'_> {
    fn rest(&mut self) {
        self.set_load(0, 0.0);
        self.state.clear();
        self.state.resize(self.integrator.state_len(), 0.0);
        self.integrator.rest(&self.loads, &mut self.state);
    }

    fn observe(&mut self, index: usize, out: &mut [f64]) -> Result<(), String> {
        let ExcitedOscillator { excitation, observed, .. } = self.oscillator;
        if observed.iter().any(|observed| observed.order == 2) {
            for (force, measured) in self.forces.iter_mut().zip(&excitation.forces) {
                *force = measured.values[index];
            }
            self.integrator.acceleration(&self.state, &self.forces, &mut self.accelerations);
        }
        for (out, Observed { mass, order }) in out.iter_mut().zip(observed) {
            *out = match order {
                0 => self.integrator.displacement(&self.state)[*mass],
                1 => self.integrator.velocity(&self.state)[*mass],
                _ => self.accelerations[*mass],
            };
        }
        Ok(())
    }

    fn advance(&mut self, index: usize) -> Result<(), String> {
        let excitation = &self.oscillator.excitation;
        let next = excitation.after(index);
        let part = 1.0 / self.substeps as f64;
        for k in 0..self.substeps {
            let (from, to) = (k as f64 * part, (k + 1) as f64 * part);
            for (drive, measured) in self.drives.iter_mut().zip(&excitation.forces) {
                let (start, end, bow) = (measured.values[index], measured.values[next], measured.bows[index]);
                let at = |s: f64| start + (end - start) * s + bow * s * (1.0 - s);
                *drive = Drive { start: at(from), end: at(to), bow: bow * part * part };
            }
            self.set_load(index, to);
            if !self.integrator.step(&mut self.state, &self.drives, &self.loads) {
                let time = index as f64 * excitation.step;
                return Err(format!("the simulation stops at {time} s: the motion grows without bound"));
            }
        }
        Ok(())
    }
}
