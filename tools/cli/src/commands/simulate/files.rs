//! Files of time histories.

use std::fmt::Write as _;
use std::path::Path;

use stickslip_report::simulation::{Simulation, simulation_json};

use super::parquet::parquet;
use crate::Failure;

const KINDS: [&str; 3] = ["csv", "json", "parquet"];

fn kind(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    KINDS.into_iter().find(|kind| *kind == extension)
}

/// Refuses other kinds of files before any work.
pub(super) fn check_kind(path: &Path) -> Result<(), Failure> {
    match kind(path) {
        Some(_) => Ok(()),
        None => Err(Failure::input(format!("{} should end in .csv, .json or .parquet", path.display()))),
    }
}

/// The content of the file at `path`.
pub(super) fn written(path: &Path, simulation: &Simulation) -> Vec<u8> {
    match kind(path) {
        Some("json") => format!("{:#}\n", simulation_json(simulation)).into(),
        Some("parquet") => columns(simulation),
        _ => csv(simulation).into(),
    }
}

/// A header of `name [unit]`, a row for each point; numbers are read back bit by bit.
fn csv(simulation: &Simulation) -> String {
    let mut text = String::from("time [s]");
    for column in &simulation.columns {
        text.push(',');
        text += &quoted(&column.heading());
    }
    text.push('\n');
    for (row, time) in simulation.time.iter().enumerate() {
        number(&mut text, *time);
        for column in &simulation.columns {
            text.push(',');
            number(&mut text, column.values[row]);
        }
        text.push('\n');
    }
    text
}

fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// The shortest text that is read back as the same number.
fn number(text: &mut String, value: f64) {
    let plain = value == 0.0 || (1e-4..1e15).contains(&value.abs()) || !value.is_finite();
    // Writing to a string cannot fail.
    let _ = if plain { write!(text, "{value}") } else { write!(text, "{value:e}") };
}

/// Columns called as in the CSV file.
fn columns(simulation: &Simulation) -> Vec<u8> {
    let others = simulation.columns.iter().map(|column| (column.heading(), column.values.as_slice()));
    let columns: Vec<_> =
        std::iter::once(("time [s]".to_owned(), simulation.time.as_slice())).chain(others).collect();
    parquet(&columns, &[("system", &simulation.title), ("algorithm", &simulation.algorithm)])
}
