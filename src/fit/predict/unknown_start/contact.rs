//! A contact moved as measured, with an unknown past.

use super::hypothesis::{HYPOTHESES, InitialState};
use crate::contact::ContactLaw;
use crate::data::{Channel, Record};
use crate::fit::least_squares::Parameter;
use crate::fit::predict::motion::Outside;
use crate::fit::predict::period::period;
use crate::fit::predict::sensors;
use crate::fit::predict::simulation::Simulation;
use crate::fit::predict::stepper::contact::MovedContact;
use crate::model::Model;

/// The simulation of one record of a contact; its one unknown belongs to a hypothesis of the past.
pub(in crate::fit::predict) struct ContactOfUnknownStart<'r> {
    contact: MovedContact<'r>,
    initial: InitialState,
}

impl<'r> ContactOfUnknownStart<'r> {
    /// Of `channels` of `record`.
    pub fn new(record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let contact = MovedContact::new(record, channels)?;
        let period = period(&contact.displacement.values);
        let initial = InitialState::new(&contact.displacement.values, period);
        let contact = contact.going_on(period.map_or(Outside::Straight, Outside::Periodic));
        Ok(Self { contact, initial })
    }

    /// Square error of the force over the samples that tell the start, under a hypothesis with its unknown.
    fn misfit(&self, law: &dyn ContactLaw, measured: &Measured, initial: &InitialState, value: f64) -> f64 {
        let mut stepper = self.contact.stepper(law);
        let inputs = |index| self.contact.inputs(index);
        initial.put(law, &inputs, value, &mut stepper.state);
        let square = |(index, force): (usize, &f64)| {
            (measured.gain * stepper.force(index) + measured.bias - force).powi(2)
        };
        let sum: f64 = measured.forces.iter().enumerate().map(square).sum();
        if sum.is_finite() { sum } else { f64::INFINITY }
    }
}

/// The beginning of the measured force, and how its sensor shows it.
struct Measured<'r> {
    forces: &'r [f64],
    gain: f64,
    bias: f64,
}

impl Simulation for ContactOfUnknownStart<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.contact.channels
    }

    fn is_timed(&self, channel: &Channel) -> bool {
        self.contact.is_timed(channel)
    }

    fn nuisances(&mut self, model: &Model) -> Result<Vec<Parameter>, String> {
        let law = self.contact.drive(model)?;
        let force = self.contact.channels.iter().copied().find(|channel| channel.quantity() == "force");
        let Some(force) = force else { return Ok(vec![self.initial.parameter(0.0)]) };
        let fault = sensors::fault(model, force);
        let measured = Measured {
            forces: &force.values[..self.initial.telling(force.values.len())],
            gain: fault.as_ref().map_or(1.0, |fault| fault.gain),
            bias: fault.as_ref().map_or(0.0, |fault| fault.bias),
        };
        let mut best = (f64::INFINITY, self.initial.clone(), 0.0);
        for hypothesis in HYPOTHESES {
            let mut initial = self.initial.clone();
            initial.choose(hypothesis, law.as_ref(), self.contact.load[0]);
            let mut misfit = |value| self.misfit(law.as_ref(), &measured, &initial, value);
            let value = initial.search(&mut misfit);
            let cost = misfit(value);
            if cost < best.0 {
                best = (cost, initial, value);
            }
        }
        let (_, initial, value) = best;
        self.initial = initial;
        Ok(vec![self.initial.parameter(value)])
    }

    fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        let law = self.contact.drive(model)?;
        let mut stepper = self.contact.stepper(law.as_ref());
        if let [value] = nuisances {
            let inputs = |index| self.contact.inputs(index);
            self.initial.put(law.as_ref(), &inputs, *value, &mut stepper.state);
        }
        stepper.march(out);
        Ok(())
    }
}
