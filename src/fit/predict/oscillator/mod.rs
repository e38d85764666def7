//! A lumped oscillator excited as measured.

mod inputs;
mod run;
mod start;
mod steady;

use super::channels::derivative_order;
use super::simulation::{Direction, Simulation};
use crate::data::{Channel, Record, Regime};
use crate::fit;
use crate::model::{Model, Structure};
use inputs::{Inputs, mass_of};
use run::{Observed, Run};

/// The simulation of one record of an oscillator.
///
/// Forces act on the masses that the columns `excitation:…` name, smooth between samples; a measured `normal_load`
/// counts as far as the model's effects let it.
pub(super) struct OscillatorRecord<'r> {
    channels: Vec<&'r Channel>,
    observed: Vec<Observed>,
    regime: Regime,
    /// Samples of the record.
    samples: usize,
    /// Masses of the model, those that hang at the contact not among them.
    masses: usize,
    inputs: Inputs,
    /// Where the search for a steady state begins.
    start: Option<Vec<f64>>,
}

impl<'r> OscillatorRecord<'r> {
    /// The simulation of `channels` of `record` for models with the masses of `model`.
    ///
    /// # Errors
    /// What the record lacks, for a reader of the comparison.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let Structure::Oscillator(oscillator) = &model.structure else {
            return Err("the model is not an oscillator".into());
        };
        if record.regime == Regime::Backbone {
            return Err("a backbone table of an oscillator is not compared: it does not say which mass its amplitude is \
                        held at; give the records in time, or the frequency responses that `stickslip frf` follows"
                .into());
        }
        let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
        let observed = channels.iter().map(|channel| observed(channel, &names)).collect::<Result<_, _>>()?;
        Ok(Self {
            observed,
            regime: record.regime,
            samples: record.len(),
            masses: names.len(),
            inputs: Inputs::new(record, &names)?,
            start: None,
            channels,
        })
    }

    fn run(&self, model: &Model) -> Result<Run<'_>, String> {
        Run::new(model, &self.inputs)
    }

    /// Writes the predictions; returns the state at the first sample.
    fn simulate(
        &self,
        model: &Model,
        nuisances: &[f64],
        samples: usize,
        out: &mut Vec<f64>,
    ) -> Result<Vec<f64>, String> {
        let mut run = self.run(model)?;
        out.clear();
        out.resize(self.channels.len() * samples, 0.0);
        let first = match self.regime {
            Regime::Steady => steady::periodic(&mut run, self.start.as_deref(), self.inputs.samples)?,
            Regime::UnknownInitialState if !nuisances.is_empty() => {
                start::state(&mut run, model, self.masses, nuisances)?
            }
            _ => run.rest(),
        };
        let mut state = first.clone();
        let observing = samples.min(self.inputs.samples);
        run.observe(&mut state, observing, &self.observed, out, samples)?;
        for channel in out.chunks_exact_mut(samples) {
            for index in observing..samples {
                channel[index] = channel[index - observing];
            }
        }
        Ok(first)
    }
}

fn observed(channel: &Channel, names: &[&str]) -> Result<Observed, String> {
    Ok(Observed { mass: mass_of(&channel.name, names)?, order: derivative_order(channel) })
}

impl Simulation for OscillatorRecord<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn nuisances(&mut self, model: &Model) -> Result<Vec<fit::Parameter>, String> {
        match self.regime {
            Regime::UnknownInitialState => start::search(self, model),
            _ => Ok(Vec::new()),
        }
    }

    fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        self.simulate(model, nuisances, self.samples, out).map(|_| ())
    }

    fn linearise(
        &mut self,
        model: &Model,
        nuisances: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        let first = self.simulate(model, nuisances, self.samples, predictions)?;
        if self.regime == Regime::Steady {
            self.start = Some(first);
        }
        derivatives.resize_with(directions.len(), Vec::new);
        for (direction, derivative) in directions.iter().zip(derivatives) {
            self.predict(&direction.model, &direction.nuisances, derivative)?;
            for (moved, base) in derivative.iter_mut().zip(&*predictions) {
                *moved = (*moved - base) / direction.step;
            }
        }
        Ok(())
    }
}
