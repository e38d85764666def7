//! A beam in a steady state under a measured periodic excitation, by harmonic balance.

use super::harmonics::RecordHarmonics;
use crate::data::{Channel, Record};
use crate::fit::predict::simulation::WRONG_BRANCH;
use crate::harmonic::steady::linearised::Linearised;
use crate::harmonic::steady::{Start, Steady, SteadyProblem};
use crate::harmonic::{Assembly, HarmonicError};
use crate::model::Model;

/// The contact excites every mode, and accelerations show the highest of them: harmonics beyond it, as a fraction of it.
const BEYOND_HIGHEST_MODE: f64 = 1.4;
/// Fewest and most harmonics.
const HARMONICS: (usize, usize) = (9, 60);
/// Harmonics of the sensors' motion, as multiple of those balanced: of those above half the samples of a period the
/// samples show the alias.
const SENSED: usize = 3;
/// Harmonics of the contact beyond those of the modes: the products with the shortening, which moves slowly.
const CONTACT_BEYOND: usize = 4;
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

/// A solution with the equations about it.
struct Settled {
    known: Known,
    about: Linearised,
    predictions: Vec<f64>,
}

/// What does not change from one prediction of the record to the next.
pub(super) struct SteadyRecord {
    pub forcing: SteadyProblem,
    pub measured: RecordHarmonics,
    start: Option<Start>,
    /// Where the start is one of this simulation's own solutions: the equations as they stand there. A fit asks for
    /// derivatives at the same place more than once.
    settled: Option<Settled>,
    /// What was predicted last from the start, and its solution: a fit that accepts a step asks for the derivatives there
    /// next.
    last: Option<(Known, Start)>,
}

impl SteadyRecord {
    /// The record, with `finer` times as many harmonics as a model with its highest mode at `highest` (rad/s) needs.
    pub fn new(record: &Record, channels: &[&Channel], highest: f64, finer: usize) -> Result<Self, String> {
        let excitation = record.channel("excitation").ok_or("there is no `excitation` column")?;
        let measured = RecordHarmonics::new(record, channels, excitation, |angular_frequency| {
            let beyond = (BEYOND_HIGHEST_MODE * highest / angular_frequency).ceil() as usize + 1;
            finer * beyond.clamp(HARMONICS.0, HARMONICS.1)
        })?;
        let harmonics = measured.harmonics;
        let forcing = SteadyProblem {
            angular_frequency: measured.angular_frequency,
            coefficients: measured.excitation.clone(),
            harmonics,
            contact_harmonics: (harmonics + CONTACT_BEYOND).min(2 * harmonics),
            sensed_harmonics: SENSED * harmonics,
            tolerance: TOLERANCE,
        };
        Ok(Self { forcing, measured, start: None, settled: None, last: None })
    }

    /// Starts from a solution of another simulation of the record.
    pub fn start_from(&mut self, start: &Start) {
        self.start = Some(start.clone()).filter(|start| start.fits(&self.forcing));
    }

    /// Starts from a solution of the record in fewer harmonics.
    pub fn start_from_fewer(&mut self, start: &Start) {
        self.start = Some(start.padded(&self.forcing));
    }

    /// Predictions of all channels, one after the other: of the response near the last one of this simulation where
    /// there is one, as the many steps that a fit tries need no search.
    pub fn predict(&mut self, at: &At, out: &mut Vec<f64>) -> Result<(), String> {
        let Some(start) = self.start.as_ref().filter(|_| self.settled.is_some()) else {
            return self.nearest(at, &[], out).map(drop).map_err(text);
        };
        let mut steady = self.forcing.solve(at.assembly, &[], Some(start)).map_err(text)?;
        self.measured.observe(&steady.sensors(&self.forcing), out);
        self.last = Some((at.known(), steady.here()));
        Ok(())
    }

    /// Predictions of the response that the start is near to, and of no other.
    pub fn follow(&self, at: &At, out: &mut Vec<f64>) -> Result<(), String> {
        let start = self.start.as_ref().ok_or("there is no response to follow")?;
        let mut steady = self.forcing.solve(at.assembly, &[], Some(start)).map_err(text)?;
        let here = steady.here();
        let pairs = || here.contact().iter().zip(start.contact());
        let apart: f64 = pairs().map(|(here, start)| (here - start).powi(2)).sum();
        let size: f64 = pairs().map(|(_, start)| start * start).sum();
        if apart > WRONG_BRANCH * WRONG_BRANCH * size {
            return Err("the response is another in more harmonics".to_owned());
        }
        self.measured.observe(&steady.sensors(&self.forcing), out);
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
        let there =
            |settled: &mut Settled| settled.known.is(at) && settled.about.covers(at.assembly, neighbours);
        let (mut here, start) = match self.settled.take_if(there) {
            Some(here) => (here, None),
            None => {
                let solved = self.nearest(at, neighbours, predictions).map_err(text)?;
                let (about, start) = solved.linearised().map_err(text)?;
                let predictions = predictions.clone();
                (Settled { known: at.known(), about, predictions }, Some(start))
            }
        };
        predictions.clone_from(&here.predictions);
        let done = self.differences(&mut here.about, at.assembly, neighbours, differences);
        if done.is_ok() || start.is_none() {
            self.start = start.or(self.start.take());
            self.settled = Some(here);
            self.last = None;
        }
        done.map_err(text)
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
        let changes = about.changes(&self.forcing, assembly, neighbours)?;
        for (change, difference) in changes.iter().zip(differences) {
            self.measured.observe(change, difference);
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
                    self.measured.observe(&steady.sensors(&self.forcing), &mut near);
                    let distance = self.measured.distance(&near);
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
                let last = self.last.as_ref().filter(|(known, _)| self.settled.is_some() && known.is(at));
                let start = last.map(|(_, here)| here).or(self.start.as_ref())?;
                Some(self.forcing.solve(assembly, others, Some(start)))
            }
            Origin::MeasuredMotion => {
                if self.measured.motion.iter().flatten().all(|x| *x == 0.0) {
                    return None;
                }
                let start = self.forcing.start_at(assembly, &self.measured.motion, &mut None);
                Some(start.and_then(|start| self.forcing.solve(assembly, others, Some(&start))))
            }
            Origin::Nothing => {
                let needless = self.settled.is_some() || self.start.is_some() && found;
                (!needless).then(|| self.forcing.solve(assembly, others, None))
            }
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
