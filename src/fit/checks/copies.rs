//! Channels and records that are there twice.

use super::{Fault, Finding, finding, largest};
use crate::data::{Channel, Record};
use crate::fit::predict::white_noise;

/// Numbers that were converted from the same digits differ by less than this part: rounding makes 10⁻¹⁵, and no sensor repeats
/// another so well.
const DIGITS: f64 = 1e-12;
/// Different values from which channels of two quantities are no accident: a few levels of a table may well be the same.
const DISTINCT: usize = 20;
/// White noise over the largest value from which a force in the digits of a displacement is a copy: a simulated contact of 10⁶ N/m
/// that sticks has these digits, too, but two sensors never have the same noise.
const NOISY: f64 = 1e-4;

/// Copies in `record`, and whether it is one of those `before` it.
pub(super) fn of(record: &Record, before: &[Record], found: &mut Vec<Finding>) {
    for (place, channel) in record.channels.iter().enumerate() {
        let earlier = &record.channels[..place];
        let converted = |other: &&Channel| !record.regime.is_table() && same_digits(other, channel);
        let twin = earlier
            .iter()
            .find(|other| other.unit == channel.unit && same(other, channel))
            .or_else(|| earlier.iter().find(converted));
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

/// Whether two channels of different units have the same digits: a unit moves the decimal point alone.
fn same_digits(a: &Channel, b: &Channel) -> bool {
    let most = largest(&a.values);
    let power = (largest(&b.values) / most).log10().round();
    if [a, b].iter().any(|one| one.quantity() == "time") || a.unit == b.unit || !power.is_finite() {
        return false;
    }
    let factor = 10.0_f64.powi(power as i32);
    let alike = |(a, b): (&f64, &f64)| (a * factor - b).abs() <= DIGITS * b.abs();
    if !a.values.iter().zip(&b.values).all(alike) {
        return false;
    }
    let mut sorted = a.values.clone();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let of_contact = [a, b].iter().any(|one| one.quantity() == "force");
    sorted.len() >= DISTINCT && (!of_contact || white_noise(&a.values) > NOISY * most)
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
