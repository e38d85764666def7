//! What excites a structure, from the columns of a record.

use std::sync::OnceLock;

use crate::data::{Record, Regime};
use crate::fit::predict::motion::Motion;
use crate::numeric::band_limited::band_limited;
use crate::numeric::common_periods;
use crate::time::Ramp;

/// Values from one sample to the next that a cubic is made of.
const FINER: usize = 4;
/// Boole's weights of them in a mean.
const MEAN: [f64; FINER + 1] = [7.0 / 90.0, 32.0 / 90.0, 12.0 / 90.0, 32.0 / 90.0, 7.0 / 90.0];
/// Samples beside a period on either side at least that its course between samples is made of.
const BESIDE: usize = 16;

/// A measured force.
#[derive(Debug, Clone)]
pub(in crate::fit::predict) struct ExcitationForce {
    /// Place of the mass, or of the one exciter of a beam.
    pub at: usize,
    /// From each sample to the next (N); after the last to the first where the record is periodic, else held.
    pub ramps: Vec<Ramp>,
}

impl ExcitationForce {
    /// Of `values` (N) at samples: a cubic as smooth as the samples say where they are `even` and determine it, else straight
    /// lines. A line would be too small by `(ωh)²/12` on average.
    fn new(at: usize, values: &[f64], periodic: bool, even: bool) -> Self {
        let fine = match periodic {
            _ if !even => None,
            true => within_periods(values, |values| band_limited(values, FINER), FINER),
            false => band_limited(values, FINER),
        };
        let mut ramps: Vec<Ramp> = match fine {
            Some(fine) => fine.windows(FINER + 1).step_by(FINER).map(with_moments).collect(),
            None => values.windows(2).map(|pair| Ramp::line(pair[0], pair[1])).collect(),
        };
        if let (true, Some(&last)) = (ramps.len() < values.len(), values.last()) {
            ramps.push(Ramp::line(last, if periodic { values[0] } else { last }));
        }
        Self { at, ramps }
    }

    /// From sample `from` to sample `to`, the next or the same (N).
    pub fn ramp(&self, from: usize, to: usize) -> Ramp {
        if from == to { Ramp::held(self.ramps[from].start) } else { self.ramps[from] }
    }
}

/// The cubic that begins and ends as `values`, and has their mean and first moment: what a structure follows of a force are its
/// impulses. One through values on the way would be too small by `(ωh)⁴/6480` on average.
fn with_moments(values: &[f64]) -> Ramp {
    let line = Ramp::line(values[0], values[FINER]);
    let (mut mean, mut moment) = (0.0, 0.0);
    for (k, (weight, value)) in MEAN.iter().zip(values).enumerate() {
        let place = k as f64 / FINER as f64;
        let beside = weight * (value - line.at(place));
        mean += beside;
        moment += beside * (2.0 * place - 1.0);
    }
    Ramp { bow: 6.0 * mean, skew: 30.0 * moment, ..line }
}

/// What `made` makes of periodic `values`, `finer` times as many over a period and the first once more: of so many periods that
/// their ends do not matter.
fn within_periods(
    values: &[f64],
    made: impl Fn(&[f64]) -> Option<Vec<f64>>,
    finer: usize,
) -> Option<Vec<f64>> {
    let count = values.len();
    let before = BESIDE.div_ceil(count.max(1));
    let made = made(&values.repeat(2 * before + 1))?;
    let first = before * count * finer;
    made.get(first..=first + count * finer).map(<[f64]>::to_vec)
}

/// A measured normal load.
#[derive(Debug, Clone)]
pub(in crate::fit::predict) struct MeasuredLoad {
    /// As measured (N), over one period where it is periodic.
    values: Vec<f64>,
    /// Time from sample to sample (s), where that is even.
    step: Option<f64>,
    periodic: bool,
    /// Most models have a constant load, and do not ask.
    smooth: OnceLock<Vec<f64>>,
}

impl MeasuredLoad {
    fn new(values: Vec<f64>, step: Option<f64>, periodic: bool) -> Self {
        Self { values, step, periodic, smooth: OnceLock::new() }
    }

    /// At the samples (N), its noise reduced: a contact gives way whenever the load dips, and follows the dips of noise.
    pub fn values(&self) -> &[f64] {
        let Some(step) = self.step else { return &self.values };
        let smooth = |values: &[f64]| Motion::even(values, step).values;
        self.smooth.get_or_init(|| match self.periodic {
            true => within_periods(&self.values, |values| Some(smooth(values)), 1)
                .map_or_else(|| self.values.clone(), |once_more| once_more[..self.values.len()].to_vec()),
            false => smooth(&self.values),
        })
    }
}

/// Forces and normal load at the samples: of one period where the record is steady.
#[derive(Debug, Clone)]
pub(in crate::fit::predict) struct Excitation {
    /// Instants of the samples (s); two where they are evenly spaced.
    time: Vec<f64>,
    /// Samples of the excitation.
    pub samples: usize,
    /// Whether the first sample follows the last.
    pub periodic: bool,
    pub forces: Vec<ExcitationForce>,
    pub load: Option<MeasuredLoad>,
}

impl Excitation {
    /// Of a record of a beam.
    pub fn of_beam(record: &Record) -> Result<Self, String> {
        let time = record.time().ok_or("there is no `time` column")?.to_vec();
        let values = &record.channel("excitation").ok_or("there is no `excitation` column")?.values;
        let step = record.sample_step();
        let force = ExcitationForce::new(0, values, false, step.is_some());
        let load = record.channel("normal_load");
        let load = load.map(|channel| MeasuredLoad::new(channel.values.clone(), step, false));
        Ok(Self { time, samples: record.len(), periodic: false, forces: vec![force], load })
    }

    /// Of a record whose excitations act on the masses called `names`.
    pub fn of_masses(record: &Record, names: &[&str]) -> Result<Self, String> {
        let step = record.even_step()?;
        let mut forces: Vec<(usize, Vec<f64>)> = Vec::new();
        for channel in record.channels_of("excitation") {
            forces.push((mass_of(&channel.name, names)?, channel.values.clone()));
        }
        if forces.is_empty() {
            return Err("there is no `excitation:…` column that names a mass".into());
        }
        let mut load = record.channel("normal_load").map(|channel| channel.values.clone());
        let mut samples = record.len();
        let periodic = record.regime == Regime::Steady;
        if periodic {
            let periods = periods(&forces, load.as_deref(), samples);
            samples /= periods;
            forces.iter_mut().for_each(|(_, values)| average(values, samples));
            load.iter_mut().for_each(|values| average(values, samples));
        }
        let force = |(at, values): &(usize, Vec<f64>)| ExcitationForce::new(*at, values, periodic, true);
        let load = load.map(|values| MeasuredLoad::new(values, Some(step), periodic));
        let forces = forces.iter().map(force).collect();
        Ok(Self { time: vec![0.0, step], samples, periodic, forces, load })
    }

    /// Time from sample `index` to the next (s).
    pub fn step(&self, index: usize) -> f64 {
        let from = if self.time.len() == 2 { 0 } else { index };
        self.time[from + 1] - self.time[from]
    }

    /// The sample after `index`; after the last comes the first of a period, and else the last again.
    pub fn after(&self, index: usize) -> usize {
        match index + 1 {
            next if next < self.samples => next,
            _ if self.periodic => 0,
            _ => index,
        }
    }
}

/// Place of the mass that a channel was measured at.
pub(in crate::fit::predict) fn mass_of(channel: &str, names: &[&str]) -> Result<usize, String> {
    let place = channel.split_once(':').map_or("", |(_, place)| place);
    names
        .iter()
        .position(|name| *name == place)
        .ok_or_else(|| format!("`{channel}` names no mass of the model"))
}

/// Whole periods in the record that begin at samples, the same for all inputs.
fn periods(forces: &[(usize, Vec<f64>)], load: Option<&[f64]>, samples: usize) -> usize {
    let common = common_periods(forces.iter().map(|(_, values)| values.as_slice()).chain(load)).unwrap_or(1);
    // A period that ends between two samples: the record as a whole is one.
    if common > 1 && samples.is_multiple_of(common) { common } else { 1 }
}

/// Mean over periods of `samples`.
fn average(values: &mut Vec<f64>, samples: usize) {
    let periods = values.len() / samples;
    for index in 0..samples {
        values[index] = (0..periods).map(|k| values[index + k * samples]).sum::<f64>() / periods as f64;
    }
    values.truncate(samples);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::data::Channel;

    /// Distance of a tone's force from the tone, ten places from each sample to the next but for ends that are not periodic.
    fn distance(speed: f64, count: usize, periodic: bool) -> f64 {
        let wave = |place: f64| (speed * place + 0.3).sin() + 0.5;
        let values: Vec<f64> = (0..count).map(|k| wave(k as f64)).collect();
        let force = ExcitationForce::new(0, &values, periodic, true);
        assert_eq!(force.ramps.len(), count);
        let margin = if periodic { 0 } else { 13 };
        let off = |k: usize| {
            let ramp = force.ramp(k, k + 1);
            (0..10).map(move |i| (ramp.at(0.1 * f64::from(i)) - wave(k as f64 + 0.1 * f64::from(i))).abs())
        };
        (margin..force.ramps.len() - margin).flat_map(off).fold(0.0, f64::max)
    }

    #[test]
    fn a_tone_runs_between_its_samples_as_it_is() {
        // Lines would be off by `speed²/8`.
        for speed in [0.1, 0.4, 0.8] {
            let found = distance(speed, 300, false);
            assert!(found < 1e-5 + 8e-4 * speed.powi(4), "{speed}: {found:e}");
        }
        for count in [5, 9, 40] {
            let speed = TAU / count as f64;
            let found = distance(speed, count, true);
            assert!(found < 1e-5 + 8e-4 * speed.powi(4), "{count}: {found:e}");
        }
    }

    #[test]
    fn a_tone_is_as_large_between_its_samples_as_at_them() {
        for (speed, most) in [(0.05, 1e-5), (0.25, 1e-5), (0.8, 1e-5), (1.2, 4e-5)] {
            let values: Vec<f64> = (0..300).map(|k| (speed * k as f64).sin()).collect();
            let force = ExcitationForce::new(0, &values, false, true);
            // What lies along the tone and across it, in the middle of the record.
            let mut amplitudes = [0.0, 0.0];
            let mut sums = [0.0, 0.0];
            for place in (5000..25000).map(|i| (f64::from(i) + 0.5) / 100.0) {
                let value = force.ramps[place as usize].at(place.fract());
                for (k, wave) in [(speed * place).sin(), (speed * place).cos()].into_iter().enumerate() {
                    amplitudes[k] += (value - (speed * place).sin()) * wave;
                    sums[k] += wave * wave;
                }
            }
            let off = (amplitudes[0] / sums[0]).hypot(amplitudes[1] / sums[1]);
            assert!(off < most, "{speed}: {off:e}");
        }
    }

    #[test]
    fn a_load_loses_most_of_its_noise_and_none_of_its_course() {
        const SAMPLES: usize = 1600;
        let mut random = crate::numeric::random::Random::new(3);
        let load: Vec<f64> = (0..SAMPLES).map(|k| 30.0 + 10.0 * (TAU * k as f64 / 400.0).sin()).collect();
        let noisy: Vec<f64> = load.iter().map(|load| load + 0.3 * random.normal()).collect();
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let record = |excitation, regime| {
            let time = (0..SAMPLES).map(|k| 1e-3 * k as f64).collect();
            let force = (0..SAMPLES).map(|k| (TAU * k as f64 / 100.0).cos()).collect();
            let load = channel("normal_load", "N", Vec::clone(&noisy));
            let channels = vec![channel("time", "s", time), channel(excitation, "N", force), load];
            Record { name: "r".into(), regime, use_for: None, channels }
        };
        let masses = [Regime::FromRest, Regime::Steady]
            .map(|regime| Excitation::of_masses(&record("excitation:m1", regime), &["m1"]).unwrap());
        let beam = Excitation::of_beam(&record("excitation", Regime::FromRest)).unwrap();
        for Excitation { load: found, samples, periodic, .. } in masses.into_iter().chain([beam]) {
            let found = found.unwrap();
            let off =
                found.values().iter().zip(&load).take(samples).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            assert!((off / samples as f64).sqrt() < 0.1, "{periodic} {samples}: {off}");
        }
    }

    #[test]
    fn what_jumps_runs_on_straight_lines() {
        let values: Vec<f64> = (0..60).map(|k| if k < 30 { -1.0 } else { 1.0 }).collect();
        let force = ExcitationForce::new(0, &values, false, true);
        assert!(force.ramps.iter().all(|ramp| ramp.bow == 0.0 && ramp.skew == 0.0));
        assert_eq!([force.ramp(29, 30), force.ramp(59, 59)], [Ramp::line(-1.0, 1.0), Ramp::held(1.0)]);
    }
}
