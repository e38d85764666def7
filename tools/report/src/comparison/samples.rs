//! Measured, predicted and residual values of a record, as a table to take away.

use std::fmt::Write as _;

use stickslip::diagnose::Comparison;

use crate::comparison::summary;

/// The compared channels of `record` (index) as CSV: what they are over (`time [s]`, `amplitude [...]`), then for each
/// channel `NAME measured`, `NAME predicted` by the last stage that predicts it, and `NAME residual`, measured minus
/// predicted, in SI (Hz for frequencies). `None` where no stage predicts the record. Rows are those of the record.
pub fn samples_csv(comparison: &Comparison, record: usize) -> Option<String> {
    let measured = comparison.records.get(record)?;
    let stage = comparison.stages.iter().rev().find(|stage| summary::failure(stage, record).is_none())?;
    let compared = &stage.records[record].channels;
    let over =
        measured.channels.iter().filter(|channel| compared.iter().all(|other| other.name != channel.name));
    let over: Vec<_> = over.collect();
    let mut text = String::new();
    let mut header: Vec<String> =
        over.iter().map(|channel| format!("{} [{}]", channel.name, channel.unit)).collect();
    let pairs: Vec<_> = compared
        .iter()
        .filter_map(|result| Some((summary::channel(measured, &result.name)?, result)))
        .collect();
    for (channel, _) in &pairs {
        header.extend(
            ["measured", "predicted", "residual"]
                .map(|what| format!("{} {what} [{}]", channel.name, channel.unit)),
        );
    }
    let _ = writeln!(text, "{}", header.join(","));
    let rows =
        pairs.iter().map(|(channel, result)| channel.values.len().min(result.predicted.len())).min()?;
    for row in 0..rows {
        let mut separator = "";
        let mut put = |value: Option<f64>| {
            let _ = match value.filter(|value| value.is_finite()) {
                Some(value) => write!(text, "{separator}{value:e}"),
                None => write!(text, "{separator}"),
            };
            separator = ",";
        };
        over.iter().for_each(|channel| put(channel.values.get(row).copied()));
        for (channel, result) in &pairs {
            let (measured, predicted) = (channel.values[row], result.predicted[row]);
            [measured, predicted, measured - predicted].into_iter().for_each(|value| put(Some(value)));
        }
        text.push('\n');
    }
    Some(text)
}
