//! Results of a comparison for people and programs: one self-contained HTML page, a table for the
//! terminal, and JSON. Everything here is a pure function of its arguments: the same comparison gives
//! the same bytes, and nothing is read from or written to disk or network.

mod branches;
mod catalogue;
pub mod check;
mod comparison;
mod contact_loop;
mod decimate;
pub mod diagnosis;
pub mod document;
mod explorer;
mod figure;
mod format;
pub mod identification;
mod json;
mod modes;
mod page;
mod parameter;
mod plots;
mod reference;
pub mod responses;
pub mod simulation;
pub mod slip_slap;
mod table;
mod tables;
mod transfer;

pub use catalogue::{catalogue_table, effect_table};
pub use comparison::findings::findings;
pub use comparison::samples::samples_csv;
pub use contact_loop::{contact_loop, slip_slap_loops};
pub use json::json;
pub use modes::{ModeReport, mode_html};
pub use page::{html, html_with};
pub use parameter::{ParameterReport, parameter_html};
pub use reference::file_reference;
pub use table::{harmonic_text, terminal_table};

/// How a report was made, so that somebody else can make it again.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Settings {
    /// The command line as it was typed.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// The files that were read.
    pub files: Vec<InputFile>,
    /// When the report was made, as it is to be printed. `None` keeps the page reproducible.
    pub date: Option<String>,
}

/// A file that was read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct InputFile {
    /// Its name as the user knows it.
    pub name: String,
    /// Its SHA-256 hash in hexadecimal digits.
    pub sha256: String,
}
