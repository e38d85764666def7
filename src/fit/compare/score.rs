//! The error of a prediction.

use super::comparison::{ChannelResult, RecordResult};
use crate::data::{Channel, Record};
use crate::fit::predict::{Seed, compared, deviation, predict_from};
use crate::model::Model;

/// Predicts and scores, from the solution `seed` if there is one; a failure is kept as text, for the other records
/// still count.
pub(crate) fn scored(model: &Model, record: &Record, seed: Option<&Seed>) -> RecordResult {
    let channels = predict_from(model, record, seed).and_then(|predictions| {
        let pairs = compared(model, record).into_iter().zip(predictions);
        pairs.map(|(measured, predicted)| channel(measured, predicted.values)).collect()
    });
    match channels {
        Ok(channels) => self::record(channels),
        Err(failure) => RecordResult { error: f64::NAN, channels: Vec::new(), failure: Some(failure) },
    }
}

/// Prediction minus measurement of every compared channel, over its standard deviation and over the
/// square root of its length: the sum of squares is that of the channels' normalised errors. Values of a table that have
/// intervals of their own weigh by these.
pub(crate) fn normalised_residual(model: &Model, record: &Record) -> Result<Vec<f64>, String> {
    let mut residual = Vec::new();
    for (channel, predicted) in compared(model, record).into_iter().zip(predict_from(model, record, None)?) {
        let weights = record.weights(channel);
        let scale = deviation(channel)? * weights.iter().map(|w| w * w).sum::<f64>().sqrt();
        let rows = channel.values.iter().zip(predicted.values).zip(weights);
        residual.extend(rows.map(|((measured, value), weight)| weight * (value - measured) / scale));
    }
    Ok(residual)
}

/// Scores `predicted` against the measured `channel`; both have the same length and unit.
///
/// A channel that does not vary has no standard deviation to measure an error by and is refused.
pub(crate) fn channel(channel: &Channel, predicted: Vec<f64>) -> Result<ChannelResult, String> {
    let deviation = deviation(channel)?;
    let squares =
        channel.values.iter().zip(&predicted).map(|(measured, predicted)| (predicted - measured).powi(2));
    let rms = (squares.sum::<f64>() / channel.values.len() as f64).sqrt();
    if !rms.is_finite() {
        return Err(format!("the prediction of `{}` is not finite", channel.name));
    }
    Ok(ChannelResult {
        name: channel.name.clone(),
        unit: channel.unit,
        error: rms / deviation,
        rms,
        predicted,
    })
}

/// Root-mean-square of the channels' normalised errors.
pub(crate) fn record(channels: Vec<ChannelResult>) -> RecordResult {
    let error = root_mean_square(channels.iter().map(|channel| channel.error));
    RecordResult { error, channels, failure: None }
}

/// Root-mean-square over all channels of all records that could be predicted; NaN when none could.
pub(crate) fn total(records: &[RecordResult]) -> f64 {
    root_mean_square(records.iter().flat_map(|record| &record.channels).map(|channel| channel.error))
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value * value, count + 1));
    (sum / count as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn force(values: &[f64]) -> Channel {
        Channel { name: "force".into(), unit: "N", values: values.to_vec(), noise: None }
    }

    #[test]
    fn an_error_is_a_fraction_of_the_standard_deviation() {
        let scored = channel(&force(&[1.0, -1.0, 1.0, -1.0]), vec![1.5, -0.5, 0.5, -1.5]).unwrap();
        assert_eq!((scored.rms, scored.error), (0.5, 0.5));
    }

    #[test]
    fn what_has_no_scale_or_no_prediction_is_refused_and_not_scored() {
        // Three times 0.1 has a mean that rounding moves off 0.1.
        for values in [&[0.1, 0.1, 0.1][..], &[5.0], &[0.0, 0.0]] {
            let refused = channel(&force(values), vec![1.0; values.len()]).unwrap_err();
            assert!(refused.contains("the same number"), "{refused}");
        }
        let refused = channel(&force(&[1e300, -1e300]), vec![0.0; 2]).unwrap_err();
        assert!(refused.contains("overflow"), "{refused}");
        for value in [f64::NAN, f64::INFINITY, 1e200] {
            let refused = channel(&force(&[1.0, 2.0]), vec![value; 2]).unwrap_err();
            assert!(refused.contains("not finite"), "{refused}");
        }
    }
}
