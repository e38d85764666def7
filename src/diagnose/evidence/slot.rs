//! One record of a joint fit: its simulation, its own unknowns, and what it told last.

use super::unknown::Coordinate;
use crate::data::Record;
use crate::diagnose::measurements::weighted_dataset::{RecordResiduals, WeightedDataset};
use crate::fit::predict::{Direction, ObservedSimulation, Seed};
use crate::model::Model;

/// The simulation of a record with what it told last.
pub(super) struct Slot<'d> {
    pub shown: ObservedSimulation<'d>,
    pub own: Vec<Coordinate>,
    pub own_start: Vec<f64>,
    pub offset: usize,
    /// At the last point that was tried.
    pub predictions: Vec<f64>,
    /// At the last point that was linearised.
    pub linearised: Vec<f64>,
    pub derivatives: Vec<Vec<f64>>,
    /// Of a linearisation that is not yet [`Slot::take`]n.
    next: (Vec<f64>, Vec<Vec<f64>>),
}

impl<'d> Slot<'d> {
    pub fn new(shown: ObservedSimulation<'d>) -> Self {
        Self {
            shown,
            own: Vec::new(),
            own_start: Vec::new(),
            offset: 0,
            predictions: Vec::new(),
            linearised: Vec::new(),
            derivatives: Vec::new(),
            next: (Vec::new(), Vec::new()),
        }
    }

    /// Its own unknowns, and where they start: what fits `measured` best under `model`, of all that a scan finds. Of rough
    /// predictions that are `moved` on, what the scan begins with: the steps move it with the rest.
    pub fn scan(
        &mut self,
        model: &Model,
        measured: &[f64],
        weights: &[f64],
        moved: bool,
    ) -> Result<(), String> {
        let parameters = self.shown.nuisances(model)?;
        let between = |p: &crate::fit::Parameter| Coordinate::between(p.lower, p.upper);
        self.own = parameters.iter().map(between).collect();
        if !parameters.is_empty() {
            let settled = if moved && self.shown.is_rough() {
                parameters.iter().map(|parameter| parameter.start).collect()
            } else {
                self.shown.settle_from(model, &parameters, measured, weights, None)
            };
            self.own_start = self.own.iter().zip(&settled).map(|(c, v)| c.of(*v)).collect();
        }
        Ok(())
    }

    pub fn own_values(&self, y: &[f64]) -> Vec<f64> {
        self.own.iter().zip(&y[self.offset..]).map(|(c, y)| c.value(*y)).collect()
    }

    /// At `y`, with `moved` models and the `steps` of its own unknowns among those of all; counts once it is
    /// [`Slot::take`]n, when all records could be linearised.
    pub fn linearise(
        &mut self,
        model: &Model,
        moved: &[(Model, f64)],
        y: &[f64],
        steps: &[f64],
    ) -> Result<(), String> {
        let nuisances = self.own_values(y);
        let mut directions: Vec<Direction> = directions(moved, &nuisances).collect();
        for (k, coordinate) in self.own.iter().enumerate() {
            let (here, size) = (y[self.offset + k], steps[self.offset + k]);
            // Towards the middle, where a start without influence is drawn: what stands in the way must be seen.
            let step = if here > 0.0 { -size } else { size };
            let mut nuisances = nuisances.clone();
            nuisances[k] = coordinate.value(here + step);
            directions.push(Direction { model: model.clone(), nuisances, step });
        }
        self.shown.linearise(model, &nuisances, &directions, &mut self.next.0, &mut self.next.1)
    }

    /// Takes what was linearised last in the place of what was there before.
    pub fn take(&mut self) {
        std::mem::swap(&mut self.linearised, &mut self.next.0);
        std::mem::swap(&mut self.derivatives, &mut self.next.1);
    }

    /// What predictions refined `finer` times change at the point `y` that was linearised.
    pub fn step_error(&mut self, model: &Model, y: &[f64], finer: usize) -> Result<Vec<f64>, String> {
        let (start, mut fine) = (self.own_values(y), Vec::new());
        self.shown.refine(finer);
        let predicted = self.shown.predict(model, &start, &mut fine);
        self.shown.refine(1);
        predicted?;
        fine.iter_mut().zip(&self.linearised).for_each(|(fine, coarse)| *fine -= coarse);
        Ok(fine)
    }

    /// What is predicted where `record` drives the model in place of that of `lane`, and the derivatives along the `moved`
    /// models there. An unknown past is sought anew: what its numbers mean belongs to the simulation that found it.
    pub fn driven_by(
        &self,
        model: &Model,
        moved: &[(Model, f64)],
        record: &Record,
        lane: &RecordResiduals,
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), String> {
        let own = self.shown.solution().cloned().map(Seed::Near);
        let mut shown = lane.shown_as(model, record, own.as_ref().or(lane.seed.as_ref()))?;
        let nuisances = shown.settle(model)?;
        let directions: Vec<Direction> = directions(moved, &nuisances).collect();
        let (mut driven, mut derivatives) = (Vec::new(), Vec::new());
        shown.linearise(model, &nuisances, &directions, &mut driven, &mut derivatives)?;
        Ok((driven, derivatives))
    }

    /// What each of `probes` changes about the predictions at `model` and the unknowns `y`; `None` for those that cannot be
    /// predicted, and for those that an interrupt of `bench` left.
    pub fn changes(
        &mut self,
        model: &Model,
        probes: &[Model],
        y: &[f64],
        bench: &WeightedDataset,
    ) -> Vec<Option<Vec<f64>>> {
        let nuisances = self.own_values(y);
        let direction =
            |model: &Model| Direction { model: model.clone(), nuisances: nuisances.clone(), step: 1.0 };
        let probes: Vec<Direction> = probes.iter().map(direction).collect();
        // Without a solution here no probe has one.
        let here = bench
            .unless_interrupted()
            .and_then(|()| self.shown.linearise(model, &nuisances, &[], &mut Vec::new(), &mut Vec::new()));
        match here {
            Ok(()) => self.along(model, &nuisances, &probes, bench),
            Err(_) => vec![None; probes.len()],
        }
    }

    /// The changes along `probes`, in halves where one of them cannot be predicted.
    fn along(
        &mut self,
        model: &Model,
        nuisances: &[f64],
        probes: &[Direction],
        bench: &WeightedDataset,
    ) -> Vec<Option<Vec<f64>>> {
        if bench.interrupted() {
            return vec![None; probes.len()];
        }
        let (mut here, mut changes) = (Vec::new(), Vec::new());
        if self.shown.look_around(model, nuisances, probes, &mut here, &mut changes).is_ok() {
            let finite = |change: &Vec<f64>| change.iter().all(|x| x.is_finite());
            return changes.into_iter().map(|change| Some(change).filter(finite)).collect();
        }
        if probes.len() < 2 {
            return vec![None; probes.len()];
        }
        let (first, second) = probes.split_at(probes.len() / 2);
        [first, second].map(|half| self.along(model, nuisances, half, bench)).concat()
    }

    /// Moves what was linearised by `step` of all unknowns to the last trial; the derivatives change least, measured in
    /// `steps` of the unknowns.
    pub fn correct(&mut self, parameters: usize, step: &[f64], steps: &[f64]) {
        let own = self.offset..self.offset + self.own.len();
        let moves: Vec<(f64, f64)> =
            (0..parameters).chain(own).map(|place| (step[place], steps[place])).collect();
        let square: f64 = moves.iter().map(|(by, scale)| (by / scale).powi(2)).sum();
        if square == 0.0 {
            return;
        }
        for (i, (here, tried)) in self.linearised.iter_mut().zip(&self.predictions).enumerate() {
            let promised: f64 =
                self.derivatives.iter().zip(&moves).map(|(column, (by, _))| column[i] * by).sum();
            let missed = (tried - *here - promised) / square;
            for (column, (by, scale)) in self.derivatives.iter_mut().zip(&moves) {
                column[i] += missed * by / (scale * scale);
            }
            *here = *tried;
        }
    }
}

/// To each of the `moved` models with the same `nuisances`.
fn directions(moved: &[(Model, f64)], nuisances: &[f64]) -> impl Iterator<Item = Direction> {
    moved.iter().map(|(model, step)| Direction {
        model: model.clone(),
        nuisances: nuisances.to_vec(),
        step: *step,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Record, Regime};
    use crate::diagnose::evidence::samples::slider;

    #[test]
    fn a_linearisation_that_fails_leaves_the_last_one() {
        let model = slider("");
        let channel = |name: &str, unit, slope: f64| Channel {
            name: name.into(),
            unit,
            values: (0..9).map(|i| slope * f64::from(i)).collect(),
            noise: None,
        };
        let channels =
            vec![channel("time", "s", 1e-3), channel("displacement", "m", 4e-6), channel("force", "N", 1.0)];
        let record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
        let mut slot = Slot::new(ObservedSimulation::new(&model, &record).unwrap());
        slot.linearise(&model, &[(model.clone(), 1.0)], &[], &[]).unwrap();
        slot.take();
        let before = (slot.linearised.clone(), slot.derivatives.clone());
        assert_eq!(before.0.len(), 9);
        // A model that cannot be predicted: it has no contact.
        let bare = Model { contact: None, ..model.clone() };
        assert!(slot.linearise(&bare, &[(model.clone(), 1.0)], &[], &[]).is_err());
        let alone = slot.linearise(&model, &[(bare.clone(), 1.0)], &[], &[]);
        assert!(alone.is_err());
        assert_eq!(slot.linearise(&model, &[(model.clone(), 1.0), (bare, 1.0)], &[], &[]), alone);
        assert_eq!((slot.linearised, slot.derivatives), before);
    }
}
