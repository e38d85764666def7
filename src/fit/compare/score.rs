//! The error of a prediction.

use std::sync::Mutex;

use super::comparison::{ChannelResult, RecordResult};
use crate::data::{Channel, Record};
use crate::fit::InterruptHook;
use crate::fit::predict::{ObservedSimulation, Seed, compared, deviation, predict_from};
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

/// The residuals of one record under one model after another. What belongs to the record alone is made once.
pub(crate) struct RecordResidual<'r> {
    record: &'r Record,
    channels: Vec<Weighed<'r>>,
    /// Simulations that no thread is using.
    idle: Mutex<Vec<ObservedSimulation<'r>>>,
}

/// A channel, and by what each of its residuals is multiplied.
struct Weighed<'r> {
    channel: &'r Channel,
    scale: f64,
    /// For each value of a table that has intervals of its own; empty where all weigh the same.
    own: Vec<f64>,
}

impl<'r> RecordResidual<'r> {
    /// Of `record`, for models of the kind of `model`.
    pub fn new(model: &Model, record: &'r Record) -> Result<Self, String> {
        let channels = compared(model, record).into_iter().map(|channel| {
            let own = record.weights(channel);
            let squares = own.iter().map(|w| w * w).sum::<f64>();
            let own = if own.iter().all(|w| *w == 1.0) { Vec::new() } else { own };
            Ok(Weighed { channel, scale: 1.0 / (deviation(channel)? * squares.sqrt()), own })
        });
        Ok(Self { record, channels: channels.collect::<Result<_, String>>()?, idle: Mutex::default() })
    }

    /// Number of residuals.
    pub fn len(&self) -> usize {
        self.channels.iter().map(|weighed| weighed.channel.values.len()).sum()
    }

    /// Writes prediction minus measurement of every compared channel, over its standard deviation and over the
    /// square root of its length: the sum of squares is that of the channels' normalised errors. Values of a table that
    /// have intervals of their own weigh by these.
    /// An error where `interrupt` asks for the end.
    pub fn write(
        &self,
        model: &Model,
        interrupt: Option<InterruptHook>,
        out: &mut Vec<f64>,
    ) -> Result<(), String> {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let mut simulation = idle.map_or_else(|| ObservedSimulation::new(model, self.record), Ok)?;
        let nuisances = simulation.settle_unless(model, interrupt)?;
        simulation.predict(model, &nuisances, out)?;
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(simulation);
        }
        let mut rest = out.as_mut_slice();
        for Weighed { channel, scale, own } in &self.channels {
            let (here, after) =
                rest.split_at_mut_checked(channel.values.len()).ok_or("the prediction is too short")?;
            here.iter_mut()
                .zip(&channel.values)
                .for_each(|(value, measured)| *value = scale * (*value - measured));
            here.iter_mut().zip(own).for_each(|(value, weight)| *value *= weight);
            rest = after;
        }
        Ok(())
    }
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
