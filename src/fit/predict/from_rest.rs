//! Records that begin at rest: nothing moves and nothing is remembered at the first sample.

use super::simulation::Simulation;
use super::stepper::contact::MovedContact;
use super::stepper::system::ExcitedSystem;
use super::stepper::{Stepper, march};
use crate::data::{Channel, Record};
use crate::model::{Model, Structure};

/// The simulation of one record from rest.
pub(super) struct FromRest<'r> {
    channels: Vec<&'r Channel>,
    samples: usize,
    excited: Excited<'r>,
}

/// What the record drives, by the kind of model.
enum Excited<'r> {
    Contact(MovedContact<'r>),
    System(ExcitedSystem),
}

impl<'r> FromRest<'r> {
    /// Of `channels` of `record`, for models of the kind of `model`.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let excited = match &model.structure {
            Structure::Prescribed => Excited::Contact(MovedContact::new(record, channels.clone())?),
            _ => Excited::System(ExcitedSystem::new(model, record, &channels)?),
        };
        Ok(Self { channels, samples: record.len(), excited })
    }
}

impl Simulation for FromRest<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn is_timed(&self, channel: &Channel) -> bool {
        matches!(&self.excited, Excited::Contact(contact) if contact.is_timed(channel))
    }

    fn refine(&mut self, finer: usize) {
        if let Excited::System(system) = &mut self.excited {
            system.finer = finer;
        }
    }

    fn predict(&mut self, model: &Model, _: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        match &mut self.excited {
            Excited::Contact(contact) => {
                let law = contact.drive(model)?;
                contact.stepper(law.as_ref()).march(out);
                Ok(())
            }
            Excited::System(system) => {
                let mut stepper = system.stepper(model)?;
                stepper.rest();
                march(&mut stepper, self.channels.len(), self.samples, out)
            }
        }
    }
}
