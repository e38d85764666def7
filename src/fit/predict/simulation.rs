//! Predicting one record again and again, with changing models: what a fit of many parameters needs from a
//! simulator, whatever the kind of model.

use crate::data::Channel;
use crate::fit::least_squares::Parameter;
use crate::harmonic::steady::Start;
use crate::model::Model;

/// Where simulations of a record start from that solve for its motion.
#[derive(Debug, Clone)]
pub(crate) enum Seed {
    /// The solution of another.
    Near(Start),
    /// They do not solve: predictions are those to first order about the motion that was measured. Where a model has
    /// several responses, or none near to the measured one, these lead a fit on.
    LinearisedAtMeasurement,
}

/// Root-mean-square fraction of the motion above which a prediction may be another of several responses than the measured.
pub(crate) const WRONG_BRANCH: f64 = 0.2;

/// The predictions of one record. It keeps what does not change from one prediction to the next (the
/// excitation's harmonics, velocities, room for the state) and the last solution to start from.
///
/// Predictions must not depend on which predictions were asked for before, beyond the tolerance of the solver
/// and in the same order with the same bits: only [`Simulation::linearise`] may move the starting point that later predictions
/// use.
pub(crate) trait Simulation: Send {
    /// The channels predicted, in the order of all predictions.
    fn channels(&self) -> &[&Channel];

    /// The last solution, where others can start from it.
    fn solution(&self) -> Option<&Start> {
        None
    }

    /// Whether the predictions of `channel` are of the moments that its sensor shows under the model.
    fn is_timed(&self, channel: &Channel) -> bool {
        let _ = channel;
        false
    }

    /// What the record leaves unknown besides the model's parameters: the state of the contact at its start.
    /// The starts are found by a search over the first part of the record under `model`. Empty where nothing
    /// is unknown. How many there are depends on the record alone.
    fn nuisances(&mut self, model: &Model) -> Result<Vec<Parameter>, String> {
        let _ = model;
        Ok(Vec::new())
    }

    /// Whether the predictions are no more than a first-order step from the measured motion.
    fn is_rough(&self) -> bool {
        false
    }

    /// Has predictions made in so many steps in time in place of one, where the steps are not controlled; of beams in a steady
    /// state in more harmonics, an error where the response in those is another. Whether derivatives are refined, too, is
    /// left open.
    fn refine(&mut self, finer: usize) {
        let _ = finer;
    }

    /// Writes the predictions of all channels, one after the other, `Σ len` numbers, in the channels' units.
    fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String>;

    /// Writes the predictions at `model` and their derivatives along each of `directions`, and keeps the
    /// solution as the start of the predictions to come. Differences by default; a solver that has exact
    /// derivatives gives those.
    ///
    /// `derivatives[j]` is `(prediction(directions[j]) − prediction) / directions[j].step`, of the length of
    /// the predictions; as [`Simulation::differences`] says where directions cannot be predicted.
    fn linearise(
        &mut self,
        model: &Model,
        nuisances: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        self.predict(model, nuisances, predictions)?;
        self.differences(directions, predictions, derivatives)
    }

    /// Writes the derivatives by differences from `predictions`: NaN along those of the directions that cannot be predicted,
    /// an error where none can.
    fn differences(
        &mut self,
        directions: &[Direction],
        predictions: &[f64],
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        derivatives.resize_with(directions.len(), Vec::new);
        let predict = |(direction, moved): (&Direction, &mut Vec<f64>)| {
            self.predict(&direction.model, &direction.nuisances, moved)
        };
        let predicted: Vec<Result<(), String>> =
            directions.iter().zip(&mut *derivatives).map(predict).collect();
        divide(directions, predictions, predicted, derivatives)
    }
}

/// Makes derivatives of what was `predicted` along `directions`, which stands in their place.
pub(super) fn divide(
    directions: &[Direction],
    predictions: &[f64],
    predicted: Vec<Result<(), String>>,
    derivatives: &mut [Vec<f64>],
) -> Result<(), String> {
    let some = predicted.iter().any(Result::is_ok);
    for ((direction, predicted), derivative) in directions.iter().zip(predicted).zip(derivatives) {
        match predicted {
            Ok(()) => {
                let pairs = derivative.iter_mut().zip(predictions);
                pairs.for_each(|(moved, base)| *moved = (*moved - base) / direction.step);
            }
            Err(error) if !some => return Err(error),
            Err(_) => {
                derivative.clear();
                derivative.resize(predictions.len(), f64::NAN);
            }
        }
    }
    Ok(())
}

/// A small step in one parameter or nuisance.
#[derive(Debug, Clone)]
pub(crate) struct Direction {
    /// The model after the step.
    pub model: Model,
    /// The nuisances after the step.
    pub nuisances: Vec<f64>,
    /// Length of the step, in whatever coordinate the caller differentiates by.
    pub step: f64,
}
