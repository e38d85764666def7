//! An oscillator excited as measured through whole periods of a steady state.

use super::oscillator_balance::BalancedOscillator;
use super::shooting::ShotOscillator;
use crate::data::{Channel, Record};
use crate::fit::predict::simulation::{Direction, Simulation};
use crate::model::Model;

/// The simulation of one steady record of an oscillator.
pub(in crate::fit::predict) struct SteadyOscillator<'r> {
    channels: Vec<&'r Channel>,
    solver: Solver,
}

enum Solver {
    Balance(Box<BalancedOscillator>),
    Shooting(Box<ShotOscillator>),
}

impl<'r> SteadyOscillator<'r> {
    /// Of `channels` of `record`, for models with the masses of `model`: balanced where the balance resolves the response
    /// of `model`, else shot at.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let solver = match BalancedOscillator::new(model, record, &channels) {
            Ok(balance) => Solver::Balance(Box::new(balance)),
            Err(_) => Solver::Shooting(Box::new(ShotOscillator::new(model, record, &channels)?)),
        };
        Ok(Self { channels, solver })
    }
}

impl Simulation for SteadyOscillator<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn predict(&mut self, model: &Model, _: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        match &mut self.solver {
            Solver::Balance(balance) => balance.predict(model, out).map_err(|error| error.to_string()),
            Solver::Shooting(shooting) => shooting.simulate(model, out).map(drop),
        }
    }

    fn linearise(
        &mut self,
        model: &Model,
        _: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        match &mut self.solver {
            Solver::Balance(balance) => {
                balance.settle(model, predictions).map_err(|error| error.to_string())?;
            }
            Solver::Shooting(shooting) => shooting.settle(model, predictions)?,
        }
        self.differences(directions, predictions, derivatives)
    }
}
