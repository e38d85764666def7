//! The measurements laid out for fits and scores: every channel's samples with their weights.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::data::{Dataset, Record};
use crate::diagnose::assumptions::Assumptions;
use crate::fit::InterruptHook;
use crate::fit::predict::{ObservedSimulation, Seed, compared, deviation};
use crate::model::Model;

/// A dataset with weights, and counters of what is spent on it.
pub(in crate::diagnose) struct WeightedDataset<'d> {
    pub dataset: &'d Dataset,
    /// Per record, in the order of the dataset.
    pub lanes: Vec<RecordResiduals<'d>>,
    pub assumptions: Assumptions,
    simulations: AtomicUsize,
    refits: AtomicUsize,
    interrupt: Option<InterruptHook<'d>>,
}

/// One record's compared channels, one after the other.
#[derive(Clone)]
pub(in crate::diagnose) struct RecordResiduals<'d> {
    pub record: &'d Record,
    /// Measured values.
    pub measured: Vec<f64>,
    /// One over the channel's standard deviation, per sample: what residuals are measured by.
    pub scales: Vec<f64>,
    /// How much more or less each sample weighs than the channel's noise says.
    pub weights: Vec<f64>,
    /// Samples of each channel, by name.
    pub channels: Vec<(&'d str, std::ops::Range<usize>)>,
    /// A solution that every simulation of the record starts from.
    pub seed: Option<Seed>,
    /// Steps in time in place of one that every simulation of the record takes.
    pub steps: usize,
}

/// A model's predictions of one record, its start fitted to it.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct Scored {
    /// Index of the record.
    pub record: usize,
    /// All channels, one after the other.
    pub predictions: Vec<f64>,
    /// (prediction − measurement) over the channel's standard deviation.
    pub residuals: Vec<f64>,
}

impl<'d> WeightedDataset<'d> {
    /// Of `dataset`, for models of the kind of `model`, weighted by the channels' standard deviations.
    ///
    /// # Errors
    /// Name of a record and why no model of this kind can predict it.
    pub fn new(
        model: &Model,
        dataset: &'d Dataset,
        assumptions: Assumptions,
        interrupt: Option<InterruptHook<'d>>,
    ) -> Result<Self, (String, String)> {
        let of = |record: &'d Record| lane(model, record).map_err(|reason| (record.name.clone(), reason));
        let lanes: Vec<Result<RecordResiduals, _>> = dataset.records.par_iter().map(of).collect();
        // Of several failures the first.
        let lanes = lanes.into_iter().collect::<Result<_, _>>()?;
        Ok(Self {
            dataset,
            lanes,
            assumptions,
            simulations: AtomicUsize::new(0),
            refits: AtomicUsize::new(0),
            interrupt,
        })
    }

    /// The same of other samples of these records.
    ///
    /// # Errors
    /// As [`WeightedDataset::new`].
    pub fn of_samples(&self, model: &Model, dataset: &'d Dataset) -> Result<Self, (String, String)> {
        Self::new(model, dataset, self.assumptions, self.interrupt)
    }

    /// Makes the solutions under `model`, where there are any, the start of all simulations: of records those that are
    /// `known`.
    pub fn reseed(&mut self, model: &Model, known: Vec<(usize, Seed)>) {
        known.into_iter().for_each(|(record, solution)| self.lanes[record].seed = Some(solution));
        self.lanes.par_iter_mut().filter(|lane| lane.seed.is_some()).for_each(|lane| {
            let found = lane.shown(model).ok().and_then(|shown| shown.solution().cloned());
            if let Some(found) = found {
                lane.seed = Some(Seed::Near(found));
            }
        });
    }

    /// The same with predictions to first order about the measured motions; `None` where nothing is solved for.
    pub fn linearised_at_measurement(&self) -> Option<Self> {
        let solved = |lane: &RecordResiduals| lane.seed.is_some();
        self.lanes.iter().any(solved).then(|| Self {
            dataset: self.dataset,
            lanes: self
                .lanes
                .iter()
                .map(|lane| RecordResiduals {
                    seed: lane.seed.as_ref().map(|_| Seed::LinearisedAtMeasurement),
                    ..lane.clone()
                })
                .collect(),
            assumptions: self.assumptions,
            simulations: AtomicUsize::new(0),
            refits: AtomicUsize::new(0),
            interrupt: self.interrupt,
        })
    }

    /// Whether the caller wants the end.
    pub fn interrupted(&self) -> bool {
        self.interrupt.is_some_and(|interrupt| interrupt())
    }

    /// # Errors
    /// Work that is not worth beginning, since an interrupt asks for its end.
    pub fn unless_interrupted(&self) -> Result<(), String> {
        if self.interrupted() { Err("interrupted".to_owned()) } else { Ok(()) }
    }

    /// Counts simulations of single records.
    pub fn count(&self, simulations: usize) {
        self.simulations.fetch_add(simulations, Ordering::Relaxed);
    }

    /// Counts a refit.
    pub fn count_refit(&self) {
        self.refits.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts what was spent on `other`, too.
    pub fn add_spent(&self, other: &Self) {
        let (refits, simulations) = other.spent();
        self.refits.fetch_add(refits, Ordering::Relaxed);
        self.count(simulations);
    }

    /// Refits so far, and simulations of single records.
    pub fn spent(&self) -> (usize, usize) {
        (self.refits.load(Ordering::Relaxed), self.simulations.load(Ordering::Relaxed))
    }

    /// Predictions of `records` under `model`, each record's start fitted to the record itself.
    pub fn score(&self, model: &Model, records: &[usize]) -> Result<Vec<Scored>, String> {
        let scored = |&record: &usize| {
            self.score_one(model, record, self.lanes[record].seed.as_ref()).or_else(|reason| {
                // Without a response near to the measured motion what the equations lack there is the error.
                let about = self.lanes[record].seed.is_some().then_some(&Seed::LinearisedAtMeasurement);
                about.map_or(Err(reason), |about| self.score_one(model, record, Some(about)))
            })
        };
        records.par_iter().map(scored).collect()
    }

    fn score_one(&self, model: &Model, record: usize, seed: Option<&Seed>) -> Result<Scored, String> {
        let lane = &self.lanes[record];
        let mut shown = lane.shown_as(model, lane.record, seed)?;
        let nuisances = shown.nuisances(model)?;
        let settled = match seed {
            // A rough look needs no settled start.
            Some(Seed::LinearisedAtMeasurement) => nuisances.iter().map(|nuisance| nuisance.start).collect(),
            _ if nuisances.is_empty() => Vec::new(),
            _ => shown.settle_from(model, &nuisances, &lane.measured, &lane.scales, None),
        };
        let mut predictions = Vec::new();
        shown.predict(model, &settled, &mut predictions)?;
        self.count(1 + 4 * settled.len());
        let residuals = lane.residuals(&predictions);
        if residuals.iter().all(|r| r.is_finite()) {
            Ok(Scored { record, predictions, residuals })
        } else {
            Err(format!("the prediction of `{}` is not finite", lane.record.name))
        }
    }

    /// Root mean square over all channels of `scored`, each normalised by its own standard deviation.
    pub fn normalised_error(&self, scored: &[Scored]) -> f64 {
        let (mut sum, mut channels) = (0.0, 0);
        for one in scored {
            let lane = &self.lanes[one.record];
            for (_, range) in &lane.channels {
                let square = |i: usize| ((one.predictions[i] - lane.measured[i]) * lane.scales[i]).powi(2);
                sum += range.clone().map(square).sum::<f64>() / range.len() as f64;
                channels += 1;
            }
        }
        (sum / channels as f64).sqrt()
    }
}

fn lane<'d>(model: &Model, record: &'d Record) -> Result<RecordResiduals<'d>, String> {
    // Building a simulation says what the record lacks.
    let seed = ObservedSimulation::new(model, record)?.solution().cloned().map(Seed::Near);
    let mut lane = RecordResiduals::empty(record, seed);
    for channel in compared(model, record) {
        let start = lane.measured.len();
        lane.measured.extend_from_slice(&channel.values);
        let scale = 1.0 / deviation(channel)?;
        lane.scales.resize(lane.measured.len(), scale);
        lane.weights.extend(record.weights(channel));
        lane.channels.push((&channel.name, start..lane.measured.len()));
    }
    Ok(lane)
}

impl<'d> RecordResiduals<'d> {
    /// Without a channel yet.
    pub fn empty(record: &'d Record, seed: Option<Seed>) -> Self {
        Self {
            record,
            measured: Vec::new(),
            scales: Vec::new(),
            weights: Vec::new(),
            channels: Vec::new(),
            seed,
            steps: 1,
        }
    }

    /// A simulation of the record.
    pub fn shown(&self, model: &Model) -> Result<ObservedSimulation<'d>, String> {
        self.shown_as(model, self.record, self.seed.as_ref())
    }

    /// A simulation of `record`, which stands for this one, from `seed`.
    pub fn shown_as<'r>(
        &self,
        model: &Model,
        record: &'r Record,
        seed: Option<&Seed>,
    ) -> Result<ObservedSimulation<'r>, String> {
        Ok(ObservedSimulation::near(model, record, seed)?.in_steps(self.steps))
    }

    /// (prediction − measurement) over the channel's standard deviation.
    pub fn residuals(&self, predictions: &[f64]) -> Vec<f64> {
        predictions
            .iter()
            .zip(&self.measured)
            .zip(&self.scales)
            .map(|((value, measured), scale)| (value - measured) * scale)
            .collect()
    }
}
