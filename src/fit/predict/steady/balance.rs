//! A beam in a steady state under a measured periodic excitation, by harmonic balance.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner};

use super::spectrum::{displacement, input};
use crate::data::{Channel, Record};
use crate::fit::predict::channels::derivative_order;
use crate::harmonic::steady::linearised::Linearised;
use crate::harmonic::steady::{Start, Steady, SteadyProblem};
use crate::harmonic::{Assembly, HarmonicError};
use crate::model::Model;
use crate::numeric::common_periods;
use crate::numeric::fourier::{self, coefficient_count, time_derivative};

/// The contact excites every mode, and accelerations show the highest of them: harmonics beyond it, as a fraction of it.
const BEYOND_HIGHEST_MODE: f64 = 1.4;
/// Fewest and most harmonics.
const HARMONICS: (usize, usize) = (9, 60);
/// Harmonics of the sensors' motion, as multiple of those balanced: of those above half the samples of a period the
/// samples show the alias.
const SENSED: usize = 3;
/// Harmonics of the contact beyond those of the modes: the products with the shortening, which moves slowly.
const CONTACT_BEYOND: usize = 4;
/// Root-mean-square fraction of the motion above which a prediction may be another of several responses than the measured.
const WRONG_BRANCH: f64 = 0.2;
/// Residual as a fraction of the largest displacement: far below the noise of any sensor.
const TOLERANCE: f64 = 1e-8;

/// A model with its nuisances, and its system under the measured load.
pub(super) struct At<'a> {
    pub model: &'a Model,
    pub nuisances: &'a [f64],
    pub assembly: &'a Assembly,
}

/// What a prediction was made of, to know it again.
pub(super) struct Known {
    model: Model,
    nuisances: Vec<f64>,
}

impl At<'_> {
    pub fn known(&self) -> Known {
        Known { model: self.model.clone(), nuisances: self.nuisances.to_vec() }
    }
}

impl Known {
    pub fn is(&self, at: &At) -> bool {
        self.nuisances == at.nuisances && self.model == *at.model
    }
}

/// What does not change from one prediction of the record to the next.
pub(super) struct SteadyRecord {
    pub forcing: SteadyProblem,
    /// Periods of the excitation in the record.
    periods: usize,
    /// From spectral lines to samples.
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Time derivative of the displacement that each channel measures.
    orders: Vec<usize>,
    /// What the channels measured, without their means.
    measured: Vec<f64>,
    /// Displacement coefficients (m) of each, of the harmonics that stand out of its noise.
    pub motion: Vec<Vec<f64>>,
    /// Coefficients of the measured normal load (N), `[a0, c1, s1, …]`.
    load: Option<Vec<f64>>,
    start: Option<Start>,
    /// Whether the start is one of this simulation's own solutions.
    settled: bool,
    /// What was predicted last from the start, and its solution: a fit that accepts a step asks for the derivatives there
    /// next.
    last: Option<(Known, Start)>,
}

impl SteadyRecord {
    /// The record, with as many harmonics as a model with its highest mode at `highest` (rad/s) needs.
    pub fn new(record: &Record, channels: &[&Channel], highest: f64) -> Result<Self, String> {
        let time = record.time().ok_or("there is no `time` column")?;
        let step = record.sample_step().ok_or("`time` is not evenly spaced")?;
        let force = &record.channel("excitation").ok_or("there is no `excitation` column")?.values;
        let load = record.channel("normal_load").map(|channel| channel.values.as_slice());
        let periods = common_periods(std::iter::once(force.as_slice()).chain(load))
            .ok_or("the excitation shows no spectral line")?;
        let angular_frequency = TAU * periods as f64 / (step * force.len() as f64);
        let beyond = (BEYOND_HIGHEST_MODE * highest / angular_frequency).ceil() as usize + 1;
        let harmonics = beyond.clamp(HARMONICS.0, HARMONICS.1);
        let coefficients = input("excitation", force, periods, harmonics)?;
        let load = load.map(|load| input("normal_load", load, periods, harmonics)).transpose()?;
        let orders: Vec<usize> = channels.iter().map(|channel| derivative_order(channel)).collect();
        let values = || channels.iter().map(|channel| channel.values.as_slice());
        let displacements = values()
            .zip(&orders)
            .map(|(values, order)| displacement(values, *order, periods, harmonics, angular_frequency));
        let motion = displacements.collect();
        let mut measured: Vec<f64> = values().flatten().copied().collect();
        measured.chunks_exact_mut(time.len()).for_each(remove_mean);
        let contact_harmonics = (harmonics + CONTACT_BEYOND).min(2 * harmonics);
        let forcing = SteadyProblem {
            angular_frequency,
            coefficients,
            harmonics,
            contact_harmonics,
            sensed_harmonics: SENSED * harmonics,
            tolerance: TOLERANCE,
        };
        Ok(Self {
            forcing,
            periods,
            inverse: RealFftPlanner::new().plan_fft_inverse(time.len()),
            orders,
            measured,
            motion,
            load,
            start: None,
            settled: false,
            last: None,
        })
    }

    /// Starts from a solution of another simulation of the record.
    pub fn start_from(&mut self, start: &Start) {
        self.start = Some(start.clone()).filter(|start| start.fits(&self.forcing));
    }

    /// Coefficients of the measured normal load (N), `[a0, c1, s1, …]`.
    pub fn load(&self) -> Option<&[f64]> {
        self.load.as_deref()
    }

    /// Predictions of all channels, one after the other: of the response near the last one of this simulation where
    /// there is one, as the many steps that a fit tries need no search.
    pub fn predict(&mut self, at: &At, out: &mut Vec<f64>) -> Result<(), String> {
        let Some(start) = self.start.as_ref().filter(|_| self.settled) else {
            return self.nearest(at, &[], out).map(drop).map_err(text);
        };
        let mut steady = self.forcing.solve(at.assembly, &[], Some(start)).map_err(text)?;
        self.observe(&steady.sensors(&self.forcing), out);
        self.last = Some((at.known(), steady.here()));
        Ok(())
    }

    /// Predictions, and their differences to those of `neighbours` to first order; the solution becomes the start of
    /// what follows.
    pub fn linearise(
        &mut self,
        at: &At,
        neighbours: &[Assembly],
        predictions: &mut Vec<f64>,
        differences: &mut [Vec<f64>],
    ) -> Result<(), String> {
        let solved = self.nearest(at, neighbours, predictions).map_err(text)?;
        let (mut about, start) = solved.linearised().map_err(text)?;
        self.differences(&mut about, at.assembly, neighbours, differences).map_err(text)?;
        self.start = Some(start);
        self.settled = true;
        self.last = None;
        Ok(())
    }

    /// What the channels show to first order of `neighbours` less what they show of `assembly`, at whose motion the
    /// equations stand.
    pub fn differences(
        &self,
        about: &mut Linearised,
        assembly: &Assembly,
        neighbours: &[Assembly],
        differences: &mut [Vec<f64>],
    ) -> Result<(), HarmonicError> {
        if neighbours.is_empty() {
            return Ok(());
        }
        let here = about.first_order(&self.forcing, assembly)?;
        for (neighbour, difference) in neighbours.iter().zip(differences) {
            let mut change = about.first_order(&self.forcing, neighbour)?;
            change.iter_mut().zip(&here).for_each(|(there, here)| *there -= here);
            self.observe(&change, difference);
        }
        Ok(())
    }

    /// The last solution, for another simulation of the record to start from.
    pub fn start(&self) -> Option<&Start> {
        self.start.as_ref()
    }

    /// The response near the last one and, where that is not the motion measured, the one nearest to it; with its
    /// predictions. Nothing is sought far off in a fit under way: a step that leads too far is one to be shortened.
    fn nearest(
        &self,
        at: &At,
        others: &[Assembly],
        predictions: &mut Vec<f64>,
    ) -> Result<Steady, HarmonicError> {
        let mut best: Option<(f64, Steady)> = None;
        let mut failure = None;
        let mut near = Vec::new();
        for origin in [Origin::LastSolution, Origin::MeasuredMotion, Origin::Nothing] {
            let Some(found) = self.solve_from(origin, at, others, best.is_some()) else {
                continue;
            };
            match found {
                Ok(mut steady) => {
                    self.observe(&steady.sensors(&self.forcing), &mut near);
                    let distance = self.distance(&near);
                    if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                        predictions.clone_from(&near);
                        best = Some((distance, steady));
                    }
                    if distance <= WRONG_BRANCH {
                        break;
                    }
                }
                Err(error) => failure = failure.or(Some(error)),
            }
        }
        match (best, failure) {
            (Some((_, steady)), _) => Ok(steady),
            (None, Some(error)) => Err(error),
            (None, None) => Err(HarmonicError::InvalidInput("nothing was measured")),
        }
    }

    /// The response sought from `origin`, if there is something to seek from; `found` says whether there is one already.
    fn solve_from(
        &self,
        origin: Origin,
        at: &At,
        others: &[Assembly],
        found: bool,
    ) -> Option<Result<Steady, HarmonicError>> {
        let assembly = at.assembly;
        match origin {
            Origin::LastSolution => {
                let last = self.last.as_ref().filter(|(known, _)| self.settled && known.is(at));
                let start = last.map(|(_, here)| here).or(self.start.as_ref())?;
                Some(self.forcing.solve(assembly, others, Some(start)))
            }
            Origin::MeasuredMotion => {
                if self.motion.iter().flatten().all(|x| *x == 0.0) {
                    return None;
                }
                let start = self.forcing.start_at(assembly, &self.motion, &mut None);
                Some(start.and_then(|start| self.forcing.solve(assembly, others, Some(&start))))
            }
            Origin::Nothing => {
                let needless = self.settled || self.start.is_some() && found;
                (!needless).then(|| self.forcing.solve(assembly, others, None))
            }
        }
    }

    /// Root-mean-square difference of `predictions` from the measured motion as a fraction of it, means apart.
    fn distance(&self, predictions: &[f64]) -> f64 {
        let samples = self.inverse.len();
        let (mut sum, mut channels) = (0.0, 0.0);
        let mut moved = vec![0.0; samples];
        for (predicted, measured) in
            predictions.chunks_exact(samples).zip(self.measured.chunks_exact(samples))
        {
            moved.copy_from_slice(predicted);
            remove_mean(&mut moved);
            let error: f64 = moved.iter().zip(measured).map(|(a, b)| (a - b).powi(2)).sum();
            let size: f64 = measured.iter().map(|b| b * b).sum();
            if size > 0.0 {
                sum += error / size;
                channels += 1.0;
            }
        }
        if channels > 0.0 { f64::sqrt(sum / channels) } else { 0.0 }
    }

    /// What the channels measure of displacements with the coefficients `sensors`. Their phase 0 is the first sample.
    pub fn observe(&self, sensors: &[f64], out: &mut Vec<f64>) {
        out.clear();
        let count = coefficient_count(self.forcing.sensed_harmonics);
        for (coefficients, order) in sensors.chunks_exact(count).zip(&self.orders) {
            let moved = time_derivative(coefficients, *order, self.forcing.angular_frequency);
            fourier::to_samples(&moved, self.periods, &*self.inverse, out);
        }
    }
}

/// Where a response is sought.
#[derive(Clone, Copy)]
enum Origin {
    LastSolution,
    MeasuredMotion,
    Nothing,
}

/// The error for a reader of the comparison.
fn text(error: HarmonicError) -> String {
    error.to_string()
}

fn remove_mean(values: &mut [f64]) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter_mut().for_each(|value| *value -= mean);
}
