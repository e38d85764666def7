//! MATLAB's MAT files: variables, fields of structs and columns of matrices are series; elements of a struct array are groups.
//!
//! Version 5 (`save -v6`, `-v7`, `scipy.io.savemat`) is read by `matrw`, once `room.rs` has found that its variables have room
//! in memory. Version 7.3 is HDF5, see `hdf5.rs`.

mod room;

use matrw::{MatFile, MatVariable, MatlabType, load_matfile_from_u8};

use super::series::step_of;
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
        room::check(bytes)?;
        let file: MatFile = load_matfile_from_u8(&plain(bytes)).map_err(|_| BROKEN.to_owned())?;
        let mut found = Found::default();
        let members: Vec<(String, MatVariable)> = file.into_iter().collect();
        found.group("", &members, 0)?;
        Ok(found)
    });
    let found = told.map_err(|reason| unreadable(&VERSION_5, reason))?;
    if !found.complex.is_empty() {
        notes.push(format!("complex numbers were not used: {}", found.complex.join(", ")));
    }
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
    /// Names of channels of complex numbers.
    complex: Vec<String>,
}

impl Found {
    /// Variables, or fields of a struct: they belong together.
    fn group(&mut self, group: &str, members: &[(String, MatVariable)], depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Ok(());
        }
        let beside = Beside::new(members);
        for (name, value) in members {
            let numbered = |number: usize| joined(group, &format!("{name}-{}", number + 1));
            match value {
                MatVariable::NumericArray(_) => self.matrix(group, name, value, &beside),
                MatVariable::Structure(_) if is_among(name, &UNITS) => {}
                MatVariable::Structure(_) => {
                    let fields = fields(value);
                    match signal(group, name, &fields)? {
                        Some(series) => self.series.push(series),
                        None => self.group(&joined(group, name), &fields, depth + 1)?,
                    }
                }
                MatVariable::StructureArray(array) => {
                    for (number, element) in array.value.iter().enumerate() {
                        self.group(&numbered(number), &fields(element), depth + 1)?;
                    }
                }
                MatVariable::CellArray(cells) => {
                    let structs = |cell: &&MatVariable| matches!(cell, MatVariable::Structure(_));
                    for (number, cell) in cells.value.iter().enumerate().filter(|(_, cell)| structs(cell)) {
                        self.group(&numbered(number), &fields(cell), depth + 1)?;
                    }
                }
                MatVariable::Unsupported => self.objects += 1,
                _ => {}
            }
        }
        Ok(())
    }

    /// A vector is a series, a matrix one per column (of the longer side).
    fn matrix(&mut self, group: &str, name: &str, value: &MatVariable, beside: &Beside) {
        if value.is_complex() == Some(true) {
            self.complex.push(format!("`{}`", joined(group, name)));
        }
        let (Some(values), dim) = (numbers(value), value.dim()) else { return };
        let (names, units) = (&beside.names, &beside.units);
        let [rows, columns] = dim[..] else { return };
        if rows.min(columns) <= 1 || values.len() != rows * columns {
            self.series.push(Series { unit: beside.unit(name), ..Series::new(group, name, values) });
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

/// What variables or fields say of one another.
struct Beside<'m> {
    members: &'m [(String, MatVariable)],
    names: Vec<String>,
    units: Vec<String>,
}

impl<'m> Beside<'m> {
    fn new(members: &'m [(String, MatVariable)]) -> Self {
        let list = |names: &[&str]| called(members, names).map(texts).unwrap_or_default();
        Self { members, names: list(&NAMES), units: list(&UNITS) }
    }

    /// The unit of a member: in a text `force_unit`, a struct `units`, or a list of as many units as there are vectors.
    fn unit(&self, name: &str) -> Option<String> {
        let in_struct = || texts(called(self.members, &UNITS)?.get_field(name)?).into_iter().next();
        let listed = || {
            let is_vector = |value: &MatVariable| numbers(value).is_some_and(|numbers| numbers.len() > 1);
            let vectors: Vec<&String> =
                self.members.iter().filter(|(_, value)| is_vector(value)).map(|(name, _)| name).collect();
            let at = vectors.iter().position(|other| *other == name)?;
            (self.units.len() == vectors.len()).then(|| self.units[at].clone())
        };
        unit_beside(self.members, name).or_else(in_struct).or_else(listed)
    }
}

fn is_among(name: &str, names: &[&str]) -> bool {
    names.contains(&name.to_lowercase().as_str())
}

/// The member that has one of these names.
fn called<'m>(members: &'m [(String, MatVariable)], names: &[&str]) -> Option<&'m MatVariable> {
    members.iter().find(|(name, _)| is_among(name, names)).map(|(_, value)| value)
}

/// The text of a member called `force_unit`.
fn unit_beside(members: &[(String, MatVariable)], name: &str) -> Option<String> {
    let names = UNITS.map(|unit| format!("{}_{unit}", name.to_lowercase()));
    texts(called(members, &names.each_ref().map(String::as_str))?).into_iter().next()
}

/// A struct that stands for one signal: its numbers in `data` or `values`, beside a unit and a rate.
fn signal(group: &str, name: &str, fields: &[(String, MatVariable)]) -> Result<Option<Series>, String> {
    let Some(values) = called(fields, &["data", "values", "signal"]).and_then(numbers) else {
        return Ok(None);
    };
    let all: Vec<Series> = fields
        .iter()
        .filter_map(|(name, value)| {
            Some(Series { unit: unit_beside(fields, name), ..Series::new("", name, numbers(value)?) })
        })
        .collect();
    if all.iter().filter(|one| one.values.len() > 1).count() != 1 {
        return Ok(None);
    }
    let unit = called(fields, &UNITS).and_then(|value| texts(value).into_iter().next());
    let times = step_of(&all)?.map(|(step, _)| [0.0, step]);
    Ok(Some(Series { unit, times, ..Series::new(group, name, values) }))
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
