//! Model against measurement: predict every record, score the predictions, refit the model, compare again.
//!
//! [`evaluate`] makes a [`Stage`] of one model and a dataset, [`refit`] of the model whose free parameters fit best;
//! a [`Comparison`] holds both for tables and reports.
//!
//! ```
//! use stickslip::data::{Channel, Dataset, Record, Regime};
//! use stickslip::fit::compare::{Watch, evaluate, refit};
//! use stickslip::model::Model;
//! // A slider that was pulled 1 mm, and a model of it that slips too early.
//! let model = Model::parse(
//!     r#"
//!     schema = "stickslip.model/1"
//!     kind = "contact"
//!     contact = { law = "jenkins", tangential_stiffness = 2e3, friction_coefficient = 0.08, normal_load = 10.0 }
//!     fit = { free = ["contact.friction_coefficient"] }
//!     "#,
//! )?;
//! let channel = |name: &str, unit, values: &[f64]| Channel {
//!     name: name.to_owned(),
//!     unit,
//!     values: values.to_vec(),
//!     noise: None,
//! };
//! let record = Record {
//!     name: "pull".to_owned(),
//!     regime: Regime::FromRest,
//!     use_for: None,
//!     channels: vec![
//!         channel("time", "s", &[0.0, 1.0, 2.0, 3.0, 4.0]),
//!         channel("displacement", "m", &[0.0, 0.25e-3, 0.5e-3, 0.75e-3, 1e-3]),
//!         channel("force", "N", &[0.0, 0.5, 0.9, 0.9, 0.9]),
//!     ],
//! };
//! let dataset = Dataset { title: None, records: vec![record] };
//! let before = evaluate("baseline", &model, &dataset);
//! let after = refit("refitted", &model, &dataset, Watch::default())?;
//! assert!(before.error > 0.1 && after.stage.error < 1e-6);
//! assert!((after.model.get("contact.friction_coefficient").unwrap() - 0.09).abs() < 1e-7);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod beyond;
mod comparison;
mod intervals;
mod nested;
mod refit;
mod score;
mod visibility;

pub use comparison::{ChannelResult, Comparison, Fitted, Parameter, RecordResult, Skipped, Stage, StepGain};
pub use refit::{Refit, RefitError, Watch, refit};
pub use visibility::{Shown, Visibility, visibility};

use rayon::prelude::*;

use crate::data::Dataset;
use crate::fit::predict::Seed;
use crate::model::Model;

/// Predicts every record of `dataset` with `model` and scores the predictions.
///
/// A record that cannot be predicted keeps the reason in [`RecordResult::failure`]; the others count.
///
/// ```
/// use stickslip::data::{Channel, Dataset, Record, Regime};
/// use stickslip::fit::compare::evaluate;
/// use stickslip::model::Model;
/// # let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
/// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.1\nnormal_load = 10.0";
/// let model = Model::parse(text)?;
/// let channel = |name: &str, unit, values: &[f64]| {
///     Channel { name: name.into(), unit, values: values.to_vec(), noise: None }
/// };
/// let channels = vec![
///     channel("time", "s", &[0.0, 1.0, 2.0]),
///     channel("displacement", "m", &[0.0, 0.25e-3, 1e-3]),
///     channel("force", "N", &[0.0, 0.5, 1.0]),
/// ];
/// let record = Record { name: "pull".into(), regime: Regime::FromRest, use_for: None, channels };
/// let dataset = Dataset { title: None, records: vec![record] };
/// assert!(evaluate("as given", &model, &dataset).error < 1e-12);
/// # Ok::<(), stickslip::model::ModelError>(())
/// ```
pub fn evaluate(name: &str, model: &Model, dataset: &Dataset) -> Stage {
    Stage { notes: beyond::notes(model, dataset), ..evaluate_from(name, model, dataset, |_| None) }
}

/// The same, each record from the solution that `seed` has for its index.
pub(crate) fn evaluate_from(
    name: &str,
    model: &Model,
    dataset: &Dataset,
    seed: impl Fn(usize) -> Option<Seed> + Sync,
) -> Stage {
    let numbered = dataset.records.par_iter().enumerate();
    let records: Vec<RecordResult> =
        numbered.map(|(index, record)| score::scored(model, record, seed(index).as_ref())).collect();
    let parameters = model
        .parameters()
        .into_iter()
        .map(|parameter| Parameter {
            unit: parameter.quantity.unit,
            value: parameter.value,
            path: parameter.path,
            fitted: None,
        })
        .collect();
    Stage {
        name: name.to_owned(),
        parameters,
        error: score::total(&records),
        records,
        evaluations: 0,
        notes: Vec::new(),
    }
}
