//! The noise of what drives a model: how large it is, and how long it remembers.
//!
//! No model tells it, and few records repeat anything. But fourth differences of a motion fall with the fourth power of the
//! samples between them, while those of noise with a memory grow until they are farther apart than it: the sizes of those over
//! several spacings, as far as they are noise, tell both.

use crate::data::Record;
use crate::fit::predict::{drives, noise_over};
use crate::model::Model;
use crate::numeric::random::Random;

/// Samples between the values of a difference.
const SPACINGS: [usize; 5] = [1, 2, 4, 8, 16];
/// Memories tried, over the shortest and the longest time between such values: what is shorter is none, what is longer cannot
/// be told from one without an end. And how many to an octave.
const RANGE: [f64; 2] = [0.25, 4.0];
const TO_AN_OCTAVE: f64 = 8.0;

/// A process of order one: its standard deviation, and how much of a sample the next one keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) struct Colour {
    pub deviation: f64,
    pub memory: f64,
}

impl Colour {
    /// So many samples of it.
    pub fn drawn(self, count: usize, random: &mut Random) -> Vec<f64> {
        let fresh = self.deviation * (1.0 - self.memory * self.memory).sqrt();
        let mut noise = self.deviation * random.normal();
        let next = |_| {
            let here = noise;
            noise = self.memory * here + fresh * random.normal();
            here
        };
        (0..count).map(next).collect()
    }
}

/// The time (s) after which a share of 1/e is left of noise, by the quantity that drives a model: its records share it.
#[derive(Debug, Default)]
pub(in crate::diagnose) struct Memories(Vec<(String, f64)>);

impl Memories {
    /// Of all that drives `model` in `records`.
    pub fn of<'r>(model: &Model, records: impl Iterator<Item = &'r Record>) -> Self {
        let mut quantities: Vec<(String, Vec<Differences>)> = Vec::new();
        for record in records {
            let Some(step) = record.sample_step() else { continue };
            for channel in record.channels.iter().filter(|channel| drives(model, record, channel)) {
                let differences = Differences::of(&channel.values, step);
                match quantities.iter_mut().find(|(quantity, _)| quantity == channel.quantity()) {
                    Some((_, known)) => known.push(differences),
                    None => quantities.push((channel.quantity().to_owned(), vec![differences])),
                }
            }
        }
        Self(quantities.into_iter().map(|(quantity, of)| (quantity, memory(&of))).collect())
    }

    /// The noise of `values` of a quantity every `step` seconds; `None` where they do not show it.
    pub fn colour(&self, quantity: &str, values: &[f64], step: f64) -> Option<Colour> {
        let memory = self.0.iter().find(|(known, _)| known == quantity).map_or(0.0, |(_, memory)| *memory);
        let deviation = Differences::of(values, step).deviation(memory)?;
        Some(Colour { deviation, memory: kept(memory, step) })
    }
}

/// The fraction of noise with this `memory` that a `time` later still holds (both s).
fn kept(memory: f64, time: f64) -> f64 {
    if memory > 0.0 { (-time / memory).exp() } else { 0.0 }
}

/// What fourth differences of a record say as long as they are those of noise.
#[derive(Debug)]
struct Differences(Vec<Over>);

/// Those over one spacing.
#[derive(Debug)]
struct Over {
    /// Between the values of a difference (s).
    time: f64,
    /// Deviation of the white noise that would make them.
    noise: f64,
    /// The number of those that are independent.
    weight: f64,
}

impl Differences {
    /// Of `values` every `step` seconds.
    fn of(values: &[f64], step: f64) -> Self {
        let over = |spacing: usize| {
            let noise = noise_over(values, spacing).filter(|noise| *noise > 0.0)?;
            Some(Over { time: spacing as f64 * step, noise, weight: values.len() as f64 / spacing as f64 })
        };
        Self(SPACINGS.into_iter().map_while(over).collect())
    }

    /// The deviation of noise with this `memory` (s); `None` where no difference shows noise.
    fn deviation(&self, memory: f64) -> Option<f64> {
        let logarithm = |over: &Over| over.weight * (over.noise / seen(kept(memory, over.time))).ln();
        let weight: f64 = self.0.iter().map(|over| over.weight).sum();
        (!self.0.is_empty()).then(|| (self.0.iter().map(logarithm).sum::<f64>() / weight).exp())
    }

    /// How little the spacings agree on one deviation.
    fn disagreement(&self, memory: f64) -> f64 {
        let Some(deviation) = self.deviation(memory) else { return 0.0 };
        let off = |over: &Over| {
            over.weight * (over.noise / (deviation * seen(kept(memory, over.time)))).ln().powi(2)
        };
        self.0.iter().map(off).sum()
    }
}

/// The deviation of white noise that makes the fourth differences of noise with a deviation of one, of which `r` is kept from
/// one of their values to the next.
fn seen(r: f64) -> f64 {
    ((70.0 - r * (112.0 - r * (56.0 - r * (16.0 - 2.0 * r)))) / 70.0).sqrt()
}

/// The memory (s) by which the differences of all records agree best; none where no record shows noise over two spacings.
fn memory(records: &[Differences]) -> f64 {
    let telling = || records.iter().filter(|record| record.0.len() > 1);
    let times = || telling().flat_map(|record| &record.0).map(|over| over.time);
    let [shortest, longest] = [times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max)];
    let disagreement = |memory: f64| telling().map(|record| record.disagreement(memory)).sum::<f64>();
    let memory = |k: i32| RANGE[0] * shortest * (f64::from(k) / TO_AN_OCTAVE).exp2();
    let tried = (0..).map(memory).take_while(|memory| *memory <= RANGE[1] * longest);
    let (mut best, mut least) = (0.0, disagreement(0.0));
    for memory in tried {
        let here = disagreement(memory);
        if here < least {
            (best, least) = (memory, here);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const STEP: f64 = 1.0 / 2400.0;

    /// A sweep that begins at `rate` (Hz), with noise of this deviation and memory, every so many samples.
    fn sweep(rate: f64, deviation: f64, memory: f64, every: usize, random: &mut Random) -> Differences {
        let noise = Colour { deviation, memory }.drawn(2400 * every, random);
        let value = |(i, noise): (usize, f64)| {
            let time = i as f64 * STEP;
            (TAU * rate * time * (1.0 + time)).sin() + noise
        };
        let values: Vec<f64> = noise.into_iter().enumerate().step_by(every).map(value).collect();
        Differences::of(&values, every as f64 * STEP)
    }

    #[test]
    fn the_memory_of_noise_on_what_never_repeats_is_told() {
        for (memory, least, most) in
            [(0.0, 0.0, 0.15), (0.6, 0.5, 0.7), (0.9, 0.83, 0.95), (0.95, 0.88, 0.985)]
        {
            for deviation in [3e-4, 3e-3] {
                // One of them was sampled half as fast.
                let mut random = Random::new(5);
                let sweeps = [(2.0, 1), (3.0, 1), (1.0, 2)]
                    .map(|(rate, every)| sweep(rate, deviation, memory, every, &mut random));
                let found = super::memory(&sweeps);
                let kept = kept(found, STEP);
                assert!((least..=most).contains(&kept), "{memory} {deviation}: {kept}");
                for sweep in &sweeps {
                    let size = sweep.deviation(found).unwrap() / deviation;
                    assert!((0.6..2.0).contains(&size), "{memory} {deviation}: {size}");
                }
            }
        }
        assert!(sweep(2.0, 0.0, 0.0, 1, &mut Random::new(5)).deviation(0.0).is_none());
    }

    #[test]
    fn noise_that_shows_over_one_spacing_has_no_memory() {
        for seed in 0..9 {
            let mut random = Random::new(seed);
            let value = |i: u32| (TAU * f64::from(i) / 20.0).sin() + 3e-3 * random.normal();
            let wave = Differences::of(&(0..2400).map(value).collect::<Vec<_>>(), STEP);
            assert_eq!(wave.0.len(), 1);
            assert_eq!(memory(&[wave]), 0.0);
        }
    }
}
