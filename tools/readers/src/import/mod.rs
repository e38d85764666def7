//! Tables as laboratories export them, read without a `dataset.toml`: bytes in, records in SI and notes out.
//!
//! `text.rs` makes text of the bytes, or says which other format they are; `grid.rs` finds separator, decimal sign, heading,
//! units and rows; `heading.rs` says which column means what; `records.rs` cuts the rows into records. Whatever was guessed,
//! left out or cut is a note: nothing is silent. What cannot be read is one sentence that says what to do.

mod grid;
mod heading;
mod records;
mod text;

use std::path::Path;

use stickslip::data::{Record, Regime};

use crate::error::{InputError, Problem};

/// What the user says about the files, so that it need not be guessed.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions {
    /// Columns: the heading in the file, or the column's number from 1; and what it is, as `name [unit]`.
    pub columns: Vec<(String, String)>,
    /// The regime of all records.
    pub regime: Option<Regime>,
    /// Whether a force is that on a structure (`excitation`) or that of a contact; guessed where nothing is said.
    pub structure: Option<bool>,
}

/// The records of one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The records, named as CSV files; several where the file had to be cut.
    pub records: Vec<Record>,
    /// What was guessed, left out or cut: a sentence each.
    pub notes: Vec<String>,
}

/// Reads a text table in any of the usual dialects.
///
/// # Errors
/// A file that cannot be read or is no text table, has no names of columns or no time stamps, names of which none is known,
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
    let failed = |refusal: Refusal| InputError {
        path: path.to_owned(),
        excerpt: None,
        problem: Box::new(Problem::Import { message: refusal.message, help: refusal.help }),
    };
    let mut notes = Vec::new();
    let text = text::decode(bytes, &mut notes).map_err(failed)?;
    let grid = grid::read(&text, &mut notes).map_err(failed)?;
    let columns = heading::recognise(grid, options, &mut notes).map_err(failed)?;
    let stem = path.file_stem().map_or("record".into(), |stem| stem.to_string_lossy().into_owned());
    let records = records::cut(&stem, columns, options, &mut notes).map_err(failed)?;
    Ok(Imported { records, notes })
}

/// As [`import_table`], of a file.
///
/// # Errors
/// As [`import_table`].
pub fn import_file(path: &Path, options: &ImportOptions) -> Result<Imported, InputError> {
    let bytes = std::fs::read(path).map_err(|error| InputError {
        path: path.to_owned(),
        excerpt: None,
        problem: Box::new(Problem::Unreadable { what: "the file".to_owned(), reason: error.to_string() }),
    })?;
    import_table(path, bytes, options)
}

/// Why a file was refused, and what to do.
struct Refusal {
    message: String,
    help: String,
}

fn refuse(message: impl Into<String>, help: impl Into<String>) -> Refusal {
    Refusal { message: message.into(), help: help.into() }
}
