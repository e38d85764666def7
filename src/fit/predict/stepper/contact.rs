//! A contact driven along a measured displacement.

use crate::contact::{ContactLaw, Inputs};
use crate::data::{Channel, Record, Regime};
use crate::fit::predict::motion::{Motion, Outside, read_at};
use crate::fit::predict::sensors;
use crate::model::Model;

/// What drives a contact through one record, and which of its forces are measured.
pub(in crate::fit::predict) struct MovedContact<'r> {
    pub channels: Vec<&'r Channel>,
    pub displacement: Motion,
    /// The measured normal load (N), smoothed.
    measured_load: Option<Motion>,
    normal_displacement: Option<Motion>,
    /// Seconds between samples, where they are even.
    step: Option<f64>,
    /// How the motion goes on outside the record, of which a late sensor shows something; a steady motion repeats.
    outside: Option<Outside>,
    /// Normal load (N) at every sample, under the model that drives it now.
    pub load: Vec<f64>,
    /// Motion and load at the moments that that model's force sensor shows, where they are not those of the samples.
    shown: Option<(Motion, Vec<f64>)>,
}

impl<'r> MovedContact<'r> {
    /// Of `record`, predicting `channels`.
    pub fn new(record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let column = |name: &str| record.channel(name).map(|channel| channel.values.as_slice());
        let values = column("displacement").ok_or("there is no `displacement` column")?;
        let motion = |values: &[f64]| match (record.sample_step(), record.time()) {
            (Some(step), _) => Ok(Motion::even(values, step)),
            (None, Some(time)) => Ok(Motion::uneven(values, time)),
            (None, None) => Err("there is no `time` column"),
        };
        let displacement = match column("velocity") {
            Some(rates) => Motion { values: values.to_vec(), rates: rates.to_vec() },
            None => motion(values)?,
        };
        Ok(Self {
            channels,
            displacement,
            measured_load: column("normal_load").map(motion).transpose()?,
            normal_displacement: column("normal_displacement").map(motion).transpose()?,
            step: record.sample_step(),
            outside: (record.regime == Regime::FromRest).then_some(Outside::StillBefore),
            load: Vec::new(),
            shown: None,
        })
    }

    /// The motion goes on like that before the record and after it.
    pub fn going_on(mut self, outside: Outside) -> Self {
        self.outside = Some(outside);
        self
    }

    /// A force shown late is the force of the earlier motion, which has a past before the record's first sample.
    pub fn is_timed(&self, channel: &Channel) -> bool {
        channel.quantity() == "force" && self.step.is_some() && self.outside.is_some()
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.displacement.values.len()
    }

    /// Prepares what the contact is driven by under `model`, and gives its law.
    pub fn drive(&mut self, model: &Model) -> Result<Box<dyn ContactLaw>, String> {
        self.update_load(model)?;
        let force = self.channels.iter().copied().find(|channel| self.is_timed(channel));
        let fault = force.and_then(|force| sensors::fault(model, force));
        self.shown = match (self.step, self.outside, fault) {
            (Some(step), Some(outside), Some(fault)) if !fault.is_on_time() => {
                let place = |index| fault.place(index, step);
                Some((self.displacement.at(place, step, outside), read_at(&self.load, place)))
            }
            _ => None,
        };
        model.law().map_err(|error| error.to_string())?.ok_or_else(|| "the model has no [contact]".to_owned())
    }

    /// The normal load at every sample.
    fn update_load(&mut self, model: &Model) -> Result<(), String> {
        let contact = model.contact.as_ref().ok_or("the model has no [contact]")?;
        let joint = model.changes().joint;
        let count = self.samples();
        self.load.clear();
        if let (true, Some(normal)) = (contact.normal_stiffness > 0.0, &self.normal_displacement) {
            let direction = model.normal_direction().map_err(|error| error.to_string())?;
            let reaction = |(approach, rate): (&f64, &f64)| match &direction {
                // A column of records counts what presses together.
                Some(direction) => direction.force(-approach, -rate),
                None => {
                    joint.normal_reaction(contact.normal_load, contact.normal_stiffness, *approach, *rate)
                }
            };
            self.load.extend(normal.values.iter().zip(&normal.rates).map(reaction));
        } else if let Some(measured) = &self.measured_load {
            let load = |measured: &f64| joint.normal_load(contact.normal_load, Some(*measured));
            self.load.extend(measured.values.iter().map(load));
        } else {
            self.load.resize(count, contact.normal_load);
        }
        Ok(())
    }

    /// What acts on the contact at a sample, after [`MovedContact::drive`].
    pub fn inputs(&self, index: usize) -> Inputs {
        let (motion, load) = match &self.shown {
            Some((motion, load)) => (motion, load),
            None => (&self.displacement, &self.load),
        };
        Inputs { displacement: motion.values[index], velocity: motion.rates[index], normal_load: load[index] }
    }

    /// The contact with `law` at the first sample, with no force where the displacement is zero.
    pub fn stepper<'s>(&'s self, law: &'s dyn ContactLaw) -> ContactStepper<'s> {
        let mut stepper = ContactStepper { contact: self, law, state: Vec::new() };
        stepper.rest();
        stepper
    }
}

/// A contact at one sample of a record.
pub(in crate::fit::predict) struct ContactStepper<'s> {
    contact: &'s MovedContact<'s>,
    law: &'s dyn ContactLaw,
    /// The state before the sample.
    pub state: Vec<f64>,
}

impl ContactStepper<'_> {
    /// Goes to the first sample, at rest there.
    fn rest(&mut self) {
        self.state.clear();
        self.state.resize(self.law.state_len(), 0.0);
        self.law.set_state(0.0, self.contact.inputs(0).normal_load, 0.0, &mut self.state);
    }

    /// The force at sample `index`; the state after it is the one before the next.
    pub fn force(&mut self, index: usize) -> f64 {
        self.law.advance(&mut self.state, self.contact.inputs(index))
    }

    /// Steps through the record and writes what each channel shows, one channel after the other.
    pub fn march(mut self, out: &mut Vec<f64>) {
        let MovedContact { channels, load, .. } = self.contact;
        let (samples, mut forces) = (self.contact.samples(), None);
        out.clear();
        out.reserve(channels.len() * samples);
        for channel in channels {
            match forces {
                _ if channel.quantity() == "normal_load" => out.extend_from_slice(load),
                Some(start) => out.extend_from_within(start..start + samples),
                None => {
                    forces = Some(out.len());
                    out.extend((0..samples).map(|index| self.force(index)));
                }
            }
        }
    }
}
