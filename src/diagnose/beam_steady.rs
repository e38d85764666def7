//! A beam in a steady state under a measured periodic excitation.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::beam_record::Attached;
use super::predict::derivative_order;
use crate::harmonic::fourier::{self, coefficient_count, time_derivative};
use crate::harmonic::steady::{Driven, Forcing, Reach, Start};
use crate::harmonic::{excited_harmonics, whole_periods};
use crate::measure::{Channel, Record};

/// Largest share of the excitation (root-mean-square, without its mean) that may lie outside the harmonics
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
/// Residual as share of the largest displacement: far below the noise of any sensor.
const TOLERANCE: f64 = 1e-8;

/// What does not change from one prediction of the record to the next.
#[derive(Debug)]
pub(super) struct SteadyRecord {
    forcing: Forcing,
    /// Waves of the response's harmonics at the samples, `samples × coefficients`.
    waves: DMatrix<f64>,
    /// Time derivative of the displacement that each channel measures.
    orders: Vec<usize>,
    start: Option<Start>,
    /// Whether the start is one of this simulation's own solutions.
    settled: bool,
}

impl SteadyRecord {
    /// The record, with as many harmonics as a model with its highest mode at `highest` (rad/s) needs.
    /// `start` is a solution of another simulation of it.
    pub fn new(
        record: &Record,
        channels: &[&Channel],
        highest: f64,
        start: Option<&Start>,
    ) -> Result<Self, String> {
        let time = record.time().ok_or("there is no `time` column")?;
        let step = record.sample_step().ok_or("`time` is not evenly spaced")?;
        let force = &record.channel("excitation").ok_or("there is no `excitation` column")?.values;
        let periods = whole_periods(force).ok_or("the excitation shows no spectral line")?;
        let angular_frequency = TAU * periods as f64 / (step * force.len() as f64);
        let beyond = (BEYOND_HIGHEST_MODE * highest / angular_frequency).ceil() as usize + 1;
        let harmonics = beyond.clamp(HARMONICS.0, HARMONICS.1);
        let coefficients = excitation(force, periods, harmonics)?;
        let orders = channels.iter().map(|channel| derivative_order(channel)).collect();
        let sensed_harmonics = SENSED * harmonics;
        let count = coefficient_count(sensed_harmonics);
        // Phase 0 of the Fourier coefficients is the first sample.
        let waves = DMatrix::from_fn(time.len(), count, |sample, place| {
            let phase = place.div_ceil(2) as f64 * angular_frequency * (time[sample] - time[0]);
            match place {
                0 => 1.0,
                place if place % 2 == 1 => phase.cos(),
                _ => phase.sin(),
            }
        });
        let contact_harmonics = (harmonics + CONTACT_BEYOND).min(2 * harmonics);
        let forcing = Forcing {
            angular_frequency,
            coefficients,
            harmonics,
            contact_harmonics,
            sensed_harmonics,
            tolerance: TOLERANCE,
        };
        let start = start.filter(|start| start.fits(&forcing)).cloned();
        Ok(Self { forcing, waves, orders, start, settled: false })
    }

    /// Predictions of all channels, one after the other.
    pub fn predict(&self, model: &Attached, out: &mut Vec<f64>) -> Result<(), String> {
        let solved = self.forcing.solve(model.driven(), &[], self.start.as_ref(), self.reach());
        let sensors = solved.map_err(|error| error.to_string())?.sensors(&self.forcing);
        self.motion(&sensors, out);
        Ok(())
    }

    /// Predictions, and their differences to those of `neighbours` to first order; the solution becomes the start of
    /// what follows.
    pub fn linearise(
        &mut self,
        model: &Attached,
        neighbours: &[Attached],
        predictions: &mut Vec<f64>,
        differences: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        let others: Vec<Driven> = neighbours.iter().map(Attached::driven).collect();
        let text = |error: crate::harmonic::HarmonicError| error.to_string();
        let reach = self.reach();
        let mut solved =
            self.forcing.solve(model.driven(), &others, self.start.as_ref(), reach).map_err(text)?;
        self.motion(&solved.sensors(&self.forcing), predictions);
        differences.resize_with(others.len(), Vec::new);
        for (other, difference) in others.iter().zip(differences) {
            let change = solved.change(&self.forcing, *other).map_err(text)?;
            self.motion(&change, difference);
        }
        self.start = Some(solved.start().map_err(text)?);
        self.settled = true;
        Ok(())
    }

    /// The last solution, for another simulation of the record to start from.
    pub fn start(&self) -> Option<&Start> {
        self.start.as_ref()
    }

    /// A step of a fit from its own last solution that leads too far is one to be shortened.
    fn reach(&self) -> Reach {
        if self.settled { Reach::Near } else { Reach::Far }
    }

    /// What the channels measure of displacements with the coefficients `sensors`.
    fn motion(&self, sensors: &[f64], out: &mut Vec<f64>) {
        out.clear();
        for (coefficients, order) in sensors.chunks_exact(self.waves.ncols()).zip(&self.orders) {
            let moved = time_derivative(coefficients, *order, self.forcing.angular_frequency);
            out.extend_from_slice((&self.waves * DVector::from_vec(moved)).as_slice());
        }
    }
}

/// Coefficients of the harmonics that stand out of the excitation's noise: of all others a lightly damped mode
/// would make more than there is.
fn excitation(force: &[f64], periods: usize, harmonics: usize) -> Result<Vec<f64>, String> {
    let mut coefficients = fourier::from_samples(force, periods, harmonics);
    check_represented(force, periods, &coefficients)?;
    let excited = excited_harmonics(force, periods);
    for (place, coefficient) in coefficients.iter_mut().enumerate() {
        if !excited.contains(&place.div_ceil(2)) {
            *coefficient = 0.0;
        }
    }
    Ok(coefficients)
}

/// Refuses an excitation with a good part beyond the harmonics kept, as a wide multisine has or a record that
/// does not hold whole periods: the response to the rest of it would not be the response to it.
fn check_represented(force: &[f64], periods: usize, excitation: &[f64]) -> Result<(), String> {
    let mean_square = force.iter().map(|f| (f - excitation[0]).powi(2)).sum::<f64>() / force.len() as f64;
    let represented = 0.5 * excitation[1..].iter().map(|f| f * f).sum::<f64>();
    let share = (1.0 - represented / mean_square).max(0.0).sqrt();
    if share <= UNREPRESENTED {
        return Ok(());
    }
    Err(format!(
        "{:.0} % of the excitation lies beyond harmonic {} of the period found ({periods} of it in the \
         record); a steady record holds whole periods, and of few harmonics",
        100.0 * share,
        excitation.len() / 2
    ))
}
