//! A diagnosis for people and programs: one self-contained page, text for the terminal, and JSON.

mod alike;
mod figures;
mod json;
mod page;
mod residual;
mod sections;
mod terminal;
mod words;

pub use json::{added_json, diagnosis_json};
pub use page::diagnosis_html;
pub use terminal::diagnosis_table;

pub(crate) use words::{interval, value_within};

use stickslip::diagnose::DiagnoseOptions;

/// How a diagnosis was asked for and what it took: what its result does not say itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Run {
    /// The model's file as the user named it.
    pub model: String,
    /// The dataset as the user named it.
    pub dataset: String,
    /// Where the improved model was written, if it was.
    pub written: Option<String>,
    /// What was to be tried, and what was taken for granted.
    pub options: DiagnoseOptions,
    /// How long it took (s).
    pub seconds: f64,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
}
