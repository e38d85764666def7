//! MATLAB's MAT files: variables, fields of structs and columns of matrices are series; elements of a struct array are groups.
//!
//! Version 5 (`save -v6`, `-v7`, `scipy.io.savemat`) is read by `matrw`. Version 7.3 is HDF5, see `hdf5.rs`.

use matrw::{MatFile, MatVariable, MatlabType, load_matfile_from_u8};

use super::{Format, Series, guarded, hdf5, unreadable};
use crate::import::{Refusal, refuse};

pub(super) const VERSION_5: Format = Format {
    name: "a MAT file (version 5)",
    is: |head| head.starts_with(b"MATLAB 5.0 MAT"),
    read,
    help: "save vectors or a struct of vectors: save('loop.mat', 'time', 'displacement', 'force', '-v7')",
};

pub(super) const VERSION_7_3: Format = Format {
    name: "a MAT file (version 7.3)",
    is: |head| head.starts_with(b"MATLAB 7.3 MAT"),
    read: hdf5::read_matlab,
    help: "save vectors or a struct of vectors: save('loop.mat', 'time', 'displacement', 'force', '-v7')",
};

/// The head of a file (bytes), and how its text begins.
const HEAD: usize = 128;
const HEAD_TEXT: &[u8] = b"MATLAB 5.0 MAT-file, ";
const BROKEN: &str = "it is cut off, or holds what is not of this version";
/// Structs in structs beyond this depth are not looked into.
const DEEPEST: usize = 6;
/// Names of lists of names or units beside a matrix.
pub(super) const NAMES: [&str; 8] =
    ["names", "labels", "channels", "columns", "channel_names", "headers", "varnames", "variablenames"];
pub(super) const UNITS: [&str; 4] = ["units", "unit", "channel_units", "variableunits"];

fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    let told = guarded(|| {
        let file: MatFile = load_matfile_from_u8(&plain(bytes)).map_err(|_| BROKEN.to_owned())?;
        let mut found = Found::default();
        let members: Vec<(String, MatVariable)> =
            file.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
        found.group("", &members, 0);
        Ok(found)
    });
    let found = told.map_err(|reason| unreadable(&VERSION_5, reason))?;
    if found.series.is_empty() && found.objects > 0 {
        return Err(refuse(
            "the file holds objects (a table or timetable), which only MATLAB itself reads",
            "in MATLAB: s = table2struct(T, 'ToScalar', true); save('loop.mat', '-struct', 's', '-v7'), or writetable(T, 'loop.csv')",
        ));
    }
    if found.objects > 0 {
        notes.push(format!(
            "{} objects (tables, strings) were not used: only MATLAB itself reads them",
            found.objects
        ));
    }
    Ok(found.series)
}

/// The file with the text of its head as MATLAB writes it (`scipy` leaves out a comma that `matrw` wants), and without what
/// stands behind its variables: the contents of objects.
fn plain(bytes: &[u8]) -> Vec<u8> {
    let offset = bytes
        .get(116..124)
        .and_then(|field| field.first_chunk())
        .map_or(0, |field| u64::from_le_bytes(*field));
    let blank = bytes.get(116..124).is_some_and(|field| field == b"        ");
    let end = usize::try_from(offset)
        .ok()
        .filter(|end| *end > HEAD && *end < bytes.len() && !blank)
        .unwrap_or(bytes.len());
    let mut plain = bytes[..end].to_vec();
    if plain.len() > HEAD {
        plain[..HEAD_TEXT.len()].copy_from_slice(HEAD_TEXT);
    }
    plain
}

/// What was found in variables and structs.
#[derive(Default)]
struct Found {
    series: Vec<Series>,
    objects: usize,
}

impl Found {
    /// Variables, or fields of a struct: they belong together.
    fn group(&mut self, group: &str, members: &[(String, MatVariable)], depth: usize) {
        if depth > DEEPEST {
            return;
        }
        let list = |names: &[&str]| {
            let found = members.iter().find(|(name, _)| names.contains(&name.to_lowercase().as_str()));
            found.map(|(_, value)| texts(value)).unwrap_or_default()
        };
        let (names, units) = (list(&NAMES), list(&UNITS));
        let own_units = members.iter().find(|(name, _)| UNITS.contains(&name.to_lowercase().as_str()));
        let numeric: Vec<&String> = members
            .iter()
            .filter(|(_, value)| numbers(value).is_some_and(|n| n.len() > 1))
            .map(|(name, _)| name)
            .collect();
        for (name, value) in members {
            let unit = || {
                let beside = members.iter().find(|(other, _)| {
                    UNITS.iter().any(|unit| other.to_lowercase() == format!("{}_{unit}", name.to_lowercase()))
                });
                let text = beside.and_then(|(_, value)| texts(value).into_iter().next());
                let in_struct =
                    || own_units.and_then(|(_, units)| texts(units.get_field(name)?).into_iter().next());
                let listed = || {
                    let at = numeric.iter().position(|other| *other == name)?;
                    (units.len() == numeric.len()).then(|| units[at].clone())
                };
                text.or_else(in_struct).or_else(listed)
            };
            match value {
                MatVariable::NumericArray(_) => self.matrix(group, name, value, &names, &units, unit()),
                MatVariable::Structure(_) if UNITS.contains(&name.to_lowercase().as_str()) => {}
                MatVariable::Structure(_) => {
                    let fields = fields(value);
                    match signal(group, name, &fields) {
                        Some(series) => self.series.push(series),
                        None => self.group(&joined(group, name), &fields, depth + 1),
                    }
                }
                MatVariable::StructureArray(array) => {
                    for (number, element) in array.value.iter().enumerate() {
                        self.group(
                            &joined(group, &format!("{name}-{}", number + 1)),
                            &fields(element),
                            depth + 1,
                        );
                    }
                }
                MatVariable::CellArray(cells) => {
                    for (number, cell) in cells.value.iter().enumerate() {
                        if matches!(cell, MatVariable::Structure(_)) {
                            self.group(
                                &joined(group, &format!("{name}-{}", number + 1)),
                                &fields(cell),
                                depth + 1,
                            );
                        }
                    }
                }
                MatVariable::Unsupported => self.objects += 1,
                _ => {}
            }
        }
    }

    /// A vector is a series, a matrix one per column (of the longer side).
    fn matrix(
        &mut self,
        group: &str,
        name: &str,
        value: &MatVariable,
        names: &[String],
        units: &[String],
        unit: Option<String>,
    ) {
        let (Some(values), dim) = (numbers(value), value.dim()) else { return };
        let [rows, columns] = dim[..] else { return };
        if rows.min(columns) <= 1 || values.len() != rows * columns {
            self.series.push(Series { unit, ..Series::new(group, name, values) });
            return;
        }
        // Numbers lie column by column; samples run along the longer side.
        let (count, length, across) =
            if rows >= columns { (columns, rows, false) } else { (rows, columns, true) };
        for index in 0..count {
            let heading = names.get(index).filter(|_| names.len() == count);
            let heading = heading.map_or_else(|| format!("{name}_{}", index + 1), String::clone);
            let at = |k: usize| if across { values[k * count + index] } else { values[index * length + k] };
            let unit = units.get(index).filter(|_| units.len() == count).cloned();
            self.series.push(Series { unit, ..Series::new(group, &heading, (0..length).map(at).collect()) });
        }
    }
}

/// A struct that stands for one signal: its numbers in `data` or `values`, beside a unit and a rate.
fn signal(group: &str, name: &str, fields: &[(String, MatVariable)]) -> Option<Series> {
    let called = |names: &[&str]| {
        fields.iter().find(|(name, _)| names.contains(&name.to_lowercase().as_str())).map(|(_, value)| value)
    };
    let values = numbers(called(&["data", "values", "signal"])?)?;
    let vectors =
        fields.iter().filter(|(_, value)| numbers(value).is_some_and(|numbers| numbers.len() > 1)).count();
    if vectors != 1 {
        return None;
    }
    let single = |names: &[&str]| {
        called(names).and_then(numbers).filter(|numbers| numbers.len() == 1).map(|numbers| numbers[0])
    };
    let step =
        single(&["dt", "step"]).or_else(|| single(&["fs", "rate", "sample_rate"]).map(|rate| 1.0 / rate));
    let unit = called(&UNITS).and_then(|value| texts(value).into_iter().next());
    let times = step.filter(|step| step.is_finite() && *step > 0.0).map(|step| [0.0, step]);
    Some(Series { unit, times, ..Series::new(group, name, values) })
}

trait Field {
    fn get_field(&self, name: &str) -> Option<&MatVariable>;
}

impl Field for MatVariable {
    fn get_field(&self, name: &str) -> Option<&MatVariable> {
        match self {
            MatVariable::Structure(fields) => fields.get(name),
            _ => None,
        }
    }
}

/// The fields of a struct.
fn fields(structure: &MatVariable) -> Vec<(String, MatVariable)> {
    let names = structure.fieldnames().unwrap_or_default();
    names.into_iter().filter_map(|name| Some((name.clone(), structure.get_field(&name)?.clone()))).collect()
}

fn joined(group: &str, name: &str) -> String {
    if group.is_empty() { name.to_owned() } else { format!("{group}-{name}") }
}

/// Real numbers; text and complex numbers are none.
fn numbers(value: &MatVariable) -> Option<Vec<f64>> {
    if value.is_complex() == Some(true) {
        return None;
    }
    Some(match value.numeric_type()? {
        MatlabType::F64(values) => values.clone(),
        MatlabType::F32(values) => values.iter().map(|value| f64::from(*value)).collect(),
        MatlabType::I8(values) => values.iter().map(|value| f64::from(*value)).collect(),
        MatlabType::U8(values) => values.iter().map(|value| f64::from(*value)).collect(),
        MatlabType::I16(values) => values.iter().map(|value| f64::from(*value)).collect(),
        MatlabType::U16(values) => values.iter().map(|value| f64::from(*value)).collect(),
        MatlabType::I32(values) => values.iter().map(|value| f64::from(*value)).collect(),
        MatlabType::U32(values) => values.iter().map(|value| f64::from(*value)).collect(),
        MatlabType::I64(values) => values.iter().map(|value| *value as f64).collect(),
        MatlabType::U64(values) => values.iter().map(|value| *value as f64).collect(),
        _ => return None,
    })
}

/// Text, or the texts of a cell or of the rows of a matrix of letters.
fn texts(value: &MatVariable) -> Vec<String> {
    match value {
        MatVariable::CellArray(cells) => cells.value.iter().flat_map(texts).collect(),
        MatVariable::NumericArray(_) => match value.numeric_type() {
            Some(MatlabType::UTF8(letters) | MatlabType::UTF16(letters)) => {
                let rows = value.dim().first().copied().unwrap_or(1).max(1);
                let row =
                    |row: usize| letters.iter().skip(row).step_by(rows).collect::<String>().trim().to_owned();
                (0..rows).map(row).collect()
            }
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}
