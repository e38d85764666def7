//! HDF5, and MATLAB's files of version 7.3, which are HDF5: datasets are series, groups are records. Read by `hdf5-pure`.

use std::collections::HashMap;

use hdf5_pure::{AttrValue, DType, Dataset, File, Group, Object};

use super::mat::{NAMES, UNITS, VERSION_7_3};
use super::{Format, Room, Series, guarded, unreadable};
use crate::import::Refusal;

pub(super) const FORMAT: Format = Format {
    name: "an HDF5 file",
    is: |head| {
        head.starts_with(b"\x89HDF\r\n\x1a\n")
            || head.len() >= 520 && head[512..].starts_with(b"\x89HDF\r\n\x1a\n")
    },
    read,
    help: "store one dataset per channel, with its unit as attribute `units`: file['force'] = force; \
           file['force'].attrs['units'] = 'kN'; compressed with gzip or not at all",
};

/// Groups beyond this depth are not looked into.
const DEEPEST: usize = 6;
/// Lists of names and units take no more bytes than this.
const LONGEST_TEXT: u64 = 1 << 20;

fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    found(bytes, notes, false).map_err(|reason| unreadable(&FORMAT, reason))
}

/// A MAT file of version 7.3.
pub(super) fn read_matlab(bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    found(bytes, notes, true).map_err(|reason| unreadable(&VERSION_7_3, reason))
}

fn found(bytes: &[u8], notes: &mut Vec<String>, matlab: bool) -> Result<Vec<Series>, String> {
    let bytes = bytes.to_vec();
    let found = guarded(move || {
        let file = File::from_bytes(bytes).map_err(|error| error.to_string())?;
        // All that would be read is measured before anything is.
        Found { matlab, room: Some(Room::default()), ..Found::default() }.group("", &file.root(), 0)?;
        let mut found = Found { matlab, ..Found::default() };
        found.group("", &file.root(), 0)?;
        Ok(found)
    })?;
    notes.extend(found.decoded);
    if !found.passed.is_empty() {
        notes.push(format!("not used: {}", found.passed.join(", ")));
    }
    Ok(found.series)
}

#[derive(Default)]
struct Found {
    series: Vec<Series>,
    /// While the file is measured: nothing is read then.
    room: Option<Room>,
    /// Notes of numbers that are stored in another form.
    decoded: Vec<String>,
    /// What is no series of numbers, with its reason.
    passed: Vec<String>,
    matlab: bool,
}

/// The text of an attribute or of its first element.
fn text(attributes: &HashMap<String, AttrValue>, names: &[&str]) -> Option<String> {
    let found = attributes.iter().find(|(name, _)| names.contains(&name.to_lowercase().as_str()))?;
    found.1.as_strings()?.first().map(|text| text.trim().to_owned()).filter(|text| !text.is_empty())
}

fn list(attributes: &HashMap<String, AttrValue>, names: &[&str]) -> Vec<String> {
    let found = attributes.iter().find(|(name, _)| names.contains(&name.to_lowercase().as_str()));
    found.and_then(|(_, value)| value.as_strings()).map(<[String]>::to_vec).unwrap_or_default()
}

/// A rate or a step among the attributes: start and step of the samples.
fn times(attributes: &HashMap<String, AttrValue>) -> Option<[f64; 2]> {
    let number = |names: &[&str]| {
        let found = attributes.iter().find(|(name, _)| names.contains(&name.to_lowercase().as_str()));
        found.and_then(|(_, value)| value.as_f64().or_else(|| value.as_i64().map(|value| value as f64)))
    };
    let step = number(&["dt", "step", "wf_increment"]);
    let step = step.or_else(|| {
        number(&["fs", "rate", "sample_rate", "sampling_rate", "sampling_frequency"]).map(|rate| 1.0 / rate)
    });
    let start = number(&["t0", "start", "start_time", "wf_start_offset"]).unwrap_or(0.0);
    step.filter(|step| step.is_finite() && *step > 0.0).map(|step| [start, step])
}

/// All numbers of an attribute; none where it is absent.
fn numbers(attributes: &HashMap<String, AttrValue>, key: &str) -> Result<Vec<f64>, String> {
    let Some(value) = attributes.get(key) else { return Ok(Vec::new()) };
    let whole = || Some(value.to_i64s()?.into_iter().map(|value| value as f64).collect());
    let large = || Some(value.to_u64s()?.into_iter().map(|value| value as f64).collect());
    value.to_f64s().or_else(whole).or_else(large).ok_or_else(|| format!("its attribute `{key}` is no number"))
}

/// Turns the numbers of a dataset as they are stored into those that its attributes mean, by the conventions of netCDF; notes
/// say how.
fn decode(attributes: &HashMap<String, AttrValue>, values: &mut [f64]) -> Result<Vec<String>, String> {
    let mut notes = Vec::new();
    // Fill values are those of the numbers as they are stored.
    for key in ["_FillValue", "missing_value"] {
        for fill in numbers(attributes, key)? {
            let is_fill = |value: f64| value == fill || value == f64::from(fill as f32);
            let mut count = 0;
            for value in values.iter_mut().filter(|value| is_fill(**value)) {
                (*value, count) = (f64::NAN, count + 1);
            }
            if count > 0 {
                notes.push(format!("{count} values are {fill} (`{key}`), and were taken as missing"));
            }
        }
    }
    let single = |key: &str| match numbers(attributes, key)?[..] {
        [] => Ok(None),
        [value] => Ok(Some(value)),
        _ => Err(format!("its attribute `{key}` is not one number")),
    };
    let (factor, offset) = (single("scale_factor")?, single("add_offset")?);
    if factor.is_some() || offset.is_some() {
        let (factor, offset) = (factor.unwrap_or(1.0), offset.unwrap_or(0.0));
        values.iter_mut().for_each(|value| *value = *value * factor + offset);
        notes.push(format!("multiplied by {factor} (`scale_factor`), and {offset} added (`add_offset`)"));
    }
    Ok(notes)
}

impl Found {
    /// Whether a dataset is only measured, not read; refused where it has no room. An element takes at least `each` bytes.
    fn only_measures(&mut self, data: &Dataset, each: u64) -> Result<bool, String> {
        let Some(room) = &mut self.room else { return Ok(false) };
        room.take(size(data, each)?)?;
        Ok(true)
    }

    fn group(&mut self, name: &str, group: &Group, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Ok(());
        }
        let mut names = group.datasets().map_err(|error| error.to_string())?;
        names.sort_by(natural);
        let attributes = group.attrs().unwrap_or_default();
        let group_times = times(&attributes);
        for dataset in names {
            let Ok(data) = group.dataset(&dataset) else { continue };
            let before = self.series.len();
            if let Some(reason) = self.dataset(name, &dataset, &data, group)? {
                self.passed.push(format!("`{}` ({reason})", joined(name, &dataset)));
            }
            for series in &mut self.series[before..] {
                series.times = series.times.or(group_times);
            }
        }
        let mut names = group.groups().map_err(|error| error.to_string())?;
        names.sort_by(natural);
        for inner in names.into_iter().filter(|name| !name.starts_with('#')) {
            if UNITS.contains(&inner.to_lowercase().as_str()) {
                continue;
            }
            let Ok(group) = group.group(&inner) else { continue };
            self.group(&joined(name, &inner), &group, depth + 1)?;
        }
        Ok(())
    }

    /// Takes a dataset; or why it is no series. What cannot be read is an error: nothing is left out in silence.
    fn dataset(
        &mut self,
        group: &str,
        name: &str,
        data: &Dataset,
        parent: &Group,
    ) -> Result<Option<&'static str>, String> {
        let attributes = data.attrs().unwrap_or_default();
        let shape = data.shape().map_err(|error| error.to_string())?;
        let kind = data.dtype().map_err(|error| error.to_string())?;
        if text(&attributes, &["matlab_class"]).is_some_and(|class| class == "char")
            || [NAMES.as_slice(), UNITS.as_slice()].concat().contains(&name.to_lowercase().as_str())
        {
            return Ok(None);
        }
        match kind {
            DType::ObjectReference if self.matlab => return self.elements(group, name, data).map(|()| None),
            DType::Compound(members) if is_complex(&members) => return Ok(Some("complex numbers")),
            DType::Compound(members) => return self.compound(group, &members, data).map(|()| None),
            DType::String | DType::VariableLengthString | DType::ObjectReference => {
                return Ok(Some("no numbers"));
            }
            _ => {}
        }
        let dimensions: Vec<usize> = shape
            .iter()
            .map(|size| usize::try_from(*size).unwrap_or(usize::MAX))
            .filter(|size| *size > 1)
            .collect();
        if dimensions.len() > 2 {
            return Ok(Some("more than two dimensions"));
        }
        if self.only_measures(data, 8)? {
            return Ok(None);
        }
        let mut values = data.read_f64().map_err(|error| error.to_string())?;
        let full = joined(group, name);
        let told = decode(&attributes, &mut values).map_err(|reason| format!("`{full}`: {reason}"))?;
        self.decoded.extend(told.into_iter().map(|note| format!("`{full}`: {note}")));
        let unit = text(&attributes, &["units", "unit", "unit_string"]).or_else(|| beside(parent, name));
        let unit = if unit.is_none() && values.len() == 1 { beside_single(parent, name) } else { unit };
        let times = times(&attributes);
        let [rows, columns] = dimensions[..] else {
            self.series.push(Series { unit, times, ..Series::new(group, name, values) });
            return Ok(None);
        };
        // Numbers lie row by row; samples run along the longer side.
        let (count, length, across) =
            if rows >= columns { (columns, rows, true) } else { (rows, columns, false) };
        let (names, units) = (list(&attributes, &NAMES), list(&attributes, &UNITS));
        let names = if names.len() == count { names } else { texts_beside(parent, &NAMES) };
        let units = if units.len() == count { units } else { texts_beside(parent, &UNITS) };
        for index in 0..count {
            let at = |k: usize| if across { values[k * count + index] } else { values[index * length + k] };
            let heading = names.get(index).filter(|_| names.len() == count);
            let heading = heading.map_or_else(|| format!("{name}_{}", index + 1), String::clone);
            let unit = units.get(index).filter(|_| units.len() == count).cloned();
            self.series.push(Series {
                unit,
                times,
                ..Series::new(group, &heading, (0..length).map(at).collect())
            });
        }
        Ok(None)
    }

    /// A cell array, or a field of a struct array: references to what it holds, one record each.
    fn elements(&mut self, group: &str, name: &str, data: &Dataset) -> Result<(), String> {
        self.only_measures(data, 8)?;
        let objects = data.dereference().map_err(|error| error.to_string())?;
        for (number, object) in objects.into_iter().enumerate() {
            match object {
                Object::Group(inner) => {
                    self.group(&joined(group, &format!("{name}-{}", number + 1)), &inner, 1)?
                }
                Object::Dataset(inner) => {
                    let attributes = inner.attrs().unwrap_or_default();
                    if text(&attributes, &["matlab_class"]).is_some_and(|class| class != "char")
                        && !self.only_measures(&inner, 8)?
                        && let Ok(values) = inner.read_f64()
                    {
                        self.series.push(Series::new(&format!("{group}-{}", number + 1), name, values));
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// A table whose rows are structures: a series per member.
    fn compound(&mut self, group: &str, members: &[(String, DType)], data: &Dataset) -> Result<(), String> {
        if self.only_measures(data, 8 * members.len() as u64)? {
            return Ok(());
        }
        let raw = data.read_raw().map_err(|error| error.to_string())?;
        let hdf5_pure::Datatype::Compound { size, members: places } =
            data.datatype().map_err(|error| error.to_string())?
        else {
            return Err("its type is not known".to_owned());
        };
        for (name, kind) in members {
            let Some(place) = places.iter().find(|place| place.name == *name) else { continue };
            let offset = usize::try_from(place.byte_offset).unwrap_or(usize::MAX);
            let value = |row: &[u8]| number(kind, row.get(offset..)?);
            let Some(values) = raw.chunks_exact(size as usize).map(value).collect::<Option<Vec<f64>>>()
            else {
                self.passed.push(format!("`{name}` (no numbers)"));
                continue;
            };
            self.series.push(Series::new(group, name, values));
        }
        Ok(())
    }
}

/// Bytes that a dataset takes, or a block in which it is packed, where an element takes at least `each`.
fn size(data: &Dataset, each: u64) -> Result<u64, String> {
    let count = |sizes: Vec<u64>| sizes.into_iter().fold(1, u64::saturating_mul);
    let whole = count(data.shape().map_err(|error| error.to_string())?);
    let block = data.chunk_shape().map_err(|error| error.to_string())?.map_or(0, count);
    let element = data.element_size().map_err(|error| error.to_string())?;
    Ok(whole.max(block).saturating_mul(each.max(element)))
}

fn is_complex(members: &[(String, DType)]) -> bool {
    let names: Vec<&str> = members.iter().map(|(name, _)| name.as_str()).collect();
    [["r", "i"], ["real", "imag"]].iter().any(|both| names == both)
}

/// A number of a member of a structure, in the order of bytes of this machine's files.
fn number(kind: &DType, bytes: &[u8]) -> Option<f64> {
    Some(match kind {
        DType::F64 => f64::from_le_bytes(*bytes.first_chunk()?),
        DType::F32 => f64::from(f32::from_le_bytes(*bytes.first_chunk()?)),
        DType::I64 => i64::from_le_bytes(*bytes.first_chunk()?) as f64,
        DType::U64 => u64::from_le_bytes(*bytes.first_chunk()?) as f64,
        DType::I32 => f64::from(i32::from_le_bytes(*bytes.first_chunk()?)),
        DType::U32 => f64::from(u32::from_le_bytes(*bytes.first_chunk()?)),
        DType::I16 => f64::from(i16::from_le_bytes(*bytes.first_chunk()?)),
        DType::U16 => f64::from(u16::from_le_bytes(*bytes.first_chunk()?)),
        DType::I8 => f64::from(i8::from_le_bytes(*bytes.first_chunk()?)),
        DType::U8 => f64::from(*bytes.first()?),
        _ => return None,
    })
}

/// The unit that stands in a dataset of its own: `force_unit`, or in the group `units`.
fn beside(parent: &Group, name: &str) -> Option<String> {
    let one = |path: &str| texts_of(&parent.dataset(path).ok()?).into_iter().next();
    UNITS.iter().find_map(|unit| one(&format!("{name}_{unit}")).or_else(|| one(&format!("{unit}/{name}"))))
}

/// The same of a single number, `Fs_unit` beside `fs`, however its letters are written.
fn beside_single(parent: &Group, name: &str) -> Option<String> {
    let wanted = UNITS.map(|unit| format!("{name}_{unit}").to_lowercase());
    let found = parent.datasets().ok()?.into_iter().find(|other| wanted.contains(&other.to_lowercase()))?;
    texts_of(&parent.dataset(&found).ok()?).into_iter().next()
}

/// The list of names or units beside a matrix.
fn texts_beside(parent: &Group, names: &[&str]) -> Vec<String> {
    let found = names.iter().find_map(|name| parent.dataset(name).ok());
    found.map(|data| texts_of(&data)).unwrap_or_default()
}

/// Text of a dataset: strings, or MATLAB's letters (one text, or one per column where it is a cell).
fn texts_of(data: &Dataset) -> Vec<String> {
    let is_long = |bytes: u64| bytes > LONGEST_TEXT;
    if size(data, 1).map_or(true, is_long) || data.vlen_string_payload_size().is_ok_and(is_long) {
        return Vec::new();
    }
    if let Ok(objects) = data.dereference() {
        let inner = objects.iter().filter_map(|object| match object {
            Object::Dataset(data) => texts_of(data).into_iter().next(),
            _ => None,
        });
        return inner.collect();
    }
    if let Ok(texts) = data.read_string() {
        return texts.into_iter().map(|text| text.trim().to_owned()).collect();
    }
    let letters = data.read_u16().unwrap_or_default();
    vec![String::from_utf16_lossy(&letters).trim().to_owned()]
}

fn joined(group: &str, name: &str) -> String {
    if group.is_empty() { name.to_owned() } else { format!("{group}-{name}") }
}

/// `run2` before `run10`.
fn natural(a: &String, b: &String) -> std::cmp::Ordering {
    let split = |text: &str| {
        let digits = text.len() - text.trim_end_matches(|letter: char| letter.is_ascii_digit()).len();
        let (stem, number) = text.split_at(text.len() - digits);
        (stem.to_owned(), number.parse::<u64>().unwrap_or(0))
    };
    split(a).cmp(&split(b)).then_with(|| a.cmp(b))
}
