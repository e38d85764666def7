//! The noise of what drives a model acts through it: the displacement's through the stiffness in stick, the
//! excitation's through the structure. How much it makes of the predictions is found by adding as much again; what it makes of
//! parameters, by other noise of its colour.

use rayon::prelude::*;

use super::colour::{Colour, Memories};
use super::weighted_dataset::{RecordResiduals, WeightedDataset};
use crate::data::{Channel, Record, Regime};
use crate::fit::predict::{Motion, compared, drives, white_noise_of_few};
use crate::model::Model;
use crate::numeric::random::Random;

/// Standard deviation of what the inputs' noise makes of each compared channel of each record, under `model`.
pub(in crate::diagnose) fn through(model: &Model, bench: &WeightedDataset) -> Vec<Vec<f64>> {
    bench
        .lanes
        .par_iter()
        .enumerate()
        .map(|(index, lane)| one(model, lane, index).unwrap_or_default())
        .collect()
}

/// The drawings of a record's noise have numbers of their own.
const PART: u64 = 1;

/// A record whose inputs have other noise than they had.
pub(in crate::diagnose) struct Redrawn {
    /// With what smoothing leaves of its own: of noise with a memory, most.
    pub quiet: Record,
    /// Pairs of it with opposite noises.
    pub pairs: Vec<[Record; 2]>,
}

/// So many pairs of `record` with other noise in what drives `model`, others with another `seed`; `None` where it has none.
/// Samples that are not evenly spaced are not smoothed before.
pub(in crate::diagnose) fn redrawn(
    model: &Model,
    record: &Record,
    memories: &Memories,
    (count, seed): (usize, u64),
) -> Option<Redrawn> {
    let mut random = Random::of_part(seed, PART);
    let mut quiet = record.clone();
    let mut noises = Vec::new();
    for (k, channel) in record.channels.iter().enumerate() {
        let drives = drives(model, record, channel);
        let Some(colour) = drives.then(|| colour(channel, record, memories)).flatten() else { continue };
        if let Some(step) = record.sample_step() {
            quiet.channels[k].values = Motion::even(&channel.values, step).values;
        }
        noises.push((k, colour));
    }
    if noises.is_empty() {
        return None;
    }
    let mut pair = || {
        let mut pair = [quiet.clone(), quiet.clone()];
        for (k, colour) in &noises {
            let [one, other] = pair.each_mut().map(|record| &mut record.channels[*k].values);
            let noise = colour.drawn(one.len(), &mut random);
            for ((one, other), noise) in one.iter_mut().zip(other).zip(noise) {
                *one += noise;
                *other -= noise;
            }
        }
        pair
    };
    let pairs = (0..count).map(|_| pair()).collect();
    Some(Redrawn { quiet, pairs })
}

/// Noise of a driving channel and what it remembers: what the dataset states or what is seen; `None` where there is none.
fn colour(channel: &Channel, record: &Record, memories: &Memories) -> Option<Colour> {
    let white = Colour { deviation: input_noise(channel, record.regime), memory: 0.0 };
    if white.deviation == 0.0 {
        return None;
    }
    let coloured = |step: f64| memories.colour(channel.quantity(), &channel.values, step);
    let seen = record.sample_step().and_then(coloured).unwrap_or(white);
    Some(Colour { deviation: channel.noise.unwrap_or(seen.deviation), ..seen })
}

/// `record` with white noise added to what drives `model`; `None` where it has none.
fn noisy(model: &Model, record: &Record, seed: u64) -> Option<Record> {
    let mut noisy = record.clone();
    let mut random = Random::new(seed);
    let mut any = false;
    for channel in &mut noisy.channels {
        let noise = if drives(model, record, channel) { input_noise(channel, record.regime) } else { 0.0 };
        if noise > 0.0 {
            any = true;
            channel.values.iter_mut().for_each(|value| *value += noise * random.normal());
        }
    }
    any.then_some(noisy)
}

fn one(model: &Model, lane: &RecordResiduals, index: usize) -> Result<Vec<f64>, String> {
    let record = lane.record;
    let Some(shaken) = noisy(model, record, index as u64) else { return Ok(Vec::new()) };
    let mut values = [Vec::new(), Vec::new()];
    for (record, values) in [record, &shaken].into_iter().zip(&mut values) {
        let mut shown = lane.shown_as(model, record, lane.seed.as_ref())?;
        let nuisances = shown.settle(model)?;
        shown.predict(model, &nuisances, values)?;
    }
    let [plain, shaken] = values;
    let mut start = 0;
    Ok(compared(model, record)
        .iter()
        .map(|channel| {
            let range = start..start + channel.values.len();
            start = range.end;
            size(&range.map(|i| shaken[i] - plain[i]).collect::<Vec<_>>())
        })
        .collect())
}

/// Standard deviation of a change without its slow part: a start that was fitted anew moves a whole stretch of
/// a prediction, and would not have moved under the same noise twice.
fn size(change: &[f64]) -> f64 {
    let lag = (change.len() / 20).max(1);
    let mut differences: Vec<f64> =
        change.iter().zip(change.get(lag..).unwrap_or(&[])).map(|(a, b)| (b - a).abs()).collect();
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    *median / 0.674_489_75 / 2.0_f64.sqrt()
}

/// Noise of a driving channel: what the dataset states, or its white part; the rows of a table are no course in time.
fn input_noise(channel: &Channel, regime: Regime) -> f64 {
    channel.noise.unwrap_or_else(|| if regime.is_table() { 0.0 } else { white_noise_of_few(&channel.values) })
}
