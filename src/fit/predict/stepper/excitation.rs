//! What excites a structure, from the columns of a record.

use crate::data::{Record, Regime};
use crate::numeric::band_limited::band_limited;
use crate::numeric::common_periods;
use crate::time::Ramp;

/// Values between two samples of a force on a beam: parabolas through them follow it up to half the sampling rate.
const FINER: usize = 4;

/// A force between its samples.
#[derive(Debug, Clone)]
pub(in crate::fit::predict) struct Between {
    values: Vec<f64>,
    bows: Vec<f64>,
}

impl Between {
    /// Of evenly spaced samples that determine it.
    fn of(samples: &[f64]) -> Option<Self> {
        let values = band_limited(samples, FINER)?;
        Some(Self { bows: bows(&values, false), values })
    }

    /// The force over the parts of the interval after sample `index`, in order.
    pub fn parts(&self, index: usize) -> impl Iterator<Item = Ramp> {
        let first = index * FINER;
        let ramp =
            move |at: usize| Ramp { bow: self.bows[at], ..Ramp::line(self.values[at], self.values[at + 1]) };
        (first..(first + FINER).min(self.values.len() - 1)).map(ramp)
    }
}

/// A measured force.
#[derive(Debug, Clone)]
pub(in crate::fit::predict) struct ExcitationForce {
    /// Place of the mass, or of the one exciter of a beam.
    pub at: usize,
    /// At the samples (N).
    pub values: Vec<f64>,
    /// Bow from each sample to the next, as [`crate::time::Ramp::bow`]: what shakers do between two samples is
    /// smooth, and a straight line would be too small by `(ωh)²/12`. Empty for straight lines.
    pub bows: Vec<f64>,
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
    /// The first of the forces between the samples, where these determine it.
    pub between: Option<Between>,
    /// Measured normal load (N).
    pub load: Option<Vec<f64>>,
}

impl Excitation {
    /// Of a record of a beam: as smooth between samples as these say, else on straight lines.
    pub fn of_beam(record: &Record) -> Result<Self, String> {
        let time = record.time().ok_or("there is no `time` column")?.to_vec();
        let values = record.channel("excitation").ok_or("there is no `excitation` column")?.values.clone();
        let between = record.sample_step().and_then(|_| Between::of(&values));
        let force = ExcitationForce { at: 0, values, bows: Vec::new() };
        let load = record.channel("normal_load").map(|channel| channel.values.clone());
        Ok(Self { time, samples: record.len(), periodic: false, forces: vec![force], between, load })
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
        let forces = forces
            .into_iter()
            .map(|(at, values)| ExcitationForce { at, bows: bows(&values, periodic), values })
            .collect();
        Ok(Self { time: vec![0.0, step], samples, periodic, forces, between: None, load })
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

/// Bows by the mean second difference at the two ends of each interval.
fn bows(values: &[f64], periodic: bool) -> Vec<f64> {
    let count = values.len();
    let at = |index: usize, ahead: usize| match index + ahead {
        next if next < count => values[next],
        next if periodic => values[next % count],
        _ => values[count - 1],
    };
    (0..count)
        .map(|index| {
            let before = match index {
                0 if periodic => values[count - 1],
                0 => values[0],
                _ => values[index - 1],
            };
            if !periodic && (index == 0 || index + 2 >= count) {
                return 0.0;
            }
            0.25 * (at(index, 0) + at(index, 1) - before - at(index, 2))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bows_follow_a_parabola_exactly() {
        let values: Vec<f64> = (0..10).map(|i| 3.0 - 2.0 * f64::from(i) + 0.5 * f64::from(i * i)).collect();
        let bows = bows(&values, false);
        for index in 1..8 {
            let s = 0.3;
            let found = values[index] + (values[index + 1] - values[index]) * s + bows[index] * s * (1.0 - s);
            let t = index as f64 + s;
            assert!((found - (3.0 - 2.0 * t + 0.5 * t * t)).abs() < 1e-12);
        }
    }
}
