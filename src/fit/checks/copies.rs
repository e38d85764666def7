//! Channels and records that are there twice.

use super::{Fault, Finding, finding};
use crate::data::{Channel, Record};

/// Copies in `record`, and whether it is one of those `before` it.
pub(super) fn of(record: &Record, before: &[Record], found: &mut Vec<Finding>) {
    for (place, channel) in record.channels.iter().enumerate() {
        let twin =
            record.channels[..place].iter().find(|other| other.unit == channel.unit && same(other, channel));
        if let Some(other) = twin {
            let fault = Fault::CopyOf { other: other.name.clone() };
            found.push(finding(record, &channel.name, fault));
        }
    }
    if let Some(other) = before.iter().find(|other| is_copy(record, other)) {
        let fault = Fault::GivenTwice { other: other.name.clone() };
        found.push(Finding { record: Some(record.name.clone()), channel: None, fault });
    }
}

/// Whether two channels have the same values, and these change.
fn same(a: &Channel, b: &Channel) -> bool {
    a.values == b.values && a.values.iter().any(|value| *value != a.values[0])
}

/// Whether all channels but the time have the values of those in another record.
fn is_copy(record: &Record, other: &Record) -> bool {
    let mut compared = record.channels.iter().filter(|channel| channel.quantity() != "time");
    record.channels.len() == other.channels.len()
        && compared.clone().any(|channel| channel.values.iter().any(|value| *value != channel.values[0]))
        && compared.all(|channel| {
            other.channels.iter().any(|twin| twin.name == channel.name && twin.values == channel.values)
        })
}
