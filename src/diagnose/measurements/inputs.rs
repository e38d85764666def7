//! The noise of what drives a model acts through it: the displacement's through the stiffness in stick, the
//! excitation's through the structure. How much it makes of the predictions is found by adding as much again.

use rayon::prelude::*;

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

/// `record` with other noise in what drives `model` in place of that it has, another with another `seed`; `None` where it has
/// none. Samples that are not evenly spaced keep theirs as well.
pub(in crate::diagnose) fn redrawn(model: &Model, record: &Record, seed: u64) -> Option<Record> {
    noisy(model, record, seed, |values| {
        if let Some(step) = record.sample_step() {
            *values = Motion::even(values, step).values;
        }
    })
}

/// `record` with noise added to what drives `model`, after `prepare` has seen its values; `None` where it has none.
fn noisy(model: &Model, record: &Record, seed: u64, prepare: impl Fn(&mut Vec<f64>)) -> Option<Record> {
    let mut noisy = record.clone();
    let mut random = Random::new(seed);
    let mut any = false;
    for channel in &mut noisy.channels {
        let noise = if drives(model, record, channel) { input_noise(channel, record.regime) } else { 0.0 };
        if noise > 0.0 {
            any = true;
            prepare(&mut channel.values);
            channel.values.iter_mut().for_each(|value| *value += noise * random.normal());
        }
    }
    any.then_some(noisy)
}

fn one(model: &Model, lane: &RecordResiduals, index: usize) -> Result<Vec<f64>, String> {
    let record = lane.record;
    let Some(shaken) = noisy(model, record, index as u64, |_| ()) else { return Ok(Vec::new()) };
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
