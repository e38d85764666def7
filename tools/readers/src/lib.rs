//! Reads the files an engineer writes: `model.toml`, `dataset.toml` and the CSV files beside it, plans of tests on a virtual
//! rig; and the systems of FMUs ([`ssp`]) that programs write. Writes datasets.
//!
//! Everything is checked before anything is returned: there are no partial results, and nothing is
//! repaired silently. An [`InputError`] is data (file, line, what is wrong); [`InputError::render`] is
//! the one place that turns it into the text a user sees, with the line it is about.
//!
//! Text is UTF-8; a byte order mark and CR-LF line ends are accepted. Tables in other dialects are imported ([`import_file`]),
//! and what was guessed is told.

pub mod archive;
mod bounded;
mod columns;
mod dataset;
mod error;
mod import;
mod plan;
mod rules;
mod signals;
mod source;
pub mod ssp;
mod table;
pub mod units;
mod write;
pub mod xml;

use std::path::Path;

use stickslip::model::Model;

pub use columns::check_columns;
pub use dataset::{read_dataset, read_dataset_told, regime, regimes};
pub use error::{Excerpt, InputError, Problem};
pub use import::{ColumnRule, GUARDED, ImportOptions, Imported, import_file, import_table};
pub use plan::{RigPlan, read_plan};
pub use signals::{Signal, read_signals};
pub use write::{dataset_toml, record_csv, truth_toml};

/// Reads a model file.
///
/// # Errors
/// A file that cannot be read or is not UTF-8, and everything [`Model::parse`] refuses.
///
/// ```
/// let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/friction-vibration/model.toml");
/// let model = stickslip_readers::read_model(path)?;
/// assert_eq!(model.get("contact.normal_load"), Some(1.0));
/// # Ok::<(), stickslip_readers::InputError>(())
/// ```
pub fn read_model(path: impl AsRef<Path>) -> Result<Model, InputError> {
    let source = source::Source::read(path.as_ref())?;
    Model::parse(source.text()).map_err(|error| source.document_error(error))
}
