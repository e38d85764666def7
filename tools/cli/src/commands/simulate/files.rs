//! Files of time histories.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use stickslip_report::simulation::{Simulation, simulation_json};

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
pub(super) fn written(path: &Path, simulation: &Simulation) -> Result<Vec<u8>, Failure> {
    match kind(path) {
        Some("json") => Ok(format!("{:#}\n", simulation_json(simulation)).into()),
        Some("parquet") => {
            parquet(simulation).map_err(|error| Failure::other(format!("{}: {error}", path.display())))
        }
        _ => Ok(csv(simulation).into()),
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
    if field.contains([',', '"', '\n', '\r']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_owned() }
}

/// The shortest text that is read back as the same number.
fn number(text: &mut String, value: f64) {
    let plain = value == 0.0 || (1e-4..1e15).contains(&value.abs()) || !value.is_finite();
    // Writing to a string cannot fail.
    let _ = if plain { write!(text, "{value}") } else { write!(text, "{value:e}") };
}

/// One row group of Double columns called as in the CSV file; units are also in the file's metadata.
fn parquet(simulation: &Simulation) -> Result<Vec<u8>, ParquetError> {
    let names: Vec<String> =
        std::iter::once("time [s]".to_owned()).chain(simulation.columns.iter().map(|column| column.heading())).collect();
    let fields = names.iter().map(|name| {
        let field = Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::REQUIRED);
        field.build().map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("simulation").with_fields(fields).build()?);
    let metadata = vec![KeyValue::new("system".to_owned(), simulation.title.clone())];
    let properties = WriterProperties::builder()
        .set_created_by(concat!("stickslip ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(metadata))
        .build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let columns = simulation.columns.iter().map(|column| &column.values);
    for values in std::iter::once(&simulation.time).chain(columns) {
        if let Some(mut column) = group.next_column()? {
            column.typed::<DoubleType>().write_batch(values, None, None)?;
            column.close()?;
        }
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}
