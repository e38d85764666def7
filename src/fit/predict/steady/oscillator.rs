//! An oscillator excited as measured through whole periods of a steady state.

use super::shooting::shoot;
use crate::data::{Channel, Record};
use crate::fit::predict::simulation::{Direction, Simulation};
use crate::fit::predict::stepper::march;
use crate::fit::predict::stepper::system::ExcitedSystem;
use crate::model::Model;
use crate::time::Motion;

/// The simulation of one steady record of an oscillator: one period is stepped through, the others are like it.
pub(in crate::fit::predict) struct SteadyOscillator<'r> {
    channels: Vec<&'r Channel>,
    oscillator: ExcitedSystem,
    samples: usize,
    /// Where the search for a steady state begins.
    start: Option<Motion>,
}

impl<'r> SteadyOscillator<'r> {
    /// Of `channels` of `record`, for models with the masses of `model`.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let oscillator = ExcitedSystem::new(model, record, &channels)?;
        Ok(Self { channels, oscillator, samples: record.len(), start: None })
    }

    /// Writes the predictions; returns the motion at the first sample.
    fn simulate(&self, model: &Model, out: &mut Vec<f64>) -> Result<Motion, String> {
        let mut stepper = self.oscillator.stepper(model)?;
        let period = self.oscillator.excitation.samples;
        shoot(&mut stepper, self.start.as_ref(), period)?;
        let first = stepper.motion().clone();
        let mut one = Vec::new();
        march(&mut stepper, self.channels.len(), period, &mut one)?;
        out.clear();
        for channel in one.chunks_exact(period) {
            out.extend(channel.iter().cycle().take(self.samples));
        }
        Ok(first)
    }
}

impl Simulation for SteadyOscillator<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn predict(&mut self, model: &Model, _: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        self.simulate(model, out).map(drop)
    }

    fn linearise(
        &mut self,
        model: &Model,
        _: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        self.start = Some(self.simulate(model, predictions)?);
        self.differences(directions, predictions, derivatives)
    }
}
