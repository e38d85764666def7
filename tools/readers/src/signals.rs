//! Signals over time with any names: inputs of systems of FMUs.

use std::path::Path;

use csv::StringRecord;

use crate::error::{InputError, Problem};
use crate::source::Source;
use crate::table::{field_span, first_row, next_row, row_span};

/// A signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Its name.
    pub name: String,
    /// Its unit, if the header has one.
    pub unit: Option<String>,
    /// Its values, in its unit.
    pub values: Vec<f64>,
}

/// Reads a CSV file whose first column is `time [s]`: times, which increase, and the other columns.
///
/// # Errors
/// A file that cannot be read or is no such table; fields that are not finite numbers.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("load.csv");
/// std::fs::write(&path, "time [s],load [N]\n0,100\n1,120\n")?;
/// let (time, signals) = stickslip_readers::read_signals(&path)?;
/// assert_eq!((time, &signals[0].values), (vec![0.0, 1.0], &vec![100.0, 120.0]));
/// assert_eq!((signals[0].name.as_str(), signals[0].unit.as_deref()), ("load", Some("N")));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_signals(path: impl AsRef<Path>) -> Result<(Vec<f64>, Vec<Signal>), InputError> {
    let source = Source::read(path.as_ref())?;
    let (mut reader, mut row) = first_row(&source)?;
    let header_span = row_span(source.text(), &row);
    let mut columns = header(&source, &row)?;
    while next_row(&mut reader, &mut row, &source)? {
        if row.len() != columns.len() {
            let problem = Problem::Ragged { expected: columns.len(), found: row.len() };
            return Err(source.error(row_span(source.text(), &row), problem));
        }
        for (index, (field, column)) in row.iter().zip(&mut columns).enumerate() {
            let value = value(field, column, index == 0)
                .map_err(|problem| source.error(field_span(source.text(), &row, index), problem))?;
            column.values.push(value);
        }
    }
    let mut columns = columns.into_iter();
    match columns.next() {
        Some(time) if !time.values.is_empty() => Ok((time.values, columns.collect())),
        _ => Err(source.error(header_span, Problem::NoRows)),
    }
}

fn header(source: &Source, row: &StringRecord) -> Result<Vec<Signal>, InputError> {
    let mut columns: Vec<Signal> = Vec::with_capacity(row.len());
    for (index, field) in row.iter().enumerate() {
        let fail = |problem| Err(source.error(field_span(source.text(), row, index), problem));
        let (name, unit) = match field.strip_suffix(']').and_then(|field| field.rsplit_once('[')) {
            Some((name, unit)) => (name.trim().to_owned(), Some(unit.trim().to_owned())),
            None => (field.to_owned(), None),
        };
        if index == 0 && (name != "time" || unit.as_deref() != Some("s")) {
            let reason = "the first column of signals over time".to_owned();
            return fail(Problem::MissingColumn { column: "time [s]".to_owned(), reason });
        }
        if columns.iter().any(|column| column.name == name) {
            return fail(Problem::DuplicateColumn(name));
        }
        columns.push(Signal { name, unit, values: Vec::new() });
    }
    Ok(columns)
}

fn value(field: &str, column: &Signal, is_time: bool) -> Result<f64, Problem> {
    let (name, text) = (|| column.name.clone(), || field.to_owned());
    let value: f64 = field.parse().map_err(|_| Problem::NotANumber { column: name(), text: text() })?;
    if !value.is_finite() {
        return Err(Problem::NotFinite { column: name(), text: text() });
    }
    match column.values.last() {
        Some(&previous) if is_time && value <= previous => {
            Err(Problem::TimeNotIncreasing { previous, time: value })
        }
        _ => Ok(value),
    }
}
