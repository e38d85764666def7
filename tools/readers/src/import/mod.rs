//! Tables as laboratories export them, read without a `dataset.toml`: bytes in, records in SI and notes out.
//!
//! `formats/` reads what is no text; `text.rs` makes text of the bytes, or says which other format they are; `grid.rs` finds separator,
//! decimal sign, heading, units and rows. `raw.rs` is what both give. `heading.rs` says which column means what, `columns.rs` what the
//! user says of it; `records.rs` cuts the rows into records. Whatever was guessed,
//! left out or cut is a note: nothing is silent. What cannot be read is one sentence that says what to do.

mod columns;
mod formats;
mod grid;
mod heading;
mod raw;
mod records;
mod text;

use std::path::Path;

use stickslip::data::{Record, Regime};

use crate::error::{InputError, Problem};
use raw::RawTable;

pub use columns::ColumnRule;
pub use formats::GUARDED;

/// What the user says about the files, so that it need not be guessed.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions {
    /// Columns: the heading in the file, or the column's number from 1; and what it is.
    pub columns: Vec<(String, ColumnRule)>,
    /// The regime of all records.
    pub regime: Option<Regime>,
    /// Whether a force is that on a structure (`excitation`) or that of a contact; guessed where nothing is said.
    pub structure: Option<bool>,
    /// Samples in a second (Hz), where the file has no time stamps.
    pub sample_rate: Option<f64>,
    /// The only part of the file to be read, by its name: a group of channels, an element of a struct array.
    pub part: Option<String>,
}

/// The records of one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The records, named as CSV files; several where the file had to be cut.
    pub records: Vec<Record>,
    /// What was guessed, left out or cut: a sentence each.
    pub notes: Vec<String>,
    /// By the name of a channel, what one of its unit in the file is in SI.
    pub factors: Vec<(String, f64)>,
}

/// Reads a table in any of the usual dialects and formats.
///
/// # Errors
/// A file that cannot be read or holds no table, has no names of columns or no time stamps, names of which none is known,
/// a column without a unit, a number out of the bounds of its quantity. The message says what to do.
///
/// ```
/// use stickslip_readers::{ImportOptions, import_table};
/// let bytes = b"Zeit (ms);Weg (mm);Kraft (kN)\n0,0;0,0;0,0\n0,5;0,1;0,2\n".to_vec();
/// let imported = import_table("loop.txt".as_ref(), bytes, &ImportOptions::default())?;
/// assert_eq!(imported.records[0].channel("force").unwrap().values, [0.0, 200.0]);
/// assert!(imported.notes.iter().any(|note| note.contains("decimal comma")));
/// # Ok::<(), stickslip_readers::InputError>(())
/// ```
pub fn import_table(path: &Path, bytes: Vec<u8>, options: &ImportOptions) -> Result<Imported, InputError> {
    let stem = path.file_stem().map_or("record".into(), |stem| stem.to_string_lossy().into_owned());
    imported(&stem, bytes, options).map_err(|refusal| InputError {
        path: path.to_owned(),
        excerpt: None,
        problem: Box::new(Problem::Import { message: refusal.message, help: refusal.help }),
    })
}

/// As [`import_table`], of a file.
///
/// # Errors
/// As [`import_table`].
pub fn import_file(path: &Path, options: &ImportOptions) -> Result<Imported, InputError> {
    import_table(path, crate::bounded::read(path)?, options)
}

/// Whether a file is of a format that only the import reads: none of text.
pub(crate) fn is_foreign(bytes: &[u8]) -> bool {
    formats::find(bytes).is_some()
}

fn imported(stem: &str, bytes: Vec<u8>, options: &ImportOptions) -> Result<Imported, Refusal> {
    let mut notes = Vec::new();
    let tables = match formats::find(&bytes) {
        Some(format) => {
            let series = formats::read(format, &bytes, &mut notes)?;
            drop(bytes);
            formats::tables(series, &mut notes)?
        }
        None => {
            let text = text::decode(bytes, &mut notes)?;
            vec![RawTable { name: String::new(), columns: grid::read(&text, &mut notes)? }]
        }
    };
    let tables = chosen(tables, options)?;
    columns::check(&tables, options)?;
    let several = tables.len() > 1;
    let (mut records, mut passed, mut factors) = (Vec::new(), Vec::new(), Vec::new());
    for table in tables {
        let name = named(stem, &table.name);
        let before = notes.len();
        let made = heading::recognise(table.columns, options, &mut notes)
            .and_then(|columns| columns::clocked(columns, options))
            .and_then(|columns| columns::shifted(columns, &mut notes))
            .inspect(|columns| {
                factors.extend(columns.iter().map(|column| (column.name.to_string(), column.factor)))
            })
            .and_then(|columns| records::cut(&name, columns, options, &mut notes));
        match made {
            Ok(made) => records.extend(made),
            // A group of other things beside the measurements.
            Err(refusal) if several && refusal.is_other => {
                notes.truncate(before);
                passed.push((table.name, refusal));
            }
            Err(refusal) => return Err(refusal),
        }
    }
    if records.is_empty() && passed.is_empty() {
        return Err(refuse(
            "there is no measurement in the file",
            "export a table with one column per channel",
        ));
    }
    let (true, Some((_, refusal))) = (records.is_empty(), passed.pop_if(|_| records.is_empty())) else {
        notes.extend(
            passed.iter().map(|(name, refusal)| format!("`{name}` was not used: {}", refusal.message)),
        );
        let mut seen = std::collections::BTreeSet::new();
        notes.retain(|note| seen.insert(note.clone()));
        return Ok(Imported { records, notes, factors });
    };
    Err(refusal)
}

/// The part that is asked for, or all.
fn chosen(tables: Vec<RawTable>, options: &ImportOptions) -> Result<Vec<RawTable>, Refusal> {
    let Some(part) = &options.part else { return Ok(tables) };
    let names: Vec<String> = tables.iter().map(|table| format!("`{}`", table.name)).collect();
    let chosen: Vec<RawTable> = tables.into_iter().filter(|table| table.name == *part).collect();
    if chosen.is_empty() {
        return Err(refuse(
            format!("there is no part `{part}` in the file"),
            format!("its parts are {}", names.join(", ")),
        ));
    }
    Ok(chosen)
}

/// The name of a part as that of a file.
fn named(stem: &str, part: &str) -> String {
    let plain = |letter: char| if letter.is_alphanumeric() || "-_.".contains(letter) { letter } else { '_' };
    match part {
        "" => stem.to_owned(),
        part => format!("{stem}-{}", part.chars().map(plain).collect::<String>()),
    }
}

/// Why a file was refused, and what to do.
struct Refusal {
    message: String,
    help: String,
    /// Whether it is no measurement at all, rather than one that something is wrong with.
    is_other: bool,
}

fn refuse(message: impl Into<String>, help: impl Into<String>) -> Refusal {
    Refusal { message: message.into(), help: help.into(), is_other: false }
}
