//! TDMS of LabVIEW: channels are series, groups are records. `segments.rs` goes from segment to segment of the file,
//! `metadata.rs` reads what a segment says of its channels, `number.rs` its numbers.
//!
//! No library reads what loggers write by default, samples of several channels in turn and many blocks to a segment; the format
//! is published (National Instruments, *TDMS File Format Internal Structure*).

mod metadata;
mod number;
mod segments;

use std::collections::BTreeMap;

use super::{Format, Series, guarded, unreadable};
use crate::import::Refusal;
use metadata::Property;
use segments::Channel;

pub(super) const FORMAT: Format = Format {
    name: "a TDMS file",
    is: |head| head.starts_with(b"TDSm"),
    read,
    help: "store it again: in Python: `nptdms.TdmsFile.read('…').as_dataframe(time_index=True).to_csv('loop.csv')`",
};

fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    let found = guarded(|| series(segments::channels(bytes)?));
    let Found { series, passed, scaled } = found.map_err(|reason| unreadable(&FORMAT, reason))?;
    notes.extend(scaled);
    if !passed.is_empty() {
        notes.push(format!("channels without numbers were not used: {}", passed.join(", ")));
    }
    Ok(series)
}

/// What the channels of a file are.
#[derive(Default)]
struct Found {
    series: Vec<Series>,
    /// Names of channels without numbers.
    passed: Vec<String>,
    /// Notes of those that were scaled.
    scaled: Vec<String>,
}

fn series(channels: Vec<Channel>) -> Result<Found, String> {
    let mut found = Found::default();
    for channel in channels {
        if !channel.has_numbers {
            found.passed.push(format!("`{}`", channel.name));
        } else if !channel.values.is_empty() {
            found.series.push(described(channel, &mut found.scaled)?);
        }
    }
    Ok(found)
}

fn described(channel: Channel, scaled: &mut Vec<String>) -> Result<Series, String> {
    let Channel { group, name, mut values, properties, is_clock, .. } = channel;
    let number = |key: &str| match properties.get(key) {
        Some(Property::Number(value)) => Some(*value),
        _ => None,
    };
    let words = |key: &str| match properties.get(key) {
        Some(Property::Words(text)) if !text.trim().is_empty() => Some(text.trim().to_owned()),
        _ => None,
    };
    if let Some((slope, offset)) = scale(&properties, &name)? {
        values.iter_mut().for_each(|value| *value = slope * *value + offset);
        scaled.push(format!(
            "`{name}` is stored unscaled: it was multiplied by {slope}, and {offset} was added"
        ));
    }
    let step = number("wf_increment").filter(|step| *step > 0.0);
    let times = step.map(|step| [number("wf_start_offset").unwrap_or(0.0), step]);
    let unit = words("unit_string")
        .or_else(|| words("NI_UnitDescription"))
        .or_else(|| words("units"))
        .or_else(|| words("unit"));
    Ok(Series { unit, times, clock: is_clock, ..Series::new(&group, &name, values) })
}

/// Slope and offset of a channel with a scale, unless it is said to be stored scaled.
fn scale(properties: &BTreeMap<String, Property>, name: &str) -> Result<Option<(f64, f64)>, String> {
    let number = |key: &str| match properties.get(key) {
        Some(Property::Number(value)) => Some(*value),
        _ => None,
    };
    let is = |key: &str, expected: &str| matches!(properties.get(key), Some(Property::Words(text)) if text.trim() == expected);
    let count = number("NI_Number_Of_Scales").unwrap_or(0.0);
    if count <= 0.0 || is("NI_Scaling_Status", "scaled") {
        return Ok(None);
    }
    let linear = count == 1.0 && is("NI_Scale[0]_Scale_Type", "Linear");
    let slope = number("NI_Scale[0]_Linear_Slope").filter(|_| linear);
    let slope =
        slope.ok_or_else(|| format!("`{name}` is stored unscaled, with a scale that is not linear"))?;
    Ok(Some((slope, number("NI_Scale[0]_Linear_Y_Intercept").unwrap_or(0.0))))
}
