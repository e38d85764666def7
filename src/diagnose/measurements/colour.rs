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
/// Memories tried, from none in equal steps of this.
const STEP: f64 = 0.01;
/// A memory of so many of the longest differences cannot be told from one without an end.
const LONGEST: f64 = 4.0;

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

/// How much of a sample's noise the next one keeps, by the quantity that drives a model: its records share it.
#[derive(Debug, Default)]
pub(in crate::diagnose) struct Memories(Vec<(String, f64)>);

impl Memories {
    /// Of all that drives `model` in `records`.
    pub fn of<'r>(model: &Model, records: impl Iterator<Item = &'r Record>) -> Self {
        let mut quantities: Vec<(String, Vec<Differences>)> = Vec::new();
        for record in records.filter(|record| record.sample_step().is_some()) {
            for channel in record.channels.iter().filter(|channel| drives(model, record, channel)) {
                let differences = Differences::of(&channel.values);
                match quantities.iter_mut().find(|(quantity, _)| quantity == channel.quantity()) {
                    Some((_, known)) => known.push(differences),
                    None => quantities.push((channel.quantity().to_owned(), vec![differences])),
                }
            }
        }
        Self(quantities.into_iter().map(|(quantity, of)| (quantity, memory(&of))).collect())
    }

    /// The noise of `values` of a quantity; `None` where they do not show it.
    pub fn colour(&self, quantity: &str, values: &[f64]) -> Option<Colour> {
        let memory = self.0.iter().find(|(known, _)| known == quantity).map_or(0.0, |(_, memory)| *memory);
        let deviation = Differences::of(values).deviation(memory)?;
        Some(Colour { deviation, memory })
    }
}

/// What the differences of a record say as long as they are those of noise: the deviation of white noise that would make those
/// of each of the first [`SPACINGS`], and the weight of what it says.
#[derive(Debug)]
struct Differences(Vec<(usize, f64, f64)>);

impl Differences {
    fn of(values: &[f64]) -> Self {
        let of = |spacing: usize| {
            let noise = noise_over(values, spacing).filter(|noise| *noise > 0.0)?;
            Some((spacing, noise, values.len() as f64 / spacing as f64))
        };
        Self(SPACINGS.into_iter().map_while(of).collect())
    }

    fn weight(&self) -> f64 {
        self.0.iter().map(|(_, _, weight)| weight).sum()
    }

    /// The deviation of noise with this `memory`; `None` where no difference shows noise.
    fn deviation(&self, memory: f64) -> Option<f64> {
        let logarithms =
            self.0.iter().map(|(spacing, noise, weight)| weight * (noise / seen(memory, *spacing)).ln());
        (!self.0.is_empty()).then(|| (logarithms.sum::<f64>() / self.weight()).exp())
    }

    /// How little the spacings agree on one deviation.
    fn disagreement(&self, memory: f64) -> f64 {
        let Some(deviation) = self.deviation(memory) else { return 0.0 };
        let off = |(spacing, noise, weight): &(usize, f64, f64)| {
            weight * (noise / (deviation * seen(memory, *spacing))).ln().powi(2)
        };
        self.0.iter().map(off).sum()
    }
}

/// The deviation of white noise that makes the fourth differences of noise with this `memory` and a deviation of one.
fn seen(memory: f64, spacing: usize) -> f64 {
    let r = memory.powi(spacing as i32);
    ((70.0 - r * (112.0 - r * (56.0 - r * (16.0 - 2.0 * r)))) / 70.0).sqrt()
}

/// The memory by which the differences of all records agree best.
fn memory(records: &[Differences]) -> f64 {
    let longest = records.iter().flat_map(|record| &record.0).map(|(spacing, _, _)| *spacing).max();
    let Some(longest) = longest else { return 0.0 };
    let most = (-1.0 / (LONGEST * longest as f64)).exp();
    let disagreement = |memory: f64| records.iter().map(|record| record.disagreement(memory)).sum::<f64>();
    let tried = (0..).map(|k| STEP * f64::from(k)).take_while(|memory| *memory < most).chain([most]);
    tried
        .map(|memory| (memory, disagreement(memory)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(0.0, |best| best.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Sweeps with noise of this deviation and memory.
    fn sweeps(deviation: f64, memory: f64) -> Vec<Vec<f64>> {
        let mut random = Random::new(5);
        let sweep = |rate: f64| {
            let mut noise = random.normal();
            let mut value = |i: u32| {
                let time = f64::from(i) / 2400.0;
                noise = memory * noise + (1.0 - memory * memory).sqrt() * random.normal();
                (TAU * rate * time * (1.0 + time)).sin() + deviation * noise
            };
            (0..2400).map(&mut value).collect()
        };
        [2.0, 3.0, 5.0].map(sweep).to_vec()
    }

    #[test]
    fn the_memory_of_noise_on_what_never_repeats_is_told() {
        for (memory, least, most) in
            [(0.0, 0.0, 0.15), (0.6, 0.5, 0.7), (0.9, 0.83, 0.95), (0.95, 0.88, 0.985)]
        {
            for deviation in [3e-4, 3e-3] {
                let sweeps = sweeps(deviation, memory);
                let found =
                    super::memory(&sweeps.iter().map(|values| Differences::of(values)).collect::<Vec<_>>());
                assert!((least..=most).contains(&found), "{memory} {deviation}: {found}");
                for values in &sweeps {
                    let size = Differences::of(values).deviation(found).unwrap() / deviation;
                    assert!((0.6..2.0).contains(&size), "{memory} {deviation}: {size}");
                }
            }
        }
        let clean = sweeps(0.0, 0.0);
        assert!(clean.iter().all(|values| Differences::of(values).deviation(0.0).is_none()));
    }
}
