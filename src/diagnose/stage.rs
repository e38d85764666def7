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
        parameter.fitted = fitted.fitted(&parameter.path, start.get(&parameter.path));
    }
    let unseen =
        stage.parameters.iter().filter(|one| one.fitted.as_ref().is_some_and(|fitted| fitted.unseen));
    stage.notes = unseen
        .map(|one| format!("no fitted record depends on `{}`, which keeps its value {}", one.path, one.value))
        .collect();
    stage
}
