//! A beam excited as measured.

use super::Stepper;
use crate::data::{Channel, Record};
use crate::fit::predict::attached::Attached;
use crate::fit::predict::channels::{derivative_order, position};
use crate::model::Model;
use crate::time::{self, Integrator, Motion, Outputs, Ramp, SensorReading};

/// Tolerance of the integration, far below the noise of any sensor.
const SETTINGS: time::Settings = time::Settings { tolerance: 1e-6, step_limit: 1_000_000 };

/// What excites a beam through one record, and what is observed of it. The excitation and a measured normal load run
/// linearly from sample to sample.
pub(in crate::fit::predict) struct ExcitedBeam<'r> {
    time: &'r [f64],
    excitation: &'r [f64],
    normal_load: Option<&'r [f64]>,
    positions: Vec<f64>,
    /// Time derivative of the displacement that each channel measures.
    orders: Vec<usize>,
}

impl<'r> ExcitedBeam<'r> {
    /// Of `channels` of `record`.
    pub fn new(record: &'r Record, channels: &[&Channel]) -> Result<Self, String> {
        Ok(Self {
            positions: channels.iter().map(|channel| position(channel)).collect::<Result<_, _>>()?,
            time: record.time().ok_or("there is no `time` column")?,
            excitation: &record.channel("excitation").ok_or("there is no `excitation` column")?.values,
            normal_load: record.channel("normal_load").map(|channel| channel.values.as_slice()),
            orders: channels.iter().map(|channel| derivative_order(channel)).collect(),
        })
    }

    /// `model` at the first sample, at rest.
    pub fn stepper(&self, model: &Model) -> Result<BeamStepper<'_>, String> {
        let attached = Attached::new(model, &self.positions, None)?;
        let system = attached.system().map_err(|error| error.to_string())?;
        let mut integrator = Integrator::new(&system).map_err(|error| error.to_string())?;
        let mut inputs = integrator.held_inputs();
        self.act(&attached, 0, 0, &mut inputs);
        let motion = integrator.rest(&inputs).map_err(|error| error.to_string())?;
        let beginning = motion.clone();
        Ok(BeamStepper {
            excited: self,
            attached,
            integrator,
            inputs,
            beginning,
            motion,
            outputs: Outputs::default(),
        })
    }

    /// Writes what acts on the beam from one sample to another: excitation, normal load. What effects add knows no load.
    fn act(&self, attached: &Attached, from: usize, to: usize, inputs: &mut [Ramp]) {
        inputs[0] = Ramp { start: self.excitation[from], end: self.excitation[to] };
        if attached.has_contact() {
            inputs[1] = Ramp { start: self.load(attached, from), end: self.load(attached, to) };
        }
    }

    /// Normal load (N) at a sample.
    fn load(&self, attached: &Attached, index: usize) -> f64 {
        let measured = self.normal_load.map(|measured| measured[index]);
        attached.joint.normal_load(attached.normal_load, measured)
    }
}

/// A beam at one sample of a record.
pub(in crate::fit::predict) struct BeamStepper<'e> {
    excited: &'e ExcitedBeam<'e>,
    attached: Attached,
    integrator: Integrator,
    inputs: Vec<Ramp>,
    beginning: Motion,
    motion: Motion,
    outputs: Outputs,
}

impl Stepper for BeamStepper<'_> {
    fn rest(&mut self) {
        self.motion.clone_from(&self.beginning);
    }

    fn observe(&mut self, index: usize, out: &mut [f64]) -> Result<(), String> {
        self.excited.act(&self.attached, index, index, &mut self.inputs);
        self.integrator
            .outputs(&self.motion, f64::INFINITY, &self.inputs, &mut self.outputs)
            .map_err(|error| error.to_string())?;
        let readings = self.outputs.sensors.iter().zip(&self.excited.orders);
        for (out, (SensorReading { displacement, velocity, acceleration }, order)) in
            out.iter_mut().zip(readings)
        {
            *out = match order {
                0 => *displacement,
                1 => *velocity,
                _ => *acceleration,
            };
        }
        Ok(())
    }

    fn advance(&mut self, index: usize) -> Result<(), String> {
        self.excited.act(&self.attached, index, index + 1, &mut self.inputs);
        let step = self.excited.time[index + 1] - self.excited.time[index];
        let advanced = self.integrator.advance(&mut self.motion, step, &self.inputs, &SETTINGS);
        advanced.map(drop).map_err(|error| error.to_string())
    }
}
