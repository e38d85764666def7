//! Steady records as harmonics of their excitation.

use std::f64::consts::TAU;

use super::harmonics::shifted;
use super::{Harmonics, SteadyMotion, harmonics};
use crate::data::{Channel, Record};
use crate::effects::SensorFault;
use crate::fit::predict::period;
use crate::numeric::fourier::{coefficient_count, time_derivative};
use crate::numeric::whole_periods;

/// Part of the excitation that may not repeat: more is no noise.
const REST: f64 = 0.1;
/// No measuring chain is better than this part of a channel's root mean square.
const RESOLUTION: f64 = 1e-6;
/// Probability that noise alone makes a harmonic of a record stand out.
const CHANCE: f64 = 1e-3;
/// Rounds in which a frequency is refined.
const ROUNDS: usize = 4;

/// A steady record as harmonics.
#[derive(Debug, Clone)]
pub(super) struct Steady {
    pub name: String,
    /// Hz.
    pub frequency: f64,
    /// Harmonics that stand out of the noise in some channel.
    pub shown: usize,
    /// Positions of the sensors (m).
    pub positions: Vec<f64>,
    pub motion: SteadyMotion,
    /// Place of the sensor nearest to the excitation.
    pub nearest: usize,
    /// First harmonic of the acceleration there (m/s²), and its phase ahead of the excitation (rad).
    pub amplitude: f64,
    pub phase: f64,
}

/// The `records` that can be used, all with the same sensors and as many harmonics as stand out in any; `excitation` is where the
/// force acts (m), `faults` are what is known of the channels.
pub(super) fn steady(
    excitation: f64,
    faults: &[SensorFault],
    records: &[&Record],
    most: usize,
    skipped: &mut Vec<(String, String)>,
) -> Vec<Steady> {
    let sensors = |record: &Record| motions(record).into_iter().map(|(at, _, _)| at).collect::<Vec<f64>>();
    let positions = records.iter().map(|record| sensors(record)).max_by_key(Vec::len).unwrap_or_default();
    let mut found: Vec<Steady> = Vec::new();
    for record in records {
        match Steady::new(excitation, record, &positions, faults, most) {
            Ok(steady) => found.push(steady),
            Err(reason) => skipped.push((record.name.clone(), reason)),
        }
    }
    let fewest = found.iter().map(|steady| steady.motion.excitation.len() / 2).min().unwrap_or(0);
    let shown = found.iter().map(|steady| steady.shown).max().unwrap_or(0).min(fewest);
    for steady in &mut found {
        let count = coefficient_count(shown);
        let SteadyMotion { accelerations, errors, excitation, excitation_errors, .. } = &mut steady.motion;
        let driven = [excitation, excitation_errors];
        accelerations.iter_mut().chain(errors).chain(driven).for_each(|values| values.truncate(count));
    }
    found
}

/// Position of every sensor, ascending, with its channel and the derivatives that lack to an acceleration.
pub(super) fn motions(record: &Record) -> Vec<(f64, &Channel, usize)> {
    let mut all: Vec<(f64, &Channel, usize)> = Vec::new();
    for (order, quantity) in ["acceleration", "velocity", "displacement"].into_iter().enumerate() {
        for channel in record.channels_of(quantity) {
            if let Some(at) = channel.position().filter(|at| !all.iter().any(|other| other.0 == *at)) {
                all.push((at, channel, order));
            }
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

impl Steady {
    fn new(
        exciter: f64,
        record: &Record,
        positions: &[f64],
        faults: &[SensorFault],
        most: usize,
    ) -> Result<Self, String> {
        let times = record.time().ok_or("it has no `time` column")?;
        let step = record.even_step()?;
        let excitation = record.channel("excitation").ok_or(
            "it has no `excitation [N]` column: without the force that drives the beam the contact's cannot be told",
        )?;
        let channels = motions(record);
        if positions.is_empty() {
            return Err("it has no motion at a position, such as `acceleration:x=0.55 [m/s^2]`".to_owned());
        }
        if channels.iter().map(|(at, _, _)| *at).ne(positions.iter().copied()) {
            let names: Vec<String> = positions.iter().map(|at| format!("x={at}")).collect();
            return Err(format!("its sensors are not those of the other records ({})", names.join(", ")));
        }
        let frequency = frequency(times, step, &excitation.values)?;
        let count = most_harmonics(excitation.values.len(), step, frequency, most);
        let fitted = |channel: &Channel| {
            harmonics(times, &channel.values, frequency, count).map_err(|error| error.to_string())
        };
        let force = fitted(excitation)?;
        let size = norm(&force.coefficients);
        if !(size > 0.0 && force.rest < REST * size) {
            return Err("its excitation does not repeat: it holds no steady state of one period".to_owned());
        }
        let mut shown = 1;
        let (mut accelerations, mut errors) = (Vec::new(), Vec::new());
        for (_, channel, order) in &channels {
            let found = fitted(channel)?;
            shown = shown.max(standing_out(&found, channel.noise).last().copied().unwrap_or(1));
            let size = norm(&found.coefficients).max(f64::MIN_POSITIVE);
            let known = faultless(&found.coefficients, &channel.name, faults, frequency);
            accelerations.push(time_derivative(&known, *order, TAU * frequency));
            let error = |(k, error): (usize, &f64)| {
                let faster = (TAU * frequency * k.div_ceil(2) as f64).powi(*order as i32);
                error.max(RESOLUTION * size) * faster.max(f64::MIN_POSITIVE)
            };
            errors.push(found.errors.iter().enumerate().map(error).collect());
        }
        let [driven, excitation_errors] = driving(&force, excitation, faults, frequency);
        let near = |k: &usize| (positions[*k] - exciter).abs();
        let nearest = (0..positions.len()).min_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(0);
        let first = &accelerations[nearest];
        let angle = |values: &[f64]| (-values[2]).atan2(values[1]);
        Ok(Self {
            name: record.name.clone(),
            frequency,
            shown,
            positions: positions.to_vec(),
            nearest,
            amplitude: first[1].hypot(first[2]),
            phase: angle(first) - angle(&driven),
            motion: SteadyMotion {
                angular_frequency: TAU * frequency,
                excitation: driven,
                excitation_errors,
                accelerations,
                errors,
            },
        })
    }

    /// Amplitude of the first harmonic of the excitation (N).
    pub fn force(&self) -> f64 {
        amplitude(&self.motion.excitation, 1)
    }
}

/// The frequency (Hz) of what repeats in `values`: whole periods of the record, as its regime promises, or else what leaves
/// the least.
fn frequency(times: &[f64], step: f64, values: &[f64]) -> Result<f64, String> {
    let whole = whole_periods(values)
        .filter(|_| joins(values))
        .map(|periods| periods as f64 / (step * values.len() as f64));
    let found = period(values).map(|samples| 1.0 / (samples * step));
    let refined = whole.into_iter().chain(found).map(|first| refine(times, values, first));
    let candidates: Vec<f64> = whole.into_iter().chain(refined).collect();
    let rest = |frequency: &f64| {
        let count = most_harmonics(values.len(), step, *frequency, 5);
        harmonics(times, values, *frequency, count).map_or(f64::INFINITY, |found| found.rest)
    };
    let rests: Vec<f64> = candidates.iter().map(rest).collect();
    let least = rests.iter().copied().fold(f64::INFINITY, f64::min);
    let good = candidates.iter().zip(&rests).find(|(_, rest)| rest.is_finite() && **rest <= 1.02 * least);
    good.map(|(frequency, _)| *frequency)
        .ok_or_else(|| "its excitation shows no period: it holds no steady state".to_owned())
}

/// Over the sharpest bend within a record, by how much it may bend where it begins again.
const SHARPER: f64 = 3.0;

/// Whether `values` go on where they begin, as whole periods do: beyond noise, a part of a period has a step there.
fn joins(values: &[f64]) -> bool {
    let bend = |a: f64, b: f64, c: f64| (a - 2.0 * b + c).abs();
    let within = values.windows(3).map(|three| bend(three[0], three[1], three[2])).fold(0.0, f64::max);
    let [first, second, .., before, last] = values else { return true };
    bend(*before, *last, *first).max(bend(*last, *first, *second)) <= SHARPER * within
}

/// The frequency at which the first harmonic has the same phase in both halves of the record.
fn refine(times: &[f64], values: &[f64], first: f64) -> f64 {
    let middle = times.len() / 2;
    let mut frequency = first;
    for _ in 0..ROUNDS {
        let phase = |range: std::ops::Range<usize>| {
            let found = harmonics(&times[range.clone()], &values[range], frequency, 1).ok()?;
            Some(found.coefficients[2].atan2(found.coefficients[1]))
        };
        let (Some(before), Some(after)) = (phase(0..middle), phase(middle..times.len())) else {
            return first;
        };
        let ahead = (before - after + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        frequency += ahead / (TAU * (times[times.len() - 1] - times[0]) / 2.0);
    }
    frequency
}

/// Harmonics below half the sampling frequency that the samples tell.
fn most_harmonics(samples: usize, step: f64, frequency: f64, most: usize) -> usize {
    let sampled = (0.45 / (step * frequency)) as usize;
    most.min(sampled).min((samples / 2).saturating_sub(1) / 2).max(1)
}

/// The harmonics that noise does not explain.
fn standing_out(found: &Harmonics, noise: Option<f64>) -> Vec<usize> {
    let count = found.coefficients.len() / 2;
    let size = norm(&found.coefficients);
    // A noise that was told is not less where the fit takes it for harmonics.
    let worse = noise.map_or(1.0, |noise| (noise / found.rest.max(f64::MIN_POSITIVE)).max(1.0));
    let limit = 2.0 * (count as f64 / CHANCE).ln();
    let stands_out = |h: &usize| {
        let of = |values: &[f64]| values[2 * h - 1].powi(2) + values[2 * h].powi(2);
        let error = worse * (0.5 * of(&found.errors)).sqrt();
        of(&found.coefficients) > limit * error.max(RESOLUTION * size).powi(2)
    };
    (1..=count).filter(stands_out).collect()
}

/// Coefficients of the excitation and their standard errors. What does not stand out of the noise counts as zero: what noise alone
/// makes of an excitation would move a mode that is lightly damped.
fn driving(found: &Harmonics, excitation: &Channel, faults: &[SensorFault], frequency: f64) -> [Vec<f64>; 2] {
    let excited = standing_out(found, excitation.noise);
    let only = |mut values: Vec<f64>| {
        for (k, value) in values.iter_mut().enumerate() {
            *value = if excited.contains(&k.div_ceil(2)) { *value } else { 0.0 };
        }
        values
    };
    let known = faultless(&found.coefficients, "excitation", faults, frequency);
    [only(known), only(found.errors.clone())]
}

/// Coefficients without the gain and the delay that the model knows of the channel.
fn faultless(coefficients: &[f64], name: &str, faults: &[SensorFault], frequency: f64) -> Vec<f64> {
    let mut out = coefficients.to_vec();
    for fault in faults.iter().filter(|fault| fault.channel == name) {
        out = shifted(&out, TAU * frequency * fault.delay);
        out.iter_mut().for_each(|value| *value /= fault.gain);
    }
    out
}

/// Amplitude of a harmonic, 0 above those that there are.
pub(super) fn amplitude(coefficients: &[f64], harmonic: usize) -> f64 {
    coefficients.get(2 * harmonic - 1..=2 * harmonic).map_or(0.0, |pair| pair[0].hypot(pair[1]))
}

/// Root mean square without the mean.
fn norm(coefficients: &[f64]) -> f64 {
    (0.5 * coefficients[1..].iter().map(|x| x * x).sum::<f64>()).sqrt()
}
