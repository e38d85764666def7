//! TDMS of LabVIEW: channels are series, groups are records. Read by `tdms-rs`, which knows one block of data per segment;
//! what it would misread is found in the leads of the segments, and refused.

use std::io::Write as _;

use tdms_rs::{DataType, PropertyValue, TdmsChannel, TdmsFile};

use super::{Format, Series, guarded, unreadable};
use crate::import::Refusal;

pub(super) const FORMAT: Format = Format {
    name: "a TDMS file",
    is: |head| head.starts_with(b"TDSm"),
    read,
    help: "store it again as one block: in Python: `nptdms.TdmsFile.read('…').as_dataframe(time_index=True).to_csv('loop.csv')`",
};

/// The lead of a segment: mark, contents, version, length, offset of the data.
const LEAD: usize = 28;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;

fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    let failed = |reason: String| unreadable(&FORMAT, reason);
    let stored = stored(bytes).map_err(failed)?;
    let found = guarded(|| {
        // The library reads files, not memory.
        let mut file = tempfile::NamedTempFile::new().map_err(|error| error.to_string())?;
        file.write_all(bytes).map_err(|error| error.to_string())?;
        series(&TdmsFile::open(file.path()).map_err(|error| error.to_string())?, stored)
    });
    let (series, passed) = found.map_err(failed)?;
    if !passed.is_empty() {
        notes.push(format!("channels without numbers were not used: {}", passed.join(", ")));
    }
    Ok(series)
}

/// Bytes of data in all segments.
fn stored(bytes: &[u8]) -> Result<u64, String> {
    let (mut at, mut stored) = (0usize, 0u64);
    while let Some(lead) = bytes.get(at..at + LEAD) {
        let number = |from: usize| u64::from_le_bytes(*lead[from..].first_chunk().unwrap_or(&[0; 8]));
        let contents = number(4) as u32;
        if !lead.starts_with(b"TDSm") {
            return Err("a segment does not begin where the one before it ends".to_owned());
        }
        for (flag, what) in [
            (INTERLEAVED, "interleaved samples"),
            (BIG_ENDIAN, "big-endian numbers"),
            (DAQMX, "raw DAQmx data"),
        ] {
            if contents & flag != 0 {
                return Err(format!("it holds {what}"));
            }
        }
        let (length, data) = (number(12), number(20));
        if length == u64::MAX || data > length {
            return Err("the recording was not closed".to_owned());
        }
        stored += length - data;
        let next = usize::try_from(length).ok().and_then(|length| at.checked_add(LEAD)?.checked_add(length));
        at = next.filter(|next| *next <= bytes.len()).ok_or("the file is cut off")?;
    }
    Ok(stored)
}

fn series(file: &TdmsFile, stored: u64) -> Result<(Vec<Series>, Vec<String>), String> {
    let (mut found, mut passed, mut read) = (Vec::new(), Vec::new(), 0u64);
    let all = || file.groups().flat_map(|group| group.channels().collect::<Vec<_>>());
    let size = |channel: &TdmsChannel| (channel.len() as u64).checked_mul(channel.dtype().itemsize() as u64);
    let claimed = all().try_fold(0u64, |sum, channel| sum.checked_add(size(&channel)?));
    // Before any room is made for them.
    if claimed.is_none_or(|claimed| claimed > stored) {
        return Err("its channels claim more values than it holds".to_owned());
    }
    for group in file.groups() {
        for channel in group.channels() {
            read += size(&channel).unwrap_or(0);
            if channel.is_empty() {
                continue;
            }
            match values(&channel)? {
                Some(values) => found.push(described(group.name(), &channel, values)?),
                None => passed.push(format!("`{}`", channel.name())),
            }
        }
    }
    if read != stored && passed.is_empty() {
        return Err(format!(
            "{stored} bytes of data lie in several blocks of a segment, of which {read} would be read"
        ));
    }
    Ok((found, passed))
}

fn described(group: &str, channel: &TdmsChannel, values: Vec<f64>) -> Result<Series, String> {
    let number = |name: &str| match channel.property(name)? {
        PropertyValue::Double(value) => Some(*value),
        PropertyValue::Float(value) => Some(f64::from(*value)),
        PropertyValue::I32(value) => Some(f64::from(*value)),
        PropertyValue::U32(value) => Some(f64::from(*value)),
        _ => None,
    };
    let words = |name: &str| match channel.property(name)? {
        PropertyValue::String(text) if !text.trim().is_empty() => Some(text.trim().to_owned()),
        _ => None,
    };
    let mut values = values;
    if number("NI_Number_Of_Scales").is_some_and(|count| count > 0.0)
        && words("NI_Scaling_Status").is_some_and(|status| status == "unscaled")
    {
        let linear = words("NI_Scale[0]_Scale_Type").is_some_and(|kind| kind == "Linear")
            && number("NI_Number_Of_Scales") == Some(1.0);
        let slope = number("NI_Scale[0]_Linear_Slope").filter(|_| linear);
        let slope = slope.ok_or_else(|| {
            format!("`{}` is stored unscaled, with a scale that is not linear", channel.name())
        })?;
        let offset = number("NI_Scale[0]_Linear_Y_Intercept").unwrap_or(0.0);
        values.iter_mut().for_each(|value| *value = slope * *value + offset);
    }
    let step = number("wf_increment").filter(|step| *step > 0.0);
    let times = step.map(|step| [number("wf_start_offset").unwrap_or(0.0), step]);
    let clock = channel.dtype() == DataType::TimeStamp;
    let unit = words("unit_string")
        .or_else(|| words("NI_UnitDescription"))
        .or_else(|| words("units"))
        .or_else(|| words("unit"));
    Ok(Series { unit, times, clock, ..Series::new(group, channel.name(), values) })
}

/// The samples as numbers; `None` for texts.
fn values(channel: &TdmsChannel) -> Result<Option<Vec<f64>>, String> {
    // What the library reads into has a trait that it does not name outside.
    macro_rules! read {
        ($number:ty, $into:expr) => {{
            let mut out = vec![<$number>::default(); channel.len()];
            channel.read(0..channel.len(), &mut out).map_err(|error| error.to_string())?;
            out.into_iter().map($into).collect()
        }};
    }
    Ok(Some(match channel.dtype() {
        DataType::Double => read!(f64, |value| value),
        DataType::Float => read!(f32, f64::from),
        DataType::I8 => read!(i8, f64::from),
        DataType::I16 => read!(i16, f64::from),
        DataType::I32 => read!(i32, f64::from),
        DataType::I64 => read!(i64, |value| value as f64),
        DataType::U8 => read!(u8, f64::from),
        DataType::U16 => read!(u16, f64::from),
        DataType::U32 => read!(u32, f64::from),
        DataType::U64 => read!(u64, |value| value as f64),
        _ => return Ok(None),
    }))
}
