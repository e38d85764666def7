//! A beam in a steady state under a measured periodic excitation.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Complex;
use realfft::{ComplexToReal, RealFftPlanner};

use super::super::channels::derivative_order;
use super::{At, Known};
use crate::data::{Channel, Record};
use crate::harmonic::HarmonicError;
use crate::harmonic::steady::{ForcedBeam, Start, Steady, SteadyProblem};
use crate::harmonic::{common_periods, excited_harmonics};
use crate::numeric::fourier;
use crate::numeric::fourier::{coefficient_count, time_derivative};

/// Largest share of an input (root-mean-square, of an excitation without its mean) that may lie outside the harmonics
/// kept: more is not noise.
const UNREPRESENTED: f64 = 0.1;
/// The contact excites every mode, and accelerations show the highest of them: harmonics beyond it, as share of it.
const BEYOND_HIGHEST_MODE: f64 = 1.4;
/// Fewest and most harmonics.
const HARMONICS: (usize, usize) = (9, 60);
/// Harmonics of the sensors' motion, as multiple of those balanced: of those above half the samples of a period the
/// samples show the alias.
const SENSED: usize = 3;
/// Harmonics of the contact beyond those of the modes: the products with the shortening, which moves slowly.
const CONTACT_BEYOND: usize = 4;
/// Root-mean-square share of the motion above which a prediction may be another of several responses than the measured.
const ASTRAY: f64 = 0.2;
/// Residual as share of the largest displacement: far below the noise of any sensor.
const TOLERANCE: f64 = 1e-8;

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
        let driven = at.attached.driven();
        let Some(start) = self.start.as_ref().filter(|_| self.settled) else {
            return self.nearest(at, &[], out).map(drop).map_err(text);
        };
        let mut steady = self.forcing.solve(driven, &[], Some(start)).map_err(text)?;
        self.observe(&steady.sensors(&self.forcing), out);
        self.last = Some((at.known(), steady.here()));
        Ok(())
    }

    /// Predictions, and their differences to those of `neighbours` to first order; the solution becomes the start of
    /// what follows.
    pub fn linearise(
        &mut self,
        at: &At,
        neighbours: &[ForcedBeam],
        predictions: &mut Vec<f64>,
        differences: &mut [Vec<f64>],
    ) -> Result<(), String> {
        let mut solved = self.nearest(at, neighbours, predictions).map_err(text)?;
        for (neighbour, difference) in neighbours.iter().zip(differences) {
            let change = solved.change(&self.forcing, *neighbour).map_err(text)?;
            self.observe(&change, difference);
        }
        self.start = Some(solved.start().map_err(text)?);
        self.settled = true;
        self.last = None;
        Ok(())
    }

    /// The last solution, for another simulation of the record to start from.
    pub fn start(&self) -> Option<&Start> {
        self.start.as_ref()
    }

    /// The response near the last one and, where that is not the motion measured, the one nearest to it; with its
    /// predictions. Nothing is sought far off in a fit under way: a step that leads too far is one to be shortened.
    fn nearest<'m>(
        &self,
        at: &At<'m>,
        others: &[ForcedBeam],
        predictions: &mut Vec<f64>,
    ) -> Result<Steady<'m>, HarmonicError> {
        let driven = at.attached.driven();
        let here = self.last.as_ref().filter(|(known, _)| self.settled && known.is(at)).map(|(_, here)| here);
        let mut best: Option<(f64, Steady)> = None;
        let mut failure = None;
        let mut near = Vec::new();
        for way in [Way::Last, Way::Measured, Way::Nothing] {
            let found = match way {
                Way::Last => match here.or(self.start.as_ref()) {
                    Some(start) => self.forcing.solve(driven, others, Some(start)),
                    None => continue,
                },
                Way::Measured if self.motion.iter().flatten().all(|x| *x == 0.0) => continue,
                Way::Measured => self
                    .forcing
                    .start_at(driven, &self.motion, &mut None)
                    .and_then(|start| self.forcing.solve(driven, others, Some(&start))),
                Way::Nothing if self.settled || self.start.is_some() && best.is_some() => continue,
                Way::Nothing => self.forcing.solve(driven, others, None),
            };
            match found {
                Ok(mut steady) => {
                    self.observe(&steady.sensors(&self.forcing), &mut near);
                    let astray = self.astray(&near);
                    if best.as_ref().is_none_or(|(least, _)| astray < *least) {
                        predictions.clone_from(&near);
                        best = Some((astray, steady));
                    }
                    if astray <= ASTRAY {
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

    /// Root-mean-square difference of `predictions` from the measured motion as share of it, means apart.
    fn astray(&self, predictions: &[f64]) -> f64 {
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
enum Way {
    Last,
    Measured,
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

/// Displacement coefficients (m) of a measured time derivative of the order `order`, zero where the measurement shows
/// noise alone.
fn displacement(
    values: &[f64],
    order: usize,
    periods: usize,
    harmonics: usize,
    angular_frequency: f64,
) -> Vec<f64> {
    let measured = fourier::from_samples(values, periods, harmonics);
    let mut moved = vec![0.0; measured.len()];
    for harmonic in excited_harmonics(values, periods) {
        if harmonic == 0 || harmonic > harmonics {
            continue;
        }
        let mut value = Complex::new(measured[2 * harmonic - 1], -measured[2 * harmonic]);
        for _ in 0..order {
            value /= Complex::new(0.0, harmonic as f64 * angular_frequency);
        }
        (moved[2 * harmonic - 1], moved[2 * harmonic]) = (value.re, -value.im);
    }
    moved
}

/// Coefficients of the harmonics that stand out of the noise of an input: of all others of the excitation a lightly
/// damped mode would make more than there is.
fn input(name: &str, values: &[f64], periods: usize, harmonics: usize) -> Result<Vec<f64>, String> {
    let mut coefficients = fourier::from_samples(values, periods, harmonics);
    check_represented(name, values, periods, &coefficients)?;
    let excited = excited_harmonics(values, periods);
    for (place, coefficient) in coefficients.iter_mut().enumerate() {
        if !excited.contains(&place.div_ceil(2)) {
            *coefficient = 0.0;
        }
    }
    Ok(coefficients)
}

/// Refuses an input with a good part beyond the harmonics kept, as a wide multisine has or a record that
/// does not hold whole periods: the response to the rest of it would not be the response to it. Of a load its mean is
/// a part.
fn check_represented(name: &str, values: &[f64], periods: usize, kept: &[f64]) -> Result<(), String> {
    let mean = if name == "excitation" { kept[0] } else { 0.0 };
    let mean_square = values.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / values.len() as f64;
    let represented = (kept[0] - mean).powi(2) + 0.5 * kept[1..].iter().map(|f| f * f).sum::<f64>();
    let share = (1.0 - represented / mean_square).max(0.0).sqrt();
    if share <= UNREPRESENTED {
        return Ok(());
    }
    Err(format!(
        "{:.0} % of `{name}` lies beyond harmonic {} of the period found ({periods} of it in the \
         record); a steady record holds whole periods, and of few harmonics",
        100.0 * share,
        kept.len() / 2
    ))
}
