//! An oscillator excited as measured, which begins in a state that nobody knows: the displacements and velocities of
//! its masses and the contact's force.

use crate::data::{Channel, Record};
use crate::fit::least_squares::{Fit, Options, Parameter, Scale, fit};
use crate::fit::predict::simulation::Simulation;
use crate::fit::predict::stepper::march;
use crate::fit::predict::stepper::system::ExcitedSystem;
use crate::model::{Model, Oscillator};

/// Fraction of a record by which its start is judged: a damped structure forgets it.
const TELLING: f64 = 0.25;
/// Samples by which displacement and velocity at the start are read off the data.
const READ: usize = 7;
/// Bounds of the start over the motion's own size.
const ROOM: f64 = 10.0;
/// Contact forces to begin the search with, as fractions of the limit.
const FORCES: [f64; 3] = [0.0, -0.8, 0.8];
/// Gauss–Newton steps of each search: the motion is nearly linear in its start.
const STEPS: usize = 15;

/// The simulation of one record of an oscillator of unknown start.
pub(in crate::fit::predict) struct OscillatorOfUnknownStart<'r> {
    channels: Vec<&'r Channel>,
    oscillator: ExcitedSystem,
    samples: usize,
    masses: usize,
    /// Place of the mass that the contact is at.
    at: usize,
}

impl<'r> OscillatorOfUnknownStart<'r> {
    /// Of `channels` of `record`, for models like `model` with the masses of its `oscillator`.
    pub fn new(
        model: &Model,
        oscillator: &Oscillator,
        record: &'r Record,
        channels: Vec<&'r Channel>,
    ) -> Result<Self, String> {
        let (at, masses) = (oscillator.contact.unwrap_or(0), oscillator.masses.len());
        let oscillator = ExcitedSystem::new(model, record, &channels)?;
        Ok(Self { channels, oscillator, samples: record.len(), masses, at })
    }

    /// Writes the predictions of the first `samples`. What hangs at the contact begins with its motion.
    fn simulate(
        &self,
        model: &Model,
        nuisances: &[f64],
        samples: usize,
        out: &mut Vec<f64>,
    ) -> Result<(), String> {
        let mut stepper = self.oscillator.stepper(model)?;
        if !nuisances.is_empty() {
            let masses = self.masses;
            if nuisances.len() != 2 * masses + 1 {
                return Err(format!("{} numbers for a start that has {}", nuisances.len(), 2 * masses + 1));
            }
            let part = |from: usize| {
                let mut part = nuisances[from..from + masses].to_vec();
                part.resize(stepper.size(), nuisances[from + self.at]);
                part
            };
            let (displacement, velocity) = (part(0), part(masses));
            stepper.begin(&displacement, &velocity, nuisances[2 * masses])?;
        }
        march(&mut stepper, self.channels.len(), samples, out)
    }

    /// Displacements and velocities at the first sample as far as they were measured, with their bounds.
    fn read(&self, model: &Model) -> Result<Vec<Parameter>, String> {
        let system = model.system().map_err(|error| error.to_string())?;
        let own = system.laws().next().filter(|_| model.contact.is_some());
        let law_limit = own.map_or(0.0, |(_, law, load)| law.limit(load));
        let slowest = system.linear_part().natural_modes().map_err(|error| error.to_string())?;
        let rate = slowest.angular_frequency.iter().copied().find(|omega| *omega > 0.0);
        // A free structure moves at the pace of the record.
        let rate = rate.unwrap_or(1.0 / (self.oscillator.excitation.step(0) * self.samples as f64));
        // The size of the motion: of displacements, or of what they would be at the lowest frequency.
        let mut size = 0.0_f64;
        for (channel, observed) in self.channels.iter().zip(&self.oscillator.observed) {
            let largest = channel.values.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            size = size.max(largest / rate.powi(observed.order as i32));
        }
        if size == 0.0 {
            size = 1.0;
        }
        let around = |start: f64, size: f64| Parameter {
            start,
            lower: -ROOM * size,
            upper: ROOM * size,
            scale: Scale::Linear,
        };
        let n = self.masses;
        let mut parameters: Vec<Parameter> =
            (0..2 * n).map(|i| around(0.0, if i < n { size } else { size * rate * ROOM })).collect();
        for (channel, observed) in self.channels.iter().zip(&self.oscillator.observed) {
            let (value, slope) = line(&channel.values, self.oscillator.excitation.step(0));
            match observed.order {
                0 => {
                    parameters[observed.sensor].start = value;
                    let velocity = &mut parameters[n + observed.sensor].start;
                    if *velocity == 0.0 {
                        *velocity = slope;
                    }
                }
                1 => parameters[n + observed.sensor].start = value,
                _ => {}
            }
        }
        let force = if law_limit.is_finite() && law_limit > 0.0 { law_limit } else { 0.0 };
        // Equal bounds hold a force that there is not.
        parameters.push(Parameter { start: 0.0, lower: -force, upper: force, scale: Scale::Linear });
        Ok(parameters)
    }
}

impl Simulation for OscillatorOfUnknownStart<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    /// Fits the start to the first part of the record.
    fn nuisances(&mut self, model: &Model) -> Result<Vec<Parameter>, String> {
        let this = &*self;
        let read = this.read(model)?;
        let samples = ((this.samples as f64 * TELLING) as usize).max(READ).min(this.samples);
        let weights: Vec<f64> = this
            .channels
            .iter()
            .map(|channel| {
                let squares = channel.values[..samples].iter().map(|x| x * x).sum::<f64>();
                if squares > 0.0 { squares.sqrt().recip() } else { 1.0 }
            })
            .collect();
        let residual = |nuisances: &[f64], out: &mut [f64]| -> Result<(), String> {
            let mut predicted = Vec::new();
            this.simulate(model, nuisances, samples, &mut predicted)?;
            let measured = this.channels.iter().zip(&weights).zip(predicted.chunks_exact(samples));
            let residuals = measured.flat_map(|((channel, weight), predicted)| {
                channel.values.iter().zip(predicted).map(move |(measured, value)| (value - measured) * weight)
            });
            out.iter_mut().zip(residuals).for_each(|(out, residual)| *out = residual);
            Ok(())
        };
        let options = Options { max_iterations: STEPS, tolerance: 1e-7, ..Options::default() };
        let mut best: Option<Fit> = None;
        let force = read.last().copied();
        for share in FORCES {
            let mut start = read.clone();
            if let (Some(force), Some(read)) = (start.last_mut(), force) {
                force.start = share * read.upper;
            }
            let fit = fit(residual, samples * this.channels.len(), &start, &options)
                .map_err(|error| error.to_string())?;
            if best.as_ref().is_none_or(|best| fit.root_mean_square < best.root_mean_square) {
                best = Some(fit);
            }
        }
        let found = best.map(|fit| fit.parameters).unwrap_or_default();
        Ok(read.into_iter().zip(found).map(|(parameter, start)| Parameter { start, ..parameter }).collect())
    }

    fn refine(&mut self, finer: usize) {
        self.oscillator.finer = finer;
    }

    fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        self.simulate(model, nuisances, self.samples, out)
    }
}

/// Value and slope at the first sample, by a straight line through a few.
fn line(values: &[f64], step: f64) -> (f64, f64) {
    let count = values.len().min(READ);
    let mean = values[..count].iter().sum::<f64>() / count as f64;
    let middle = 0.5 * (count as f64 - 1.0);
    let (mut above, mut below) = (0.0, 0.0);
    for (index, value) in values[..count].iter().enumerate() {
        let offset = index as f64 - middle;
        above += offset * (value - mean);
        below += offset * offset;
    }
    let slope = if below > 0.0 { above / below } else { 0.0 };
    (mean - slope * middle, slope / step)
}
