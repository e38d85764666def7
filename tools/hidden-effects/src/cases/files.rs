//! A case as files: `model.toml`, `dataset.toml`, `r0.csv` ..., and the truth beside the folders.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::cases::case::{Case, Drawn};
use crate::records::record::{Column, Record};

/// Changes when the same name no longer gives the same case: files of another generation are left alone.
pub const GENERATION: u32 = 9;

/// Folder of a case under `root`.
pub fn folder(root: &Path, case: &Case) -> PathBuf {
    root.join(case.name())
}

/// Writes a case into its folder under `root`, whole or not at all; one that is there is left alone.
///
/// # Errors
/// A case that cannot be drawn, a folder that cannot be written.
pub fn write(root: &Path, case: &Case) -> Result<PathBuf, String> {
    let folder = folder(root, case);
    if folder.is_dir() {
        return Ok(folder);
    }
    let drawn = case.draw()?;
    let unfinished = root.join(format!(".{}-{}", std::process::id(), case.name()));
    let fail = |error: io::Error| format!("{}: {error}", folder.display());
    fs::create_dir_all(&unfinished).map_err(fail)?;
    for (name, text) in texts(&drawn) {
        fs::write(unfinished.join(name), text).map_err(fail)?;
    }
    match fs::rename(&unfinished, &folder) {
        // Another process may have been faster: the same case gives the same bytes.
        Err(_) if folder.is_dir() => fs::remove_dir_all(&unfinished).map_err(fail)?,
        result => result.map_err(fail)?,
    }
    Ok(folder)
}

/// The files of a case, by name.
pub fn texts(drawn: &Drawn) -> Vec<(String, String)> {
    let records = drawn.measure();
    let mut files =
        vec![("model.toml".to_owned(), drawn.model()), ("dataset.toml".to_owned(), dataset(&records))];
    files.extend(records.iter().enumerate().map(|(index, record)| (format!("r{index}.csv"), table(record))));
    files
}

fn dataset(records: &[Record]) -> String {
    let mut text = String::from("schema = \"stickslip.dataset/1\"\n");
    for (index, record) in records.iter().enumerate() {
        let _ =
            write!(text, "\n[[record]]\nfile = \"r{index}.csv\"\nregime = \"{}\"\n", record.regime.word());
        if !record.told.is_empty() {
            let told: Vec<String> = record
                .told
                .iter()
                .map(|(name, size)| format!("\"{name}\" = {}", rounded(*size, 3)))
                .collect();
            let _ = writeln!(text, "noise = {{ {} }}", told.join(", "));
        }
    }
    text
}

fn table(record: &Record) -> String {
    let mut text = String::new();
    let header: Vec<String> =
        record.columns.iter().map(|column| format!("{} [{}]", column.name, column.unit)).collect();
    let _ = writeln!(text, "{}", header.join(","));
    let count = record.columns.first().map_or(0, |column| column.values.len());
    for row in 0..count {
        let value = |column: &Column| rounded(column.values[row], 9);
        let values: Vec<String> = record.columns.iter().map(value).collect();
        let _ = writeln!(text, "{}", values.join(","));
    }
    text
}

/// The shortest text of a number rounded to so many digits.
fn rounded(value: f64, digits: usize) -> String {
    let written = format!("{value:.*e}", digits - 1);
    let value: f64 = written.parse().unwrap_or(value);
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

/// What is hidden in a case, in the words of `truth.json`.
///
/// # Errors
/// A case that cannot be drawn.
pub fn truth(case: &Case) -> Result<Value, String> {
    let drawn = case.draw()?;
    let effects: Vec<&str> = drawn.hidden().iter().map(|hidden| hidden.id.as_str()).collect();
    let effect = if effects.is_empty() { "none".to_owned() } else { effects.join("+") };
    let mut parameters = Map::new();
    let mut places = Map::new();
    let mut law = None;
    for hidden in drawn.hidden() {
        let values = hidden.parameters.iter().map(|(name, value)| ((*name).to_owned(), json!(value)));
        parameters.insert(hidden.id.clone(), Value::Object(values.collect()));
        if !hidden.place.is_empty() {
            places.insert(hidden.id.clone(), json!(hidden.place));
        }
        law = law.or(hidden.law);
    }
    let mut truth = json!({
        "family": case.kind.word(),
        "effect": effect,
        "effects": effects,
        "noise": case.noise.share,
        "coloured": case.noise.coloured,
        "strength": case.strength.word(),
        "parameters": parameters,
        "places": places,
    });
    // Told only where it is so, as in names.
    if case.drive.is_moving() {
        truth["moving"] = json!(true);
    }
    if let Some(question) = case.question() {
        truth["question"] = json!(question);
    }
    if let Some(law) = law {
        truth["law"] = json!(law.name);
        truth["described_by"] = json!(law.described_by);
    }
    if !drawn.faults().is_empty() {
        truth["faults"] = json!(drawn.faults());
    }
    Ok(truth)
}

/// Writes `truth.json` beside the folders of `cases`.
///
/// # Errors
/// A case that cannot be drawn, a file that cannot be written.
pub fn write_truth(root: &Path, cases: &[Case]) -> Result<(), String> {
    let mut all = Map::new();
    for case in cases {
        all.insert(case.name(), truth(case)?);
    }
    let text = format!("{:#}\n", Value::Object(all));
    let path = root.join("truth.json");
    fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
}
