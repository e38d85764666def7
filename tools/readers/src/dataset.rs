//! `dataset.toml` and the files it lists.

use std::path::Path;

use stickslip::data::{ChannelName, Dataset, Record, Regime, Use};
use stickslip::document::{Document, DocumentError, Table};

use crate::error::{InputError, Problem};
use crate::source::Source;
use crate::table::{Column, read_table};

pub(crate) const SCHEMA: &str = "stickslip.dataset/1";
pub(crate) const REGIMES: &[(&str, Regime)] = &[
    ("from-rest", Regime::FromRest),
    ("steady", Regime::Steady),
    ("unknown-initial-state", Regime::UnknownInitialState),
    ("backbone", Regime::Backbone),
    ("stepped-sine", Regime::SteppedSine),
];
pub(crate) const USES: &[(&str, Use)] =
    &[("fit", Use::Fit), ("select", Use::Select), ("confirm", Use::Confirm)];

/// Reads a dataset: its `dataset.toml`, or the folder that holds one, and every file it lists.
///
/// Values come out in SI. Time stamps increase strictly; they need not be evenly spaced.
///
/// # Errors
/// The first thing wrong with the dataset file or any of the tables: a file that cannot be read or is not
/// UTF-8, an unknown key, column, regime or use, a unit that does not suit its column, a field that is no
/// finite number, a row that is too short or too long, time that does not increase, a column that is there
/// twice or that the regime needs and is not there, noise of a column that is not there.
///
/// ```
/// let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/frictional-support");
/// let dataset = stickslip_readers::read_dataset(path)?;
/// assert_eq!(dataset.records[0].name, "backbone.csv");
/// # Ok::<(), stickslip_readers::InputError>(())
/// ```
pub fn read_dataset(path: impl AsRef<Path>) -> Result<Dataset, InputError> {
    let path = path.as_ref();
    let file = if path.is_dir() { path.join("dataset.toml") } else { path.to_owned() };
    let source = Source::read(&file)?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let at = |error| source.document_error(error);
    let document = Document::parse(source.text()).map_err(at)?;
    let root = document.root();
    let tables = check_top(&root).map_err(at)?;
    let title = root.string("title").map_err(at)?.map(|title| title.value.to_owned());
    let mut records: Vec<Record> = Vec::with_capacity(tables.len());
    for table in &tables {
        let record = read_record(&source, folder, table)?;
        if records.iter().any(|other| other.name == record.name) {
            // Twice the same data could be fitted and confirmed with at once.
            let message = format!("`{}` is listed twice", record.name);
            return Err(at(DocumentError::new(message, table.span_of("file"))));
        }
        records.push(record);
    }
    Ok(Dataset { title, records })
}

/// Checks schema and keys; the tables of the records.
fn check_top<'a>(root: &Table<'a>) -> Result<Vec<Table<'a>>, DocumentError> {
    let first_line = || format!("a dataset file needs schema = \"{SCHEMA}\"");
    let schema = root.required_string("schema").map_err(|error| error.with_help(first_line()))?;
    if schema.value != SCHEMA {
        let message = format!("schema \"{}\" is not one this version reads", schema.value);
        return Err(schema.error(message).with_help(first_line()));
    }
    root.allow(&["schema", "title", "record"])?;
    let tables = root.tables("record")?.unwrap_or_default();
    if tables.is_empty() {
        return Err(root.missing("record").with_help("list each file: [[record]] with `file` and `regime`"));
    }
    Ok(tables)
}

fn read_record(source: &Source, folder: &Path, table: &Table<'_>) -> Result<Record, InputError> {
    let at = |error| source.document_error(error);
    table.allow(&["file", "regime", "use", "noise"]).map_err(at)?;
    let file = table.required_string("file").map_err(at)?;
    let regime = table.choice("regime", REGIMES).map_err(at)?.ok_or_else(|| {
        let names: Vec<_> = REGIMES.iter().map(|(name, _)| format!("`{name}`")).collect();
        at(table.missing("regime").with_help(format!("legal values: {}", names.join(", "))))
    })?;
    let use_for = table.choice("use", USES).map_err(at)?.map(|use_for| use_for.value);
    let path = folder.join(file.value);
    let csv = match std::fs::read(&path) {
        Ok(bytes) => Source::from_bytes(&path, bytes)?,
        Err(error) => {
            // The mistake is in the line that names the file.
            let what = format!("`{}`", file.value);
            return Err(source.error(file.span, Problem::Unreadable { what, reason: error.to_string() }));
        }
    };
    let columns = read_table(&csv)?;
    check_regime(&csv, regime.value, &columns)?;
    let noise = read_noise(table, &columns).map_err(at)?;
    let channels = columns.into_iter().zip(noise).map(|(column, noise)| column.into_channel(noise)).collect();
    Ok(Record { name: file.value.to_owned(), regime: regime.value, use_for, channels })
}

/// Refuses a table without the columns that its regime needs, whatever the model, and a load that could never press.
fn check_regime(csv: &Source, regime: Regime, columns: &[Column]) -> Result<(), InputError> {
    let (needed, reason): (&[&str], _) = match regime {
        Regime::Backbone => {
            (&["amplitude [m/s^2]", "frequency [Hz]"], "a backbone is a table of frequency against amplitude")
        }
        Regime::SteppedSine => {
            (&["frequency [Hz]", "excitation [N]"], "a stepped-sine table has them in every row")
        }
        _ => (&["time [s]"], "every record that is no table has time stamps"),
    };
    for column in needed {
        let name = column.split(' ').next().unwrap_or(column);
        if !columns.iter().any(|column| column.name.quantity.name == name) {
            let problem = Problem::MissingColumn { column: (*column).to_owned(), reason: reason.to_owned() };
            return Err(csv.error_at_start(problem));
        }
    }
    let pulling = |column: &Column| column.values.iter().all(|load| *load < 0.0);
    if columns.iter().any(|column| column.name.quantity.name == "normal_load" && pulling(column)) {
        return Err(csv.error_at_start(Problem::PullingLoad));
    }
    Ok(())
}

/// The noise of each column, in the column's unit.
fn read_noise(table: &Table<'_>, columns: &[Column]) -> Result<Vec<Option<f64>>, DocumentError> {
    let mut noise = vec![None; columns.len()];
    let Some(entries) = table.table("noise")? else { return Ok(noise) };
    for key in entries.keys() {
        let name = ChannelName::parse(key.value).ok();
        let index = columns.iter().position(|column| Some(&column.name) == name.as_ref());
        let Some(index) = index else {
            let names: Vec<_> = columns.iter().map(|column| format!("`{}`", column.name)).collect();
            return Err(key
                .error(format!("noise of `{}`, but the file has no such column", key.value))
                .with_help(format!("its columns are {}", names.join(", "))));
        };
        let value = entries.required_number(key.value)?;
        if value.value <= 0.0 {
            return Err(value
                .error(format!("the noise of `{}` must be above 0, not {}", key.value, value.value))
                .with_help("it is a standard deviation in the column's unit; leave it out where unknown"));
        }
        noise[index] = Some(value.value);
    }
    Ok(noise)
}
