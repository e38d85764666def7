//! How far a prediction is from a measurement.

use super::comparison::{ChannelResult, RecordResult};
use crate::measure::Channel;

/// Scores `predicted` against the measured `channel`; both have the same length and unit.
///
/// A channel that does not vary has no standard deviation to measure an error by and is refused.
pub(super) fn channel(channel: &Channel, predicted: Vec<f64>) -> Result<ChannelResult, String> {
    let deviation = standard_deviation(&channel.values);
    if deviation == 0.0 {
        return Err(format!("`{}` is the same number throughout; there is nothing to compare", channel.name));
    }
    let squares =
        channel.values.iter().zip(&predicted).map(|(measured, predicted)| (predicted - measured).powi(2));
    let rms = (squares.sum::<f64>() / channel.values.len() as f64).sqrt();
    Ok(ChannelResult {
        name: channel.name.clone(),
        unit: channel.unit,
        error: rms / deviation,
        rms,
        predicted,
    })
}

/// Root-mean-square of the channels' normalised errors.
pub(super) fn record(channels: Vec<ChannelResult>) -> RecordResult {
    let error = root_mean_square(channels.iter().map(|channel| channel.error));
    RecordResult { error, channels, failure: None }
}

/// Root-mean-square over all channels of all records that could be predicted; NaN when none could.
pub(super) fn total(records: &[RecordResult]) -> f64 {
    root_mean_square(records.iter().flat_map(|record| &record.channels).map(|channel| channel.error))
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value * value, count + 1));
    (sum / count as f64).sqrt()
}

/// Population standard deviation.
pub(super) fn standard_deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}
