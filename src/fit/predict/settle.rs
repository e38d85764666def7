//! The start of a record that fits it best under a model.

use std::borrow::Cow;

use super::channels::{compared, deviation};
use super::observed::ObservedSimulation;
use super::simulation::Direction;
use crate::fit::InterruptHook;
use crate::fit::least_squares::{Coordinate, Limits, Parameter, SumOfSquares, Sums, minimise};
use crate::model::Model;

/// Step of differences in a nuisance, in its coordinate of size one.
const NUISANCE_STEP: f64 = 1e-5;
const INTERRUPTED: &str = "interrupted";

impl ObservedSimulation<'_> {
    /// The nuisances that fit the whole record best under `model`.
    pub fn settle(&mut self, model: &Model) -> Result<Vec<f64>, String> {
        self.settle_unless(model, None)
    }

    /// The same; an error where `interrupt` asks for the end.
    pub fn settle_unless(
        &mut self,
        model: &Model,
        interrupt: Option<InterruptHook>,
    ) -> Result<Vec<f64>, String> {
        let asked = || interrupt.is_some_and(|interrupt| interrupt());
        if asked() {
            return Err(INTERRUPTED.to_owned());
        }
        let nuisances = self.nuisances(model)?;
        if nuisances.is_empty() {
            return Ok(Vec::new());
        }
        let channels = compared(model, self.record);
        let mut weights = Vec::with_capacity(self.len());
        for channel in &channels {
            let weight = 1.0 / deviation(channel)?;
            weights.extend(channel.values.iter().map(|_| weight));
        }
        let measured = match channels[..] {
            [alone] => Cow::Borrowed(alone.values.as_slice()),
            _ => channels.iter().flat_map(|channel| channel.values.iter().copied()).collect(),
        };
        let settled = self.settle_from(model, &nuisances, &measured, &weights, interrupt);
        if asked() { Err(INTERRUPTED.to_owned()) } else { Ok(settled) }
    }

    /// As [`ObservedSimulation::settle`], from given starts and with the weights of the channels' samples.
    pub fn settle_from(
        &mut self,
        model: &Model,
        nuisances: &[Parameter],
        measured: &[f64],
        weights: &[f64],
        interrupt: Option<InterruptHook>,
    ) -> Vec<f64> {
        let coordinates: Vec<Coordinate> =
            nuisances.iter().filter_map(|parameter| Coordinate::new(parameter).ok()).collect();
        let starts = || nuisances.iter().map(|nuisance| nuisance.start).collect();
        if coordinates.len() != nuisances.len() {
            return starts();
        }
        let (lower, upper): (Vec<f64>, Vec<f64>) = coordinates.iter().map(|c| (c.lower, c.upper)).unzip();
        let mut problem = OfStart {
            observed: self,
            model,
            coordinates: &coordinates,
            measured,
            weights,
            interrupt,
            predictions: Vec::new(),
            derivatives: Vec::new(),
        };
        let limits = Limits { iterations: 20, tolerance: 1e-8, ..Limits::default() };
        match minimise(&mut problem, vec![0.0; nuisances.len()], &lower, &upper, limits) {
            Some(end) => coordinates.iter().zip(&end.y).map(|(c, y)| c.value(*y)).collect(),
            None => starts(),
        }
    }
}

/// The sum of squares of one record as a function of its start.
struct OfStart<'a, 'r> {
    observed: &'a mut ObservedSimulation<'r>,
    model: &'a Model,
    coordinates: &'a [Coordinate],
    measured: &'a [f64],
    weights: &'a [f64],
    interrupt: Option<InterruptHook<'a>>,
    predictions: Vec<f64>,
    derivatives: Vec<Vec<f64>>,
}

impl OfStart<'_, '_> {
    fn values(&self, y: &[f64]) -> Vec<f64> {
        self.coordinates.iter().zip(y).map(|(c, y)| c.value(*y)).collect()
    }

    fn residual(&self, index: usize) -> f64 {
        (self.predictions[index] - self.measured[index]) * self.weights[index]
    }
}

impl SumOfSquares for OfStart<'_, '_> {
    fn interrupted(&self) -> bool {
        self.interrupt.is_some_and(|interrupt| interrupt())
    }

    fn cost(&mut self, y: &[f64]) -> Option<f64> {
        let values = self.values(y);
        let mut predictions = std::mem::take(&mut self.predictions);
        let outcome = self.observed.predict(self.model, &values, &mut predictions);
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
            self.observed.linearise(self.model, &values, &directions, &mut predictions, &mut derivatives);
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
fn inward(y: f64, upper: f64, step: f64) -> f64 {
    if y + step <= upper { step } else { -step }
}
