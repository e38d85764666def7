//! A structure excited as measured: a system whose ports are driven and read.

use std::f64::consts::PI;

use super::Stepper;
use super::excitation::{Excitation, MeasuredLoad, mass_of};
use crate::contact::JointChanges;
use crate::data::{Channel, Record};
use crate::fit::predict::channels::{derivative_order, position};
use crate::fit::predict::observed_system::observed_system;
use crate::model::{Model, Structure};
use crate::system::System;
use crate::time::{Integrator, Motion, Ramp, Settings, Steps};

/// Tolerance of controlled steps, far below the noise of any sensor.
const SETTINGS: Settings = Settings { tolerance: 1e-6, step_limit: 1_000_000 };
/// Most equal steps from one sample to the next: a structure much faster than the sampling is not seen by it either.
const MOST_STEPS: usize = 64;

/// What excites a structure through one record, and what is observed of it.
///
/// Forces run between samples as their band says. Those on an oscillator act on the masses that the columns `excitation:…`
/// name, and the samples set its steps: a fit repeats them a thousand times. A beam's steps are its own. A measured
/// `normal_load` counts as far as the model's effects let it.
#[derive(Debug, Clone)]
pub(in crate::fit::predict) struct ExcitedSystem {
    pub excitation: Excitation,
    pub observed: Vec<Observed>,
    /// Where the sensors of a beam are (m).
    positions: Vec<f64>,
    /// Steps in place of one, where they are equal.
    pub finer: usize,
}

/// What is observed of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::fit::predict) struct Observed {
    /// Place of the sensor: that of the mass.
    pub sensor: usize,
    /// Times the displacement is differentiated.
    pub order: usize,
}

impl ExcitedSystem {
    /// Of `channels` of `record`, for models of the kind of `model`.
    ///
    /// # Errors
    /// What the record lacks, for a reader of the comparison.
    pub fn new(model: &Model, record: &Record, channels: &[&Channel]) -> Result<Self, String> {
        let observed =
            |(sensor, channel): (usize, &&Channel)| Observed { sensor, order: derivative_order(channel) };
        let Structure::Oscillator(oscillator) = &model.structure else {
            return Ok(Self {
                positions: channels.iter().map(|channel| position(channel)).collect::<Result<_, _>>()?,
                excitation: Excitation::of_beam(record)?,
                observed: channels.iter().enumerate().map(observed).collect(),
                finer: 1,
            });
        };
        let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
        let at = |channel: &&Channel| mass_of(&channel.name, &names);
        let sensors: Vec<usize> = channels.iter().map(at).collect::<Result<_, _>>()?;
        Ok(Self {
            positions: Vec::new(),
            excitation: Excitation::of_masses(record, &names)?,
            observed: sensors.into_iter().zip(channels).map(observed).collect(),
            finer: 1,
        })
    }

    /// `model` at the first sample, at rest.
    pub fn stepper(&self, model: &Model) -> Result<SystemStepper<'_>, String> {
        let system = self.system(model)?;
        let mut integrator = Integrator::new(&system).map_err(|error| error.to_string())?;
        let steps = self.steps(model, &integrator);
        let mut inputs = integrator.held_inputs();
        let load = model.contact.map(|contact| (model.changes().joint, contact.normal_load));
        self.act(load.as_ref(), 0, 0, &mut inputs);
        let beginning = integrator.rest(&inputs).map_err(|error| error.to_string())?;
        let motion = beginning.clone();
        Ok(SystemStepper { excited: self, integrator, steps, load, inputs, beginning, motion, up: false })
    }

    fn system(&self, model: &Model) -> Result<System, String> {
        let mut system = observed_system(model, &self.positions)?;
        if matches!(model.structure, Structure::Oscillator(_)) {
            system.driven = self.excitation.forces.iter().map(|force| system.sensors[force.at]).collect();
        }
        Ok(system)
    }

    /// The steps from one sample to the next.
    fn steps(&self, model: &Model, integrator: &Integrator) -> Steps {
        if !matches!(model.structure, Structure::Oscillator(_)) {
            return Steps::Controlled(SETTINGS);
        }
        // In stick; what is added to the structure is soft.
        let beside = model.changes().joint.residual_stiffness.max(0.0);
        let stiffness = model.contact.map(|contact| contact.tangential_stiffness + beside);
        let sample_step = self.excitation.step(0);
        // Samples of a force drive nothing above half their rate, and what hangs at the contact begins with it.
        let hangs = !model.changes().structure.hanging_masses.is_empty();
        let fastest = if hangs { PI / sample_step } else { f64::INFINITY };
        let longest = integrator.longest_step(stiffness.as_slice(), fastest);
        let steps = ((sample_step / longest).ceil() as usize).clamp(1, MOST_STEPS);
        Steps::Equal(steps * self.finer)
    }

    /// Writes what acts from one sample to another: excitation, normal load. What effects add knows no load.
    fn act(&self, load: Option<&(JointChanges, f64)>, from: usize, to: usize, inputs: &mut [Ramp]) {
        let Excitation { forces, load: measured, .. } = &self.excitation;
        for (input, force) in inputs.iter_mut().zip(forces) {
            *input = force.ramp(from, to);
        }
        if let Some((joint, constant)) = load {
            let measured = measured.as_ref().filter(|_| joint.load_gain.is_some()).map(MeasuredLoad::values);
            let load = |index: usize| joint.normal_load(*constant, measured.map(|load| load[index]));
            inputs[forces.len()] = Ramp::line(load(from), load(to));
        }
    }
}

/// A structure at one sample of a record.
pub(in crate::fit::predict) struct SystemStepper<'e> {
    excited: &'e ExcitedSystem,
    integrator: Integrator,
    steps: Steps,
    /// What is changed in the contact, and its constant normal load (N).
    load: Option<(JointChanges, f64)>,
    inputs: Vec<Ramp>,
    beginning: Motion,
    motion: Motion,
    /// Whether the integrator has taken the motion up.
    up: bool,
}

impl SystemStepper<'_> {
    /// Goes to the first sample with these displacements (m), velocities (m/s) and contact force (N).
    pub fn begin(&mut self, displacement: &[f64], velocity: &[f64], force: f64) -> Result<(), String> {
        self.excited.act(self.load.as_ref(), 0, 0, &mut self.inputs);
        let forces = [force];
        let forces = if self.load.is_some() { &forces[..] } else { &[] };
        let begun = self.integrator.moving(displacement, velocity, &self.inputs, forces);
        self.set(&begun.map_err(|error| error.to_string())?);
        Ok(())
    }

    /// Degrees of freedom, hanging masses among them.
    pub fn size(&self) -> usize {
        self.motion.modes()
    }

    /// The present motion.
    pub fn motion(&mut self) -> &Motion {
        if self.up {
            self.integrator.put_down(&mut self.motion);
        }
        &self.motion
    }

    /// Goes to `motion`, at the first sample.
    pub fn set(&mut self, motion: &Motion) {
        self.motion.clone_from(motion);
        self.up = false;
    }

    /// Goes to `motion`, at the first sample, and brings the laws to where the structure is there.
    pub fn settle(&mut self, motion: &Motion) -> Result<(), String> {
        self.set(motion);
        self.excited.act(self.load.as_ref(), 0, 0, &mut self.inputs);
        self.integrator.settle(&mut self.motion, &self.inputs).map_err(|error| error.to_string())
    }

    /// Has the integrator take the motion up at sample `index`.
    fn take_up(&mut self, index: usize) -> Result<(), String> {
        if self.up {
            return Ok(());
        }
        self.up = true;
        self.excited.act(self.load.as_ref(), index, index, &mut self.inputs);
        self.integrator.take_up(&self.motion, &self.inputs).map_err(|error| error.to_string())
    }
}

impl Stepper for SystemStepper<'_> {
    fn rest(&mut self) {
        self.motion.clone_from(&self.beginning);
        self.up = false;
    }

    fn observe(&mut self, index: usize, out: &mut [f64]) -> Result<(), String> {
        self.take_up(index)?;
        let equal = matches!(self.steps, Steps::Equal(_));
        if equal && self.excited.observed.iter().any(|observed| observed.order > 1) {
            self.integrator.force_end();
        }
        for (out, Observed { sensor, order }) in out.iter_mut().zip(&self.excited.observed) {
            *out = self.integrator.sensor(*sensor, *order);
        }
        Ok(())
    }

    fn advance(&mut self, index: usize) -> Result<(), String> {
        let excitation = &self.excited.excitation;
        let (to, step) = (excitation.after(index), excitation.step(index));
        match self.steps {
            Steps::Controlled(settings) => {
                self.excited.act(self.load.as_ref(), index, to, &mut self.inputs);
                self.up = true;
                let advanced = self.integrator.advance(&mut self.motion, step, &self.inputs, &settings);
                advanced.map(drop).map_err(|error| error.to_string())
            }
            Steps::Equal(count) => {
                self.take_up(index)?;
                self.excited.act(self.load.as_ref(), index, to, self.integrator.inputs_mut());
                self.integrator.stride(step, count, |_, _| ()).map_err(|_| {
                    let time = index as f64 * step;
                    format!("the simulation stops at {time} s: the motion grows without bound")
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::data::{Channel, Record, Regime};
    use crate::fit::predict::predict;
    use crate::model::Model;

    /// Unlike dampers couple the modes.
    #[test]
    fn what_accelerometers_show_is_the_second_derivative_of_the_displacement() {
        let model = Model::parse(
            "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n\
             mass = [{ name = \"m1\", mass = 1.5 }, { name = \"m2\", mass = 1.0 }]\n\
             [[spring]]\nbetween = [\"ground\", \"m1\"]\nstiffness = 3e4\ndamping = 20.0\n\
             [[spring]]\nbetween = [\"m1\", \"m2\"]\nstiffness = 1.5e4\ndamping = 1.0\n\
             [contact]\nat = \"m2\"\nlaw = \"jenkins\"\ntangential_stiffness = 6e3\nfriction_coefficient = 1e3\n\
             normal_load = 30.0\n[[effect]]\nid = \"contact_damping\"\ndamping = 5.0\n",
        )
        .unwrap();
        let (count, step) = (600, 2e-4);
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let zeros = || vec![0.0; count];
        let mut channels = vec![
            channel("time", "s", (0..count).map(|i| step * i as f64).collect()),
            channel("excitation:m1", "N", (0..count).map(|i| 40.0 * (0.02 * i as f64).sin()).collect()),
        ];
        for mass in ["m1", "m2"] {
            channels.push(channel(&format!("displacement:{mass}"), "m", zeros()));
            channels.push(channel(&format!("acceleration:{mass}"), "m/s^2", zeros()));
        }
        let record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
        let predicted = predict(&model, &record).unwrap();
        for mass in ["m1", "m2"] {
            let [u, a] = ["displacement", "acceleration"].map(|shown| {
                let name = format!("{shown}:{mass}");
                &predicted.iter().find(|prediction| prediction.channel == name).unwrap().values
            });
            let largest = a.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
            for i in 1..count - 1 {
                let second = (u[i + 1] - 2.0 * u[i] + u[i - 1]) / (step * step);
                assert!((second - a[i]).abs() < 2e-3 * largest, "{i}: {second} {}", a[i]);
            }
        }
    }
}
