//! The noise of what drives a model acts through it: the displacement's through the stiffness in stick, the
//! excitation's through the structure. How much it makes of the predictions is found by adding as much again.

use rayon::prelude::*;

use super::weighted_dataset::{RecordResiduals, WeightedDataset};
use crate::data::{Channel, Record};
use crate::fit::predict::{ObservedSimulation, compared, white_noise};
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

/// `record` with as much noise again in what drives `model`, other noise with another `seed`; `None` where it has none.
pub(in crate::diagnose) fn shaken(model: &Model, record: &Record, seed: u64) -> Option<Record> {
    let names: Vec<&str> = compared(model, record).iter().map(|channel| channel.name.as_str()).collect();
    let mut shaken = record.clone();
    let mut random = Random::new(seed);
    let mut any = false;
    for channel in &mut shaken.channels {
        let driving = !names.contains(&channel.name.as_str()) && channel.name != "time";
        let noise = if driving { input_noise(channel) } else { 0.0 };
        if noise > 0.0 {
            any = true;
            channel.values.iter_mut().for_each(|value| *value += noise * random.normal());
        }
    }
    any.then_some(shaken)
}

fn one(model: &Model, lane: &RecordResiduals, index: usize) -> Result<Vec<f64>, String> {
    let record = lane.record;
    let Some(shaken) = shaken(model, record, index as u64) else { return Ok(Vec::new()) };
    let mut values = [Vec::new(), Vec::new()];
    for (record, values) in [record, &shaken].into_iter().zip(&mut values) {
        let mut shown = ObservedSimulation::near(model, record, lane.seed.as_ref())?;
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

/// Noise of a driving channel: what the dataset states, or its white part.
fn input_noise(channel: &Channel) -> f64 {
    channel.noise.unwrap_or_else(|| white_noise(&channel.values))
}
