//! `dataset.toml` and the files it lists.

use std::path::Path;

use stickslip::data::{Channel, ChannelName, Dataset, Record, Regime, Use};
use stickslip::document::{Document, DocumentError, Table};

use crate::bounded;
use crate::error::{InputError, Problem};
use crate::import::{ColumnRule, ImportOptions, import_table, is_foreign};
use crate::rules;
use crate::source::Source;
use crate::table::read_table;

pub(crate) const SCHEMA: &str = "stickslip.dataset/1";
pub(crate) const REGIMES: &[(&str, Regime)] = &[
    ("from-rest", Regime::FromRest),
    ("steady", Regime::Steady),
    ("unknown-initial-state", Regime::UnknownInitialState),
    ("backbone", Regime::Backbone),
    ("stepped-sine", Regime::SteppedSine),
];
/// Keys of a record.
pub(crate) const RECORD: &[&str] = &["file", "part", "regime", "use", "noise", "columns"];
pub(crate) const USES: &[(&str, Use)] =
    &[("fit", Use::Fit), ("select", Use::Select), ("confirm", Use::Confirm)];

/// The regime that a dataset file spells `name`.
pub fn regime(name: &str) -> Option<Regime> {
    REGIMES.iter().find(|(legal, _)| *legal == name).map(|(_, regime)| *regime)
}

/// How a dataset file spells all regimes.
pub fn regimes() -> Vec<&'static str> {
    REGIMES.iter().map(|(name, _)| *name).collect()
}

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
    read_dataset_told(path).map(|(dataset, _)| dataset)
}

/// As [`read_dataset`], with what was guessed and done where the file maps columns, or lists files of other formats than CSV:
/// a sentence each.
///
/// # Errors
/// As [`read_dataset`], and what [`import_file`](crate::import_file) refuses.
pub fn read_dataset_told(path: impl AsRef<Path>) -> Result<(Dataset, Vec<String>), InputError> {
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
    let shared = rules::read(&root).map_err(at)?;
    let mut notes = Vec::new();
    for table in &tables {
        let record = read_record(&source, folder, table, &shared, &mut notes)?;
        if records.iter().any(|other| other.name == record.name) {
            // Twice the same data could be fitted and confirmed with at once.
            let message = format!("`{}` is listed twice", record.name);
            return Err(at(DocumentError::new(message, table.span_of("file"))));
        }
        records.push(record);
    }
    Ok((Dataset { title, records }, notes))
}

/// Checks schema and keys; the tables of the records.
fn check_top<'a>(root: &Table<'a>) -> Result<Vec<Table<'a>>, DocumentError> {
    let first_line = || format!("a dataset file needs schema = \"{SCHEMA}\"");
    let schema = root.required_string("schema").map_err(|error| error.with_help(first_line()))?;
    if schema.value != SCHEMA {
        let message = format!("schema \"{}\" is not one this version reads", schema.value);
        return Err(schema.error(message).with_help(first_line()));
    }
    root.allow(&["schema", "title", "columns", "record"])?;
    let tables = root.tables("record")?.unwrap_or_default();
    if tables.is_empty() {
        return Err(root.missing("record").with_help("list each file: [[record]] with `file` and `regime`"));
    }
    Ok(tables)
}

fn read_record(
    source: &Source,
    folder: &Path,
    table: &Table<'_>,
    shared: &[(String, ColumnRule)],
    notes: &mut Vec<String>,
) -> Result<Record, InputError> {
    let at = |error| source.document_error(error);
    table.allow(RECORD).map_err(at)?;
    let file = table.required_string("file").map_err(at)?;
    let part = table.string("part").map_err(at)?;
    let regime = table.choice("regime", REGIMES).map_err(at)?.ok_or_else(|| {
        let names: Vec<_> = REGIMES.iter().map(|(name, _)| format!("`{name}`")).collect();
        at(table.missing("regime").with_help(format!("legal values: {}", names.join(", "))))
    })?;
    let use_for = table.choice("use", USES).map_err(at)?.map(|use_for| use_for.value);
    let path = folder.join(file.value);
    let bytes = bounded::read(&path).map_err(|error| match *error.problem {
        // The mistake is in the line that names the file.
        Problem::Unreadable { reason, .. } => {
            source.error(file.span.clone(), Problem::Unreadable { what: format!("`{}`", file.value), reason })
        }
        _ => error,
    })?;
    let mut columns = rules::read(table).map_err(at)?;
    // What is said of the record goes before what is said of all.
    columns.extend(
        shared
            .iter()
            .filter(|(key, _)| !columns.iter().any(|(own, _)| own == key))
            .cloned()
            .collect::<Vec<_>>(),
    );
    if !columns.is_empty() || part.is_some() || is_foreign(&bytes) {
        let options = ImportOptions {
            columns,
            regime: Some(regime.value),
            structure: None,
            sample_rate: None,
            part: part.as_ref().map(|part| part.value.to_owned()),
        };
        let (mut record, factors) = imported(&path, bytes, &options, file.value, notes)?;
        let names: Vec<ChannelName> =
            record.channels.iter().filter_map(|channel| ChannelName::parse(&channel.name).ok()).collect();
        let noise = read_noise(table, &names).map_err(at)?;
        for (channel, noise) in record.channels.iter_mut().zip(noise) {
            let factor =
                factors.iter().find(|(name, _)| *name == channel.name).map_or(1.0, |(_, factor)| *factor);
            channel.noise = noise.map(|noise| noise * factor);
        }
        check_regime(|problem| source.error(file.span.clone(), problem), regime.value, &record)?;
        return Ok(Record { use_for, ..record });
    }
    let csv = Source::from_bytes(&path, bytes)?;
    let columns = read_table(&csv)?;
    let names: Vec<ChannelName> = columns.iter().map(|column| column.name.clone()).collect();
    let noise = read_noise(table, &names).map_err(at)?;
    let channels = columns.into_iter().zip(noise).map(|(column, noise)| column.into_channel(noise)).collect();
    let record = Record { name: file.value.to_owned(), regime: regime.value, use_for, channels };
    check_regime(|problem| csv.error_at_start(problem), regime.value, &record)?;
    Ok(record)
}

/// The one record of a file that only the import reads.
fn imported(
    path: &Path,
    bytes: Vec<u8>,
    options: &ImportOptions,
    file: &str,
    notes: &mut Vec<String>,
) -> Result<(Record, Vec<(String, f64)>), InputError> {
    let imported = import_table(path, bytes, options)?;
    notes.extend(imported.notes.iter().map(|note| format!("{file}: {note}")));
    let names: Vec<String> = imported.records.iter().map(|record| format!("`{}`", record.name)).collect();
    let [mut record] = <[Record; 1]>::try_from(imported.records).map_err(|_| InputError {
        path: path.to_owned(),
        excerpt: None,
        problem: Box::new(Problem::Import {
            message: format!("the file gives {} records: {}", names.len(), names.join(", ")),
            help: "name one with `part = \"…\"`, or make a folder of all: `stickslip import FILE -o DIR`"
                .to_owned(),
        }),
    })?;
    record.name = options.part.as_ref().map_or(file.to_owned(), |part| format!("{file}:{part}"));
    Ok((record, imported.factors))
}

/// Refuses a table without the columns that its regime needs, whatever the model, and a load that could never press.
fn check_regime(
    refused: impl Fn(Problem) -> InputError,
    regime: Regime,
    record: &Record,
) -> Result<(), InputError> {
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
        if record.channels_of(name).next().is_none() {
            let problem = Problem::MissingColumn { column: (*column).to_owned(), reason: reason.to_owned() };
            return Err(refused(problem));
        }
    }
    let pulling = |channel: &Channel| channel.values.iter().all(|load| *load < 0.0);
    if record.channels_of("normal_load").any(pulling) {
        return Err(refused(Problem::PullingLoad));
    }
    Ok(())
}

/// The noise of each column, in the column's unit.
fn read_noise(table: &Table<'_>, columns: &[ChannelName]) -> Result<Vec<Option<f64>>, DocumentError> {
    let mut noise = vec![None; columns.len()];
    let Some(entries) = table.table("noise")? else { return Ok(noise) };
    for key in entries.keys() {
        let name = ChannelName::parse(key.value).ok();
        let index = columns.iter().position(|column| Some(column) == name.as_ref());
        let Some(index) = index else {
            let names: Vec<_> = columns.iter().map(|column| format!("`{column}`")).collect();
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
