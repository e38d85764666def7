//! Model against measurement: predict every record, score the predictions, refit the model, compare again.
//!
//! [`evaluate`] makes a [`Stage`] of one model and a dataset, [`refit`] of the model whose free parameters fit best;
//! a [`Comparison`] holds both for tables and reports.

mod comparison;
mod nested;
mod refit;
mod score;
mod unseen;

pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage, StepGain};
pub(crate) use nested::Nested;
pub use refit::{Refit, RefitError, Watch, refit};

use crate::data::Dataset;
use crate::fit::predict::Seed;
use crate::model::Model;

/// Predicts every record of `dataset` with `model` and scores the predictions.
///
/// A record that cannot be predicted keeps the reason in [`RecordResult::failure`]; the others count.
pub fn evaluate(name: &str, model: &Model, dataset: &Dataset) -> Stage {
    evaluate_from(name, model, dataset, |_| None)
}

/// The same, each record from the solution that `seed` has for its index.
pub(crate) fn evaluate_from(
    name: &str,
    model: &Model,
    dataset: &Dataset,
    seed: impl Fn(usize) -> Option<Seed>,
) -> Stage {
    let numbered = dataset.records.iter().enumerate();
    let records: Vec<RecordResult> =
        numbered.map(|(index, record)| score::scored(model, record, seed(index).as_ref())).collect();
    let parameters = model
        .parameters()
        .into_iter()
        .map(|parameter| Parameter {
            unit: parameter.quantity.unit,
            value: parameter.value,
            path: parameter.path,
            fitted_from: None,
        })
        .collect();
    Stage { name: name.to_owned(), parameters, error: score::total(&records), records, evaluations: 0 }
}
