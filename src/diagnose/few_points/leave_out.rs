//! Every point of a table predicted by a model that was fitted to the others.

use rayon::prelude::*;

use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
use crate::diagnose::refit::trial::{self, Effort};
use crate::diagnose::residual::blocks::Gain;
use crate::diagnose::search::select::Search;
use crate::fit::InterruptHook;
use crate::model::Model;

/// Most refits of one model: in a longer table several points are left out at once.
const MOST_FOLDS: usize = 24;

/// Errors of the points that a fit did not see.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LeftOut {
    /// Per row of the table and channel, in the order of [`rows`]: (prediction − measurement) · weight.
    pub residuals: Vec<f64>,
    /// Sum of their squares per row.
    pub squares: Vec<f64>,
}

/// A row of a table: its record, and the indices of its values among those of the record.
pub(super) struct Row {
    pub record: usize,
    pub values: Vec<usize>,
}

/// All rows of all tables.
pub(super) fn rows(bench: &WeightedDataset) -> Vec<Row> {
    let of = |record: usize| {
        let channels = &bench.lanes[record].channels;
        let length = channels.iter().map(|(_, range)| range.len()).min().unwrap_or(0);
        (0..length).map(move |index| Row {
            record,
            values: channels.iter().map(|(_, range)| range.start + index).collect(),
        })
    };
    (0..bench.lanes.len()).flat_map(of).collect()
}

/// Refits `model`, itself fitted to all points, once for every point left out and predicts that point.
///
/// # Errors
/// Why one of the refits or its prediction failed.
pub(super) fn errors(
    search: &Search,
    interrupt: Option<InterruptHook>,
    model: &Model,
) -> Result<LeftOut, String> {
    let rows = rows(search.bench);
    let folds = rows.len().min(MOST_FOLDS);
    let found = (0..folds)
        .into_par_iter()
        .map(|fold| {
            let unseen: Vec<&Row> = rows.iter().skip(fold).step_by(folds).collect();
            without(search, interrupt, model, &unseen)
        })
        .collect::<Result<Vec<_>, String>>()?;
    let residuals = (0..rows.len()).map(|row| &found[row % folds][row / folds]);
    let squares = residuals.clone().map(|row| row.iter().map(|r| r * r).sum()).collect();
    Ok(LeftOut { residuals: residuals.flatten().copied().collect(), squares })
}

/// The residuals of the rows `unseen` after a fit to all others.
fn without(
    search: &Search,
    interrupt: Option<InterruptHook>,
    model: &Model,
    unseen: &[&Row],
) -> Result<Vec<Vec<f64>>, String> {
    let mut bench = WeightedDataset::new(model, search.bench.dataset, interrupt)
        .map_err(|(record, why)| format!("{record}: {why}"))?;
    for (lane, whole) in bench.lanes.iter_mut().zip(&search.bench.lanes) {
        lane.weights.clone_from(&whole.weights);
    }
    for row in unseen {
        for value in &row.values {
            bench.lanes[row.record].weights[*value] = 0.0;
        }
    }
    let fitted = trial::fit(&bench, model, &search.unknowns(model), &search.parts.fit, Effort::Screen)?;
    let scored = bench.score(&fitted.model, &search.parts.fit)?;
    let (refits, simulations) = bench.spent();
    (0..refits).for_each(|_| search.bench.count_refit());
    search.bench.count(simulations);
    let residual = |record: usize, value: usize| {
        let lane = &search.bench.lanes[record];
        let one = scored.iter().find(|one| one.record == record);
        one.map_or(f64::NAN, |one| (one.predictions[value] - lane.measured[value]) * lane.weights[value])
    };
    Ok(unseen
        .iter()
        .map(|row| row.values.iter().map(|value| residual(row.record, *value)).collect())
        .collect())
}

impl LeftOut {
    /// What this gains over `before`, point by point: the mean over its standard error, and the fraction.
    pub fn gain_over(&self, before: &Self) -> Gain {
        let gains: Vec<f64> = before.squares.iter().zip(&self.squares).map(|(old, new)| old - new).collect();
        let (count, total) = (gains.len() as f64, before.squares.iter().sum::<f64>());
        let sum: f64 = gains.iter().sum();
        let mean = sum / count;
        let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let z = if count > 1.0 && variance > 0.0 { mean / (variance / count).sqrt() } else { 0.0 };
        Gain { z, fraction: if total > 0.0 { sum / total } else { 0.0 } }
    }
}
