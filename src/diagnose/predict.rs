//! What a model predicts of a record, whatever the model's kind and the record's regime.

use super::comparison::RecordResult;
use super::score;
use super::shown::Shown;
use super::simulation::Seed;
use crate::data::{Channel, Record, Regime};
use crate::model::{Model, Structure};

/// A measured channel and what the model predicts of it, in its unit.
pub(super) type Prediction<'r> = (&'r Channel, Vec<f64>);

/// What a comparison does with the columns of a record.
struct Roles {
    /// Quantities that drive the model.
    inputs: &'static [&'static str],
    /// Quantities that it predicts.
    compared: &'static [&'static str],
}

fn roles(model: &Model, regime: Regime) -> Roles {
    match (&model.structure, regime) {
        (Structure::Prescribed, _) => Roles {
            inputs: &["time", "displacement", "velocity", "normal_load", "normal_displacement"],
            compared: &["force"],
        },
        (Structure::Beam(_), Regime::Backbone) => {
            Roles { inputs: &["amplitude"], compared: &["frequency", "damping_ratio"] }
        }
        (Structure::Oscillator(_) | Structure::Beam(_), _) => Roles {
            inputs: if model.changes().joint.load_gain.is_some() {
                &["time", "excitation", "normal_load"]
            } else {
                &["time", "excitation"]
            },
            compared: &["acceleration", "velocity", "displacement"],
        },
    }
}

/// The channels of `record` that a model of this structure predicts. A contact's normal load is one where the
/// model has a normal stiffness and the approach was measured.
pub(super) fn compared<'r>(model: &Model, record: &'r Record) -> Vec<&'r Channel> {
    let roles = roles(model, record.regime);
    let mut channels: Vec<&Channel> =
        roles.compared.iter().flat_map(|quantity| record.channels_of(quantity)).collect();
    let elastic = model.contact.is_some_and(|contact| contact.normal_stiffness > 0.0);
    if model.structure == Structure::Prescribed && elastic && record.channel("normal_displacement").is_some()
    {
        channels.extend(record.channel("normal_load"));
    }
    channels
}

/// Time derivative of the displacement that a channel measures.
pub(super) fn derivative_order(channel: &Channel) -> usize {
    match channel.quantity() {
        "acceleration" => 2,
        "velocity" => 1,
        _ => 0,
    }
}

/// Names of the columns of `record` that a comparison with `model` leaves aside: neither do they drive the
/// model nor does it predict them. A measured normal load is one, since a model's load is constant.
pub fn unused_columns<'r>(model: &Model, record: &'r Record) -> Vec<&'r str> {
    let Roles { inputs, compared } = roles(model, record.regime);
    let unused = record.channels.iter().filter(|channel| {
        let quantity = channel.quantity();
        !inputs.contains(&quantity) && !compared.contains(&quantity)
    });
    unused.map(|channel| channel.name.as_str()).collect()
}

/// One prediction per compared channel, as the sensors show it. The start of the record is fitted to it.
fn predictions<'r>(
    model: &Model,
    record: &'r Record,
    seed: Option<&Seed>,
) -> Result<Vec<Prediction<'r>>, String> {
    let mut shown = Shown::near(model, record, seed)?;
    let nuisances = shown.settle(model)?;
    let mut values = Vec::new();
    shown.predict(model, &nuisances, &mut values)?;
    let mut rest = values.as_slice();
    Ok(compared(model, record)
        .into_iter()
        .map(|channel| {
            let (here, after) = rest.split_at(channel.values.len().min(rest.len()));
            rest = after;
            (channel, here.to_vec())
        })
        .collect())
}

/// Predicts and scores, from the solution `seed` if there is one; a failure is kept as text, for the other records
/// still count.
pub(super) fn scored(model: &Model, record: &Record, seed: Option<&Seed>) -> RecordResult {
    let channels = predictions(model, record, seed).and_then(|predictions| {
        predictions.into_iter().map(|(channel, values)| score::channel(channel, values)).collect()
    });
    match channels {
        Ok(channels) => score::record(channels),
        Err(failure) => RecordResult { error: f64::NAN, channels: Vec::new(), failure: Some(failure) },
    }
}

/// Prediction minus measurement of every compared channel, over its standard deviation and over the
/// square root of its length: the sum of squares is that of the channels' normalised errors.
pub(super) fn normalised_residual(model: &Model, record: &Record) -> Result<Vec<f64>, String> {
    let mut residual = Vec::new();
    for (channel, predicted) in predictions(model, record, None)? {
        let scale = score::deviation(channel)? * (channel.values.len() as f64).sqrt();
        residual
            .extend(channel.values.iter().zip(predicted).map(|(measured, value)| (value - measured) / scale));
    }
    Ok(residual)
}
