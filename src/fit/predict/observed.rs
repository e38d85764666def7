//! A record's simulation as the sensors show it, and the start that fits it best.

use super::simulation::{Direction, Seed, Simulation};
use super::{channels, sensors, simulation};
use crate::data::Record;
use crate::fit::{self, Coordinate, Limits, SumOfSquares, Sums, minimise};
use crate::model::Model;

/// A simulation behind its sensors.
pub(crate) struct ObservedSimulation<'r> {
    record: &'r Record,
    simulation: Box<dyn Simulation + 'r>,
}

/// Step of differences in a nuisance, in its coordinate of size one.
pub(crate) const NUISANCE_STEP: f64 = 1e-5;

impl<'r> ObservedSimulation<'r> {
    /// Of `record`, for models of the kind of `model`.
    pub fn new(model: &Model, record: &'r Record) -> Result<Self, String> {
        Self::near(model, record, None)
    }

    /// As [`ObservedSimulation::new`], starting from `seed`.
    pub fn near(model: &Model, record: &'r Record, seed: Option<&Seed>) -> Result<Self, String> {
        Ok(Self { record, simulation: simulation::of(model, record, seed)? })
    }

    /// As [`Simulation::solution`].
    pub fn solution(&self) -> Option<&crate::harmonic::steady::Start> {
        self.simulation.solution()
    }

    /// Number of all predicted values.
    pub fn len(&self) -> usize {
        self.simulation.channels().iter().map(|channel| channel.values.len()).sum()
    }

    /// As [`Simulation::nuisances`].
    pub fn nuisances(&mut self, model: &Model) -> Result<Vec<fit::Parameter>, String> {
        self.simulation.nuisances(model)
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
            sensors::apply(model, self.record, channel, !self.simulation.shows_delay(channel), here);
            rest = after;
        }
        Ok(())
    }

    /// As [`Simulation::linearise`], through the sensors.
    pub fn linearise(
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

    /// The nuisances that fit the whole record best under `model`.
    pub fn settle(&mut self, model: &Model) -> Result<Vec<f64>, String> {
        let nuisances = self.nuisances(model)?;
        if nuisances.is_empty() {
            return Ok(Vec::new());
        }
        let mut measured = Vec::with_capacity(self.len());
        let mut weights = Vec::with_capacity(self.len());
        for channel in self.simulation.channels() {
            let weight = 1.0 / channels::deviation(channel)?;
            measured.extend_from_slice(&channel.values);
            weights.extend(channel.values.iter().map(|_| weight));
        }
        Ok(self.settle_from(model, &nuisances, &measured, &weights))
    }

    /// As [`ObservedSimulation::settle`], from given starts and with the weights of the channels' samples.
    pub fn settle_from(
        &mut self,
        model: &Model,
        nuisances: &[fit::Parameter],
        measured: &[f64],
        weights: &[f64],
    ) -> Vec<f64> {
        let coordinates: Vec<Coordinate> = nuisances
            .iter()
            .enumerate()
            .filter_map(|(index, parameter)| Coordinate::new::<String>(index, parameter).ok())
            .collect();
        let starts = || nuisances.iter().map(|nuisance| nuisance.start).collect();
        if coordinates.len() != nuisances.len() {
            return starts();
        }
        let (lower, upper): (Vec<f64>, Vec<f64>) = coordinates.iter().map(|c| (c.lower, c.upper)).unzip();
        let mut start = Start {
            shown: self,
            model,
            coordinates: &coordinates,
            measured,
            weights,
            predictions: Vec::new(),
            derivatives: Vec::new(),
        };
        let limits = Limits { iterations: 20, tolerance: 1e-8, useful: f64::INFINITY };
        match minimise(&mut start, vec![0.0; nuisances.len()], &lower, &upper, limits) {
            Some(end) => coordinates.iter().zip(&end.y).map(|(c, y)| c.value(*y)).collect(),
            None => starts(),
        }
    }
}

/// The sum of squares of one record as a function of its start.
struct Start<'a, 'r> {
    shown: &'a mut ObservedSimulation<'r>,
    model: &'a Model,
    coordinates: &'a [Coordinate],
    measured: &'a [f64],
    weights: &'a [f64],
    predictions: Vec<f64>,
    derivatives: Vec<Vec<f64>>,
}

impl Start<'_, '_> {
    fn values(&self, y: &[f64]) -> Vec<f64> {
        self.coordinates.iter().zip(y).map(|(c, y)| c.value(*y)).collect()
    }

    fn residual(&self, index: usize) -> f64 {
        (self.predictions[index] - self.measured[index]) * self.weights[index]
    }
}

impl SumOfSquares for Start<'_, '_> {
    fn cost(&mut self, y: &[f64]) -> Option<f64> {
        let values = self.values(y);
        let mut predictions = std::mem::take(&mut self.predictions);
        let outcome = self.shown.predict(self.model, &values, &mut predictions);
        self.predictions = predictions;
        outcome.ok()?;
        Some(0.5 * (0..self.measured.len()).map(|i| self.residual(i).powi(2)).sum::<f64>())
    }

    fn sums(&mut self, y: &[f64]) -> Option<Sums> {
        let directions: Vec<Direction> = (0..y.len())
            .map(|j| {
                let step = inward(y[j], self.coordinates[j].upper, NUISANCE_STEP);
                let mut moved = y.to_vec();
                moved[j] += step;
                Direction { model: self.model.clone(), nuisances: self.values(&moved), step }
            })
            .collect();
        let values = self.values(y);
        let (mut predictions, mut derivatives) =
            (std::mem::take(&mut self.predictions), std::mem::take(&mut self.derivatives));
        let outcome =
            self.shown.linearise(self.model, &values, &directions, &mut predictions, &mut derivatives);
        (self.predictions, self.derivatives) = (predictions, derivatives);
        outcome.ok()?;
        let n = y.len();
        let mut sums = Sums { cost: 0.0, gradient: vec![0.0; n], curvature: vec![0.0; n * n] };
        for index in 0..self.measured.len() {
            let residual = self.residual(index);
            sums.cost += 0.5 * residual * residual;
            for a in 0..n {
                let slope = self.derivatives[a][index] * self.weights[index];
                sums.gradient[a] += slope * residual;
                for b in 0..n {
                    sums.curvature[a * n + b] += slope * self.derivatives[b][index] * self.weights[index];
                }
            }
        }
        Some(sums)
    }
}

/// A step of this size that does not leave through the upper bound.
pub(crate) fn inward(y: f64, upper: f64, step: f64) -> f64 {
    if y + step <= upper { step } else { -step }
}
