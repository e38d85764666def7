//! What a model predicts of a record, whatever the model's kind and the record's regime.

use super::comparison::RecordResult;
use super::{beam_record, contact_record, score};
use crate::measure::{Channel, Record};
use crate::model::{Model, Structure};

/// The channels of `record` that a model of this structure predicts; the others are its inputs.
pub(super) fn compared<'r>(model: &Model, record: &'r Record) -> Vec<&'r Channel> {
    let quantities: &[&str] = match model.structure {
        Structure::Prescribed => &["force"],
        Structure::Beam(_) => &["frequency", "acceleration"],
    };
    quantities.iter().flat_map(|quantity| record.channels_of(quantity)).collect()
}

/// One prediction per compared channel, in its unit.
fn predictions(model: &Model, record: &Record) -> Result<Vec<Vec<f64>>, String> {
    match (&model.structure, &model.contact) {
        (Structure::Prescribed, Some(contact)) => {
            let law = contact.law().map_err(|error| error.to_string())?;
            Ok(vec![contact_record::predict(law.as_ref(), contact.normal_load, record)?])
        }
        (Structure::Prescribed, None) => Err("the model has no [contact]".into()),
        (Structure::Beam(beam), contact) => beam_record::predict(beam, contact.as_ref(), record),
    }
}

/// Predicts and scores; a failure is kept as text, for the other records still count.
pub(super) fn scored(model: &Model, record: &Record) -> RecordResult {
    let channels = predictions(model, record).and_then(|predicted| {
        let compared = compared(model, record);
        compared.into_iter().zip(predicted).map(|(channel, values)| score::channel(channel, values)).collect()
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
    for (channel, predicted) in compared(model, record).into_iter().zip(predictions(model, record)?) {
        let scale = score::standard_deviation(&channel.values) * (channel.values.len() as f64).sqrt();
        residual
            .extend(channel.values.iter().zip(predicted).map(|(measured, value)| (value - measured) / scale));
    }
    Ok(residual)
}
