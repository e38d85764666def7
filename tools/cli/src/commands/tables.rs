//! The folder of `--csv`: one table per record.

use std::path::{Path, PathBuf};

use stickslip::data::Record;
use stickslip::diagnose::Comparison;

use super::check_destinations;
use crate::output::Outputs;
use crate::{Failure, ResultFiles};

/// The table of the record called `record` (a path beside the dataset) about `what`.
pub fn table_of(folder: &Path, record: &str, what: &str) -> PathBuf {
    let stem = Path::new(record).with_extension("");
    let stem = stem.to_string_lossy().replace(['/', '\\'], "-");
    folder.join(format!("{stem}-{what}.csv"))
}

/// Refuses results, among them the `tables` in `folder`, that could not be written, before any work; the folder may still
/// be missing.
pub fn check(
    files: &ResultFiles,
    out: &Option<PathBuf>,
    folder: Option<&Path>,
    tables: impl Iterator<Item = PathBuf>,
    inputs: &[PathBuf],
) -> Result<(), Failure> {
    let Some(folder) = folder else { return check_destinations(files, out, inputs) };
    if folder.is_dir() {
        let tables: Vec<PathBuf> = tables.collect();
        return check_destinations(files, out.iter().chain(&tables), inputs);
    }
    check_destinations(files, out, inputs)?;
    let present = folder.ancestors().find(|above| above.exists());
    match present.filter(|above| !above.is_dir()) {
        Some(file) => Err(Failure::input(format!(
            "--csv: {} cannot be a folder: {} is a file",
            folder.display(),
            file.display()
        ))),
        None => Ok(()),
    }
}

/// The folder, made where it is missing.
pub fn made(folder: &Path) -> Result<&Path, Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::input(format!("{} cannot be a folder: {error}", folder.display())))?;
    Ok(folder)
}

/// The tables of measured, predicted and residual values that [`add`] writes.
pub fn compared(folder: Option<&Path>, records: &[Record]) -> impl Iterator<Item = PathBuf> {
    folder.into_iter().flat_map(|folder| records.iter().map(|record| table_of(folder, &record.name, WHAT)))
}

const WHAT: &str = "compared";

/// Adds a table of measured, predicted and residual values for each record that is predicted.
pub fn add(folder: Option<&Path>, comparison: &Comparison, outputs: &mut Outputs) -> Result<(), Failure> {
    let Some(folder) = folder else { return Ok(()) };
    let folder = made(folder)?;
    for (index, record) in comparison.records.iter().enumerate() {
        if let Some(table) = stickslip_report::samples_csv(comparison, index) {
            outputs.add(&table_of(folder, &record.name, WHAT), table);
        }
    }
    Ok(())
}
