//! From text to columns: separator, decimal sign, heading, units, rows.

use csv::{ReaderBuilder, StringRecord, Trim};

use super::{Refusal, refuse};

/// A column as it stands in the file; what is no number is NaN.
pub(super) struct RawColumn {
    pub(super) heading: String,
    /// What stands below the heading, in a row of units.
    pub(super) unit: Option<String>,
    pub(super) values: Vec<f64>,
    /// Cells that hold words, and the first of them with its line.
    pub(super) words: usize,
    pub(super) first_word: Option<(String, u64)>,
    /// Cells of the form 12:30:00.5, read as seconds of the day.
    pub(super) clock: bool,
}

#[derive(Clone, Copy, PartialEq)]
struct Dialect {
    /// A space stands for any number of blanks.
    separator: u8,
    decimal: char,
}

/// Separators that are tried; of equal success the first is taken.
const DIALECTS: [Dialect; 8] = [
    Dialect { separator: b',', decimal: '.' },
    Dialect { separator: b';', decimal: '.' },
    Dialect { separator: b';', decimal: ',' },
    Dialect { separator: b'\t', decimal: '.' },
    Dialect { separator: b'\t', decimal: ',' },
    Dialect { separator: b',', decimal: ',' },
    Dialect { separator: b' ', decimal: '.' },
    Dialect { separator: b' ', decimal: ',' },
];

/// The dialect is found in so many bytes of the text.
const LOOKED_AT: usize = 64 * 1024;

pub(super) fn read(text: &str, notes: &mut Vec<String>) -> Result<Vec<RawColumn>, Refusal> {
    let start = text.get(..text.floor_char_boundary(LOOKED_AT)).unwrap_or(text);
    let mut best = (0, DIALECTS[0]);
    for dialect in DIALECTS {
        let numbers = numbers_in(start, dialect);
        if numbers > best.0 {
            best = (numbers, dialect);
        }
    }
    let (numbers, dialect) = best;
    if numbers == 0 {
        return Err(refuse(
            "no two columns of numbers were found",
            "export a table with one column per channel, separated by commas, semicolons or tabs, \
             decimals with a point or a comma and no sign between thousands",
        ));
    }
    tell_dialect(dialect, notes);
    let rows = rows_of(text, dialect);
    columns(&rows, dialect, notes)
}

fn tell_dialect(dialect: Dialect, notes: &mut Vec<String>) {
    let separator = match dialect.separator {
        b';' => "semicolons",
        b'\t' => "tabs",
        b' ' => "blanks",
        _ => "commas",
    };
    if dialect.separator != b',' || dialect.decimal == ',' {
        let decimal = if dialect.decimal == ',' { "a decimal comma" } else { "a decimal point" };
        notes.push(format!("columns are separated by {separator}, numbers are written with {decimal}"));
    }
}

/// How well the rows of the most frequent length can be read in this dialect: numbers count, and words a little against.
/// (`1,5;2,5` holds two numbers between commas, too, but then also a word, `5;2`.)
fn numbers_in(text: &str, dialect: Dialect) -> usize {
    let mut lengths = std::collections::BTreeMap::<usize, usize>::new();
    for row in rows_of(text, dialect) {
        let is_number = |field: &&str| number(field, dialect.decimal).is_some();
        let numbers = row.iter().filter(is_number).count();
        let words = row.iter().filter(|field| !is_number(field) && !is_gap(field)).count();
        if numbers >= 2 {
            *lengths.entry(row.len()).or_default() += (4 * numbers).saturating_sub(words);
        }
    }
    lengths.into_values().max().unwrap_or(0)
}

fn rows_of(text: &str, dialect: Dialect) -> Vec<StringRecord> {
    if dialect.separator == b' ' {
        return text
            .split(['\n', '\r'])
            .zip(1u64..)
            .filter(|(line, _)| !line.trim().is_empty())
            .map(|(line, at)| {
                let mut row: StringRecord = line.split_whitespace().collect::<Vec<_>>().into();
                let mut position = csv::Position::new();
                position.set_line(at);
                row.set_position(Some(position));
                row
            })
            .collect();
    }
    let mut reader = ReaderBuilder::new();
    reader.has_headers(false).flexible(true).trim(Trim::All).delimiter(dialect.separator);
    // The text is UTF-8 and rows may be ragged: no row can fail.
    reader.from_reader(text.as_bytes()).records().map_while(Result::ok).collect()
}

fn columns(
    rows: &[StringRecord],
    dialect: Dialect,
    notes: &mut Vec<String>,
) -> Result<Vec<RawColumn>, Refusal> {
    let numeric =
        |row: &StringRecord| row.iter().filter(|field| number(field, dialect.decimal).is_some()).count() >= 2;
    // Preambles hold numbers, too: the data begin where two rows of one length follow each other, or with the last row.
    let first = (0..rows.len())
        .find(|&at| {
            numeric(&rows[at])
                && rows.get(at + 1).is_none_or(|next| numeric(next) && next.len() == rows[at].len())
        })
        .or_else(|| rows.iter().rposition(numeric))
        .unwrap_or(0);
    let width = rows[first].len();
    let mut above = first;
    let mut names = None;
    let mut units: Option<Vec<String>> = None;
    while names.is_none() && above > 0 {
        above -= 1;
        let fields = heading_fields(&rows[above], dialect);
        if fields.iter().filter(|field| !field.is_empty()).count() < 2 && width > 1 {
            continue;
        }
        if units.is_none()
            && fields.iter().any(|field| !field.is_empty())
            && fields.iter().all(|field| is_unit(field))
        {
            units = Some(fields);
        } else {
            names = Some(fields);
        }
    }
    let names = names.ok_or_else(|| {
        refuse(
            "no line names the columns",
            "write a first line such as `time [s],displacement [mm],force [N]`",
        )
    })?;
    if names.len() < width && rows[first].iter().skip(names.len()).any(|field| !field.is_empty()) {
        let message = format!("the rows have {width} fields, but the heading has {}", names.len());
        let help = "name every column once; where decimals are written with a comma, separate columns by semicolons or tabs";
        return Err(refuse(message, help));
    }
    if above > 0 {
        notes.push(format!("{above} lines above the names of the columns were not used"));
    }
    let mut columns = empty_columns(names, units.as_deref(), rows.len() - first);
    fill(&rows[first..], dialect, &mut columns, notes)?;
    Ok(columns)
}

fn empty_columns(names: Vec<String>, units: Option<&[String]>, rows: usize) -> Vec<RawColumn> {
    names
        .into_iter()
        .enumerate()
        .map(|(index, heading)| RawColumn {
            heading,
            unit: units
                .and_then(|units| units.get(index))
                .map(|unit| bare(unit).to_owned())
                .filter(|unit| !unit.is_empty()),
            values: Vec::with_capacity(rows),
            words: 0,
            first_word: None,
            clock: false,
        })
        .collect()
}

/// The names of a heading; signs of a comment before them are none.
fn heading_fields(row: &StringRecord, dialect: Dialect) -> Vec<String> {
    let mut fields: Vec<String> = row.iter().map(str::to_owned).collect();
    if let Some(first) = fields.first_mut() {
        *first = first.trim_start_matches(['#', '%', '/', '!']).trim().to_owned();
        if first.is_empty() && dialect.separator == b' ' {
            fields.remove(0);
        }
    }
    // With blanks between columns, `time [s]` is two words.
    if dialect.separator == b' ' {
        let mut joined: Vec<String> = Vec::new();
        for field in fields {
            match joined.last_mut() {
                Some(last) if field.starts_with(['[', '(']) && !last.ends_with([']', ')']) => {
                    *last += &format!(" {field}")
                }
                _ => joined.push(field),
            }
        }
        return joined;
    }
    while fields.last().is_some_and(String::is_empty) {
        fields.pop();
    }
    fields
}

/// A unit without its brackets.
pub(super) fn bare(unit: &str) -> &str {
    unit.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim()
}

/// Whether a field below the heading can be a unit, or nothing.
fn is_unit(field: &str) -> bool {
    let unit = bare(field);
    // One letter is a name as often as a unit: a heading `t;x;F` is none of units.
    field.is_empty() || stickslip::data::unit_size(&super::heading::unit_spelling(unit)).is_some()
}

fn fill(
    rows: &[StringRecord],
    dialect: Dialect,
    columns: &mut [RawColumn],
    notes: &mut Vec<String>,
) -> Result<(), Refusal> {
    let mut skipped = 0;
    for row in rows {
        let line = row.position().map_or(0, csv::Position::line);
        if !row.iter().any(|field| number(field, dialect.decimal).is_some()) {
            skipped += 1;
            continue;
        }
        if row.iter().skip(columns.len()).any(|field| !field.is_empty()) {
            let message =
                format!("line {line} has {} fields, but the heading has {}", row.len(), columns.len());
            return Err(refuse(message, "every row needs one field per column; export the file again"));
        }
        for (index, column) in columns.iter_mut().enumerate() {
            let field = row.get(index).unwrap_or("");
            let value = match number(field, dialect.decimal) {
                Some(value) => value,
                None if is_gap(field) => f64::NAN,
                None => match clock(field, dialect.decimal) {
                    Some(seconds) => {
                        column.clock = true;
                        seconds
                    }
                    None => {
                        column.words += 1;
                        column.first_word.get_or_insert_with(|| (field.to_owned(), line));
                        f64::NAN
                    }
                },
            };
            column.values.push(value);
        }
    }
    if skipped > 0 {
        notes.push(format!("{skipped} lines below the first row hold no number and were not used"));
    }
    Ok(())
}

/// A finite number; the exponent may be Fortran's D.
fn number(field: &str, decimal: char) -> Option<f64> {
    if !field.starts_with(|sign: char| sign.is_ascii_digit() || "+-.,".contains(sign)) {
        return None;
    }
    let plain = field.parse().ok().filter(|_| decimal == '.');
    let written = || {
        if decimal == ',' && field.contains('.') {
            return None;
        }
        field.replace(decimal, ".").replace(['D', 'd'], "e").parse().ok()
    };
    plain.or_else(written).filter(|value: &f64| value.is_finite())
}

/// What programs write where there is no value.
fn is_gap(field: &str) -> bool {
    const GAPS: [&str; 10] = ["", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "inf"];
    let lower = field.to_ascii_lowercase();
    GAPS.contains(&lower.trim_start_matches(['+', '-'])) || GAPS.contains(&lower.as_str())
}

/// Seconds of the day of `12:30:00.5`, with or without a date before it.
fn clock(field: &str, decimal: char) -> Option<f64> {
    let time = field.rsplit([' ', 'T']).next()?.trim_end_matches('Z');
    let parts: Vec<&str> = time.split(':').collect();
    let [hours, minutes, seconds] = parts[..] else { return None };
    Some(3600.0 * number(hours, decimal)? + 60.0 * number(minutes, decimal)? + number(seconds, decimal)?)
}
