//! What a model predicts of a record, whatever the model's kind and the record's regime.

use super::comparison::RecordResult;
use super::oscillator_record::OscillatorRecord;
use super::simulation::Simulation as _;
use super::{beam_record, contact_record, score};
use crate::measure::{Channel, Record, Regime};
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
        (Structure::Prescribed, _) => {
            Roles { inputs: &["time", "displacement", "velocity"], compared: &["force"] }
        }
        (Structure::Beam(_), Regime::Backbone) => {
            Roles { inputs: &["amplitude"], compared: &["frequency", "damping_ratio"] }
        }
        (Structure::Oscillator(_), _) => Roles {
            inputs: if model.changes().joint.load_gain.is_some() {
                &["time", "excitation", "normal_load"]
            } else {
                &["time", "excitation"]
            },
            compared: &["acceleration", "velocity", "displacement"],
        },
        (Structure::Beam(_), _) => {
            Roles { inputs: &["time", "excitation"], compared: &["acceleration", "velocity", "displacement"] }
        }
    }
}

/// The channels of `record` that a model of this structure predicts.
pub(super) fn compared<'r>(model: &Model, record: &'r Record) -> Vec<&'r Channel> {
    roles(model, record.regime).compared.iter().flat_map(|quantity| record.channels_of(quantity)).collect()
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

/// One prediction per compared channel.
fn predictions<'r>(model: &Model, record: &'r Record) -> Result<Vec<Prediction<'r>>, String> {
    let channels = compared(model, record);
    if channels.is_empty() {
        return Err("it has no column that the model predicts".into());
    }
    match (&model.structure, &model.contact) {
        (Structure::Prescribed, Some(contact)) => {
            let law = model.law().map_err(|error| error.to_string())?.ok_or("the model has no [contact]")?;
            let force = contact_record::predict(law.as_ref(), contact.normal_load, record)?;
            Ok(channels.into_iter().map(|channel| (channel, force.clone())).collect())
        }
        (Structure::Prescribed, None) => Err("the model has no [contact]".into()),
        (Structure::Oscillator(_), _) => {
            let mut simulation = OscillatorRecord::new(model, record, channels.clone())?;
            let start: Vec<f64> = simulation.nuisances(model)?.iter().map(|found| found.start).collect();
            let mut values = Vec::new();
            simulation.predict(model, &start, &mut values)?;
            Ok(channels.into_iter().zip(values.chunks_exact(record.len()).map(<[f64]>::to_vec)).collect())
        }
        (Structure::Beam(_), _) => beam_record::predict(model, record, channels),
    }
}

/// Predicts and scores; a failure is kept as text, for the other records still count.
pub(super) fn scored(model: &Model, record: &Record) -> RecordResult {
    let channels = predictions(model, record).and_then(|predictions| {
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
    for (channel, predicted) in predictions(model, record)? {
        let scale = score::deviation(channel)? * (channel.values.len() as f64).sqrt();
        residual
            .extend(channel.values.iter().zip(predicted).map(|(measured, value)| (value - measured) / scale));
    }
    Ok(residual)
}
