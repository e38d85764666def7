//! One CSV file: a header of `name [unit]`, numbers below it.

use std::ops::Range;

use csv::{ReaderBuilder, StringRecord, Trim};
use stickslip::data::{Channel, ChannelName, unit_factor};
use stickslip::vocabulary::Quantity;

use crate::error::{InputError, Problem};
use crate::source::Source;

/// A column being read: its values are in SI already.
pub(crate) struct Column {
    pub(crate) name: ChannelName,
    /// What turns the file's unit into SI.
    pub(crate) factor: f64,
    pub(crate) values: Vec<f64>,
}

impl Column {
    /// The finished channel, with the noise's standard deviation given in the file's unit.
    pub(crate) fn into_channel(self, noise: Option<f64>) -> Channel {
        Channel {
            name: self.name.to_string(),
            unit: self.name.quantity.unit,
            values: self.values,
            noise: noise.map(|noise| noise * self.factor),
        }
    }
}

/// Reads all columns of `source`, all of the same length, at least one row.
pub(crate) fn read_table(source: &Source) -> Result<Vec<Column>, InputError> {
    let (mut reader, mut row) = first_row(source)?;
    let header_span = row_span(source.text(), &row);
    let mut columns = read_header(source, &row)?;
    let mut rows = 0usize;
    while next_row(&mut reader, &mut row, source)? {
        read_row(source, &row, &mut columns)?;
        rows += 1;
    }
    match rows {
        0 => Err(source.error(header_span, Problem::NoRows)),
        _ => Ok(columns),
    }
}

/// The reader of the rows, after the first one, which names the columns.
pub(crate) fn first_row(source: &Source) -> Result<(csv::Reader<&[u8]>, StringRecord), InputError> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(source.text().as_bytes());
    let mut row = StringRecord::new();
    if next_row(&mut reader, &mut row, source)? {
        Ok((reader, row))
    } else {
        Err(source.error_at_start(Problem::Empty))
    }
}

pub(crate) fn next_row(
    reader: &mut csv::Reader<&[u8]>,
    row: &mut StringRecord,
    source: &Source,
) -> Result<bool, InputError> {
    // The text is UTF-8, rows may be ragged and the bytes are in memory: this cannot fail. If it ever
    // does, it must not pass for the end of the file.
    reader.read_record(row).map_err(|error| {
        let start = error.position().map_or(0, |position| usize::try_from(position.byte()).unwrap_or(0));
        source.error(
            start..start,
            Problem::Unreadable { what: "the table".to_owned(), reason: error.to_string() },
        )
    })
}

fn read_header(source: &Source, row: &StringRecord) -> Result<Vec<Column>, InputError> {
    if let (1, Some(field)) = (row.len(), row.get(0))
        && let Some(separator) =
            [(';', "semicolons"), ('\t', "tabs")].iter().find(|(sign, _)| field.contains(*sign))
    {
        return Err(source.error(row_span(source.text(), row), Problem::Separator(separator.1)));
    }
    let mut columns: Vec<Column> = Vec::with_capacity(row.len());
    for (index, field) in row.iter().enumerate() {
        let fail = |problem| source.error(field_span(source.text(), row, index), problem);
        let (name, unit) = match field.strip_suffix(']').and_then(|field| field.rsplit_once('[')) {
            Some((name, unit)) => (name.trim(), Some(unit)),
            None => (field, None),
        };
        let name = ChannelName::parse(name).map_err(|error| fail(Problem::Name(error)))?;
        let unit = unit.ok_or_else(|| fail(Problem::NoUnit(name.to_string())))?;
        let factor = unit_factor(unit, name.quantity).map_err(|error| fail(Problem::Unit(error)))?;
        if columns.iter().any(|column| column.name == name) {
            return Err(fail(Problem::DuplicateColumn(name.to_string())));
        }
        columns.push(Column { name, factor, values: Vec::new() });
    }
    Ok(columns)
}

fn read_row(source: &Source, row: &StringRecord, columns: &mut [Column]) -> Result<(), InputError> {
    if row.len() != columns.len() {
        let problem = Problem::Ragged { expected: columns.len(), found: row.len() };
        return Err(source.error(row_span(source.text(), row), problem));
    }
    for (index, (field, column)) in row.iter().zip(columns).enumerate() {
        let value = parse_field(field, column)
            .map_err(|problem| source.error(field_span(source.text(), row, index), problem))?;
        column.values.push(value);
    }
    Ok(())
}

/// The field's value in SI, checked against what the column may hold.
fn parse_field(field: &str, column: &Column) -> Result<f64, Problem> {
    let (name, text) = (|| column.name.to_string(), || field.to_owned());
    let number: f64 = field.parse().map_err(|_| Problem::NotANumber { column: name(), text: text() })?;
    let value = number * column.factor;
    if !value.is_finite() {
        return Err(Problem::NotFinite { column: name(), text: text() });
    }
    let quantity = column.name.quantity;
    if !within(quantity, value) {
        return Err(Problem::OutOfBounds { column: name(), text: text(), bounds: bounds(quantity) });
    }
    match column.values.last() {
        Some(&previous) if quantity.name == "time" && value <= previous => {
            Err(Problem::TimeNotIncreasing { previous, time: value })
        }
        _ => Ok(value),
    }
}

pub(crate) fn within(quantity: &Quantity, value: f64) -> bool {
    let above = quantity.min.is_none_or(|min| if quantity.open { value > min } else { value >= min });
    let below = quantity.max.is_none_or(|max| if quantity.open { value < max } else { value <= max });
    above && below
}

pub(crate) fn bounds(quantity: &Quantity) -> String {
    let (lower, upper) = if quantity.open { ("above", "below") } else { ("at least", "at most") };
    let lower = quantity.min.map(|min| format!("{lower} {min}"));
    let upper = quantity.max.map(|max| format!("{upper} {max}"));
    [lower, upper].into_iter().flatten().collect::<Vec<_>>().join(" and ")
}

/// The bytes of the row's first line.
pub(crate) fn row_span(text: &str, row: &StringRecord) -> Range<usize> {
    let start = row.position().map_or(0, |position| usize::try_from(position.byte()).unwrap_or(0));
    let start = start.min(text.len());
    // The reader's position lies before the blank lines that it skips.
    let blank = text.as_bytes()[start..].iter().take_while(|byte| matches!(**byte, b'\n' | b'\r')).count();
    let start = start + blank;
    let length = text.as_bytes()[start..].iter().take_while(|byte| !matches!(**byte, b'\n' | b'\r')).count();
    start..start + length
}

/// The bytes of a field; of a row with quotes, the whole row.
pub(crate) fn field_span(text: &str, row: &StringRecord, index: usize) -> Range<usize> {
    let span = row_span(text, row);
    let Some(line) = text.get(span.clone()).filter(|line| !line.contains('"')) else { return span };
    let Some(field) = line.split(',').nth(index) else { return span };
    let start: usize = line.split(',').take(index).map(|field| field.len() + 1).sum();
    let indent = field.len() - field.trim_start().len();
    let start = span.start + start + indent;
    start..start + field.trim().len()
}
