//! One file per command.

pub mod compare;
pub mod demo;
pub mod export;
pub mod fmu;

use std::path::Path;

use stickslip::diagnose::Comparison;
use stickslip::measure::Dataset;
use stickslip::model::Model;

use crate::output::Outputs;
use crate::{Failure, ResultFiles};

/// Reads a model file; the failure points at the line.
fn read_model(path: &Path) -> Result<Model, Failure> {
    stickslip_readers::read_model(path).map_err(shown)
}

/// Reads a dataset and makes sure that it has what `model` needs.
fn read_dataset(path: &Path, model: &Model) -> Result<Dataset, Failure> {
    let dataset = stickslip_readers::read_dataset(path).map_err(shown)?;
    stickslip_readers::check_columns(path, &dataset, model).map_err(shown)?;
    Ok(dataset)
}

fn shown(error: stickslip_readers::InputError) -> Failure {
    use std::io::IsTerminal as _;
    Failure::input(error.render(std::io::stderr().is_terminal()))
}

/// Prints the comparison and puts the asked-for files among `outputs`.
fn present(
    comparison: &Comparison,
    settings: &stickslip_report::Settings,
    files: &ResultFiles,
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    print!("{}", terminal_table(comparison));
    if let Some(path) = &files.json {
        let text = serde_json::to_string_pretty(&stickslip_report::json(comparison))
            .map_err(|error| Failure::other(error.to_string()))?;
        outputs.add(path, text + "\n");
    }
    if let Some(path) = &files.report {
        outputs.add(path, stickslip_report::html(comparison, settings));
    }
    Ok(())
}

fn terminal_table(comparison: &Comparison) -> String {
    use std::io::IsTerminal as _;
    stickslip_report::terminal_table(comparison, 80, std::io::stdout().is_terminal())
}

/// Refuses destinations that could not be written, before any work.
fn check_destinations(files: &ResultFiles) -> Result<(), Failure> {
    files.json.iter().chain(&files.report).try_for_each(|path| Outputs::check(path))
}
