//! One predictor of records: a model and the columns that drive it come in, what the sensors would show comes out.
//!
//! [`predict`] is all that a user of the library needs. A fit predicts the same record many times and wants derivatives:
//! it holds an `ObservedSimulation`, a simulation behind its sensors.
//!
//! `regimes` chooses the simulation by the record's regime, and only below that by the kind of model:
//! [`from rest`](crate::data::Regime::FromRest) (`from_rest`), `steady`, `stepped_sine`, `unknown_start`, `backbone`. What is stepped in
//! time is a `stepper`; what a solver finds row by row is a `table`. Unknowns of one record, such as its start, are its nuisances; `settle` fits them.

mod backbone;
mod channels;
mod from_rest;
mod motion;
mod observed;
mod observed_system;
mod period;
mod regimes;
mod sensors;
mod settle;
mod simulation;
mod steady;
mod stepped_sine;
mod stepper;
mod table;
mod unknown_start;

pub(crate) use backbone::scatter_of_starts;
pub use channels::unused_columns;
pub(crate) use channels::{compared, derivative_order, deviation, drives};
pub(crate) use motion::{Motion, noise_over, white_noise, white_noise_of_few};
pub(crate) use observed::ObservedSimulation;
pub(crate) use period::period;
pub(crate) use simulation::{Direction, Seed, WRONG_BRANCH};

use crate::data::Record;
use crate::model::Model;

/// What a model predicts of one measured channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Name of the channel, as in the record: `force`, `acceleration:m2`, `frequency`.
    pub channel: String,
    /// At the record's samples, in the channel's unit.
    pub values: Vec<f64>,
}

/// Why a record cannot be predicted: a column that it lacks, or what the solver said.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PredictError(String);

/// What `model` predicts of every channel of `record` that it can predict, as its sensors would show it. The unknown
/// start of a record is fitted to the record.
///
/// ```
/// use stickslip::data::{Channel, Record, Regime};
/// use stickslip::fit::predict::predict;
/// use stickslip::model::Model;
/// // A slider with 2 N/mm up to 1 N, pulled 1 mm.
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "contact"
///     contact = { law = "jenkins", tangential_stiffness = 2e3, friction_coefficient = 0.1, normal_load = 10.0 }
///     "#,
/// )?;
/// let channel = |name: &str, unit, values: &[f64]| Channel {
///     name: name.to_owned(),
///     unit,
///     values: values.to_vec(),
///     noise: None,
/// };
/// let record = Record {
///     name: "pull".to_owned(),
///     regime: Regime::FromRest,
///     use_for: None,
///     channels: vec![
///         channel("time", "s", &[0.0, 1.0, 2.0, 3.0, 4.0]),
///         channel("displacement", "m", &[0.0, 0.25e-3, 0.5e-3, 0.75e-3, 1e-3]),
///         channel("force", "N", &[0.0, 0.4, 1.1, 1.0, 0.9]),
///     ],
/// };
/// let predicted = predict(&model, &record)?;
/// assert_eq!(predicted[0].channel, "force");
/// for (force, expected) in predicted[0].values.iter().zip([0.0, 0.5, 1.0, 1.0, 1.0]) {
///     assert!((force - expected).abs() < 1e-9);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PredictError`].
pub fn predict(model: &Model, record: &Record) -> Result<Vec<Prediction>, PredictError> {
    predict_from(model, record, None).map_err(PredictError)
}

/// The same, from the solution `seed` if there is one.
pub(crate) fn predict_from(
    model: &Model,
    record: &Record,
    seed: Option<&Seed>,
) -> Result<Vec<Prediction>, String> {
    let mut simulation = ObservedSimulation::near(model, record, seed)?;
    let nuisances = simulation.settle(model)?;
    let mut values = Vec::new();
    simulation.predict(model, &nuisances, &mut values)?;
    let mut rest = values.as_slice();
    Ok(compared(model, record)
        .into_iter()
        .map(|channel| {
            let (here, after) = rest.split_at(channel.values.len().min(rest.len()));
            rest = after;
            Prediction { channel: channel.name.clone(), values: here.to_vec() }
        })
        .collect())
}
