//! A fitted model as a stage of a comparison.

use super::evidence::Posterior;
use super::measurements::weighted_dataset::WeightedDataset;
use crate::data::Dataset;
use crate::fit::compare::{Stage, evaluate_from};
use crate::model::Model;

/// The evaluation of a fitted model, its parameters marked with where they started.
pub(super) fn stage(
    name: &str,
    fitted: &Posterior,
    start: &Model,
    dataset: &Dataset,
    bench: &WeightedDataset,
) -> Stage {
    let mut stage = evaluate_from(name, &fitted.model, dataset, |record| bench.lanes[record].seed.clone());
    stage.evaluations = fitted.simulations;
    for parameter in &mut stage.parameters {
        let changed = fitted.unknowns.iter().any(|unknown| unknown.path == parameter.path);
        parameter.fitted_from = if changed { start.get(&parameter.path) } else { None };
    }
    stage
}
