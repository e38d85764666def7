//! A record's simulation as the sensors show it.

use super::simulation::{Direction, Seed, Simulation};
use super::{regimes, sensors};
use crate::data::Record;
use crate::fit::least_squares::Parameter;
use crate::model::Model;

/// A simulation behind its sensors.
pub(crate) struct ObservedSimulation<'r> {
    pub(super) record: &'r Record,
    pub(super) simulation: Box<dyn Simulation + 'r>,
    /// Steps in place of one, before it is refined.
    steps: usize,
}

impl<'r> ObservedSimulation<'r> {
    /// Of `record`, for models of the kind of `model`.
    pub fn new(model: &Model, record: &'r Record) -> Result<Self, String> {
        Self::near(model, record, None)
    }

    /// As [`ObservedSimulation::new`], starting from `seed`.
    pub fn near(model: &Model, record: &'r Record, seed: Option<&Seed>) -> Result<Self, String> {
        Ok(Self { record, simulation: regimes::simulation(model, record, seed)?, steps: 1 })
    }

    /// As [`Simulation::solution`].
    pub fn solution(&self) -> Option<&crate::harmonic::steady::Start> {
        self.simulation.solution()
    }

    /// Number of all predicted values.
    pub fn len(&self) -> usize {
        self.simulation.channels().iter().map(|channel| channel.values.len()).sum()
    }

    /// As [`Simulation::is_rough`].
    pub fn is_rough(&self) -> bool {
        self.simulation.is_rough()
    }

    /// As [`Simulation::nuisances`].
    pub fn nuisances(&mut self, model: &Model) -> Result<Vec<Parameter>, String> {
        self.simulation.nuisances(model)
    }

    /// The same in so many steps in place of one.
    pub fn in_steps(mut self, steps: usize) -> Self {
        self.steps = steps;
        self.refine(1);
        self
    }

    /// As [`Simulation::refine`].
    pub fn refine(&mut self, finer: usize) {
        self.simulation.refine(finer * self.steps);
    }

    /// As [`Simulation::predict`], through the sensors.
    pub fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        self.simulation.predict(model, nuisances, out)?;
        self.show(model, out)
    }

    fn show(&self, model: &Model, values: &mut [f64]) -> Result<(), String> {
        let mut rest = values;
        for channel in self.simulation.channels() {
            let length = channel.values.len();
            let (here, after) = rest.split_at_mut_checked(length).ok_or("the prediction is too short")?;
            sensors::apply(model, self.record, channel, self.simulation.is_timed(channel), here);
            rest = after;
        }
        Ok(())
    }

    /// As [`ObservedSimulation::look_around`], with an error where one of the directions cannot be predicted.
    pub fn linearise(
        &mut self,
        model: &Model,
        nuisances: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        self.look_around(model, nuisances, directions, predictions, derivatives)?;
        let lost = derivatives.iter().position(|derivative| derivative.iter().any(|x| !x.is_finite()));
        let Some(Direction { model, nuisances, .. }) = lost.map(|place| &directions[place]) else {
            return Ok(());
        };
        // What stands in the way there.
        self.predict(model, nuisances, &mut Vec::new())?;
        Err("a derivative of the predictions is not finite".to_owned())
    }

    /// As [`Simulation::linearise`], through the sensors.
    pub fn look_around(
        &mut self,
        model: &Model,
        nuisances: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        let faulty = !model.changes().sensors.is_empty()
            || directions.iter().any(|direction| !direction.model.changes().sensors.is_empty());
        if !faulty {
            return self.simulation.linearise(model, nuisances, directions, predictions, derivatives);
        }
        // The sensors act on a moved prediction, not on its derivative: a step in a delay moves it, too.
        self.simulation.linearise(model, nuisances, directions, predictions, derivatives)?;
        let plain = predictions.clone();
        self.show(model, predictions)?;
        for (direction, derivative) in directions.iter().zip(derivatives) {
            for (value, base) in derivative.iter_mut().zip(&plain) {
                *value = base + direction.step * *value;
            }
            self.show(&direction.model, derivative)?;
            for (value, base) in derivative.iter_mut().zip(&*predictions) {
                *value = (*value - base) / direction.step;
            }
        }
        Ok(())
    }
}
