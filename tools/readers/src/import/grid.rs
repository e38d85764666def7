//! From text to columns: separator, decimal sign, heading, units, rows.

use csv::{ReaderBuilder, StringRecord, Trim};

use super::raw::RawColumn;
use super::{Refusal, refuse};

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
    columns(rows_of(text, dialect), dialect, notes)
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
    let (mut rows, mut row) = (rows_of(text, dialect), StringRecord::new());
    while rows.read(&mut row) {
        let is_number = |field: &&str| number(field, dialect.decimal).is_some();
        let is_grouped = |field: &&str| grouped(field, dialect.decimal);
        let numbers = row.iter().filter(is_number).count();
        // Read in another dialect they may be plain numbers, which count more.
        let grouped = row.iter().filter(|field| !is_number(field) && is_grouped(field)).count();
        let words =
            row.iter().filter(|field| !is_number(field) && !is_grouped(field) && !is_gap(field)).count();
        if numbers + grouped >= 2 {
            *lengths.entry(row.len()).or_default() += (4 * numbers + 3 * grouped).saturating_sub(words);
        }
    }
    lengths.into_values().max().unwrap_or(0)
}

/// The rows of a text, one at a time.
enum Rows<'t> {
    /// Fields with separators, which may be quoted.
    Separated(Box<csv::Reader<&'t [u8]>>),
    /// Fields between any number of blanks.
    Blank(std::iter::Zip<std::str::Split<'t, [char; 2]>, std::ops::RangeFrom<u64>>),
}

fn rows_of(text: &str, dialect: Dialect) -> Rows<'_> {
    if dialect.separator == b' ' {
        return Rows::Blank(text.split(['\n', '\r']).zip(1..));
    }
    let mut reader = ReaderBuilder::new();
    reader.has_headers(false).flexible(true).trim(Trim::All).delimiter(dialect.separator);
    Rows::Separated(Box::new(reader.from_reader(text.as_bytes())))
}

impl Rows<'_> {
    /// Reads the next row into `row`; `false` at the end.
    fn read(&mut self, row: &mut StringRecord) -> bool {
        match self {
            // The text is UTF-8 and rows may be ragged: no row can fail.
            Self::Separated(reader) => reader.read_record(row).unwrap_or(false),
            Self::Blank(lines) => {
                let Some((line, at)) = lines.find(|(line, _)| !line.trim().is_empty()) else { return false };
                row.clear();
                line.split_whitespace().for_each(|field| row.push_field(field));
                let mut position = csv::Position::new();
                position.set_line(at);
                row.set_position(Some(position));
                true
            }
        }
    }
}

/// Rows up to the first of numbers that are kept while it is looked for.
const HEAD: usize = 10_000;

/// Rows of numbers of one length, one after the other, that are data: preambles hold numbers, too.
const RUN: usize = 3;

/// The rows up to the first [`RUN`] of numbers, or all, and the index of the first of numbers.
fn head(rows: &mut Rows, dialect: Dialect) -> Result<(Vec<StringRecord>, usize), Refusal> {
    let is_number =
        |field: &&str| number(field, dialect.decimal).is_some() || grouped(field, dialect.decimal);
    let numeric = |row: &StringRecord| row.iter().filter(is_number).count() >= 2;
    let (mut kept, mut row) = (Vec::<StringRecord>::new(), StringRecord::new());
    // Where the last rows of numbers of one length begin.
    let mut run = 0;
    while rows.read(&mut row) {
        let goes_on = kept.last().is_some_and(|last| numeric(last) && last.len() == row.len());
        run = if goes_on { run } else { kept.len() };
        kept.push(row.clone());
        if numeric(&row) && kept.len() - run >= RUN {
            let first = with_gaps(&kept, run, dialect);
            return Ok((kept, first));
        }
        if kept.len() > HEAD {
            let message = format!("no rows of numbers were found in the first {HEAD} lines");
            return Err(refuse(message, "export a table with one column per channel"));
        }
    }
    // A short table: its last rows of numbers.
    let Some(last) = kept.iter().rposition(numeric) else { return Ok((kept, 0)) };
    let before =
        kept[..last].iter().rev().take_while(|row| numeric(row) && row.len() == kept[last].len()).count();
    let first = with_gaps(&kept, last - before, dialect);
    Ok((kept, first))
}

/// Where the data begin that go on at row `first`: those before it may lack values, and hold no words.
fn with_gaps(rows: &[StringRecord], first: usize, dialect: Dialect) -> usize {
    let is_number = |field: &str| number(field, dialect.decimal).is_some() || grouped(field, dialect.decimal);
    let is_row = |row: &&StringRecord| {
        row.len() == rows[first].len()
            && row.iter().all(|field| is_number(field) || is_gap(field))
            && row.iter().any(is_number)
    };
    first - rows[..first].iter().rev().take_while(is_row).count()
}

fn columns(mut left: Rows, dialect: Dialect, notes: &mut Vec<String>) -> Result<Vec<RawColumn>, Refusal> {
    let (rows, first) = head(&mut left, dialect)?;
    let width = rows[first].len();
    let mut above = first;
    let mut names = None;
    let mut units: Option<Vec<String>> = None;
    while names.is_none() && above > 0 {
        above -= 1;
        let fields = heading_fields(&rows[above], dialect);
        let filled = fields.iter().filter(|field| !field.is_empty()).count();
        // `Rate: 2000 Hz` above every column names none of them.
        let all_alike = filled > 1 && filled == width && fields.windows(2).all(|pair| pair[0] == pair[1]);
        if filled < 2 && width > 1 || all_alike {
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
        let labelled =
            rows[..above].iter().map(|row| heading_fields(row, dialect)).find(|fields| is_labelled(fields));
        if let (None, Some(mut fields)) = (&units, labelled) {
            notes.push(format!("units were read from the line `{}`", fields[0]));
            fields[0].clear();
            units = Some(fields);
        }
        notes.push(format!("{above} lines above the names of the columns were not used"));
    }
    let mut columns = empty_columns(names, units.as_deref());
    fill(&rows[first..], left, dialect, &mut columns, notes)?;
    Ok(columns)
}

fn empty_columns(names: Vec<String>, units: Option<&[String]>) -> Vec<RawColumn> {
    let unit = |index: usize| {
        let unit = units.and_then(|units| units.get(index)).map(|unit| bare(unit).to_owned());
        unit.filter(|unit| !unit.is_empty())
    };
    names
        .into_iter()
        .enumerate()
        .map(|(index, heading)| RawColumn::new(&heading, unit(index), Vec::new()))
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

/// Whether a line above the heading gives units behind a label: `Y_Unit_Label  mm  N`.
fn is_labelled(fields: &[String]) -> bool {
    let [label, units @ ..] = fields else { return false };
    label.to_lowercase().contains("unit")
        && units.iter().any(|unit| !unit.is_empty())
        && units.iter().all(|unit| is_unit(unit))
}

/// The numbers of the rows at the `start`, and of all that are `left`.
fn fill(
    start: &[StringRecord],
    mut left: Rows,
    dialect: Dialect,
    columns: &mut [RawColumn],
    notes: &mut Vec<String>,
) -> Result<(), Refusal> {
    let mut skipped = 0;
    for row in start {
        skipped += usize::from(!fill_row(row, dialect, columns)?);
    }
    let mut row = StringRecord::new();
    while left.read(&mut row) {
        skipped += usize::from(!fill_row(&row, dialect, columns)?);
    }
    if skipped > 0 {
        notes.push(format!("{skipped} lines below the first row hold no number and were not used"));
    }
    Ok(())
}

/// `false` for a row without any number, which gives no values.
fn fill_row(row: &StringRecord, dialect: Dialect, columns: &mut [RawColumn]) -> Result<bool, Refusal> {
    let line = row.position().map_or(0, csv::Position::line);
    if !row.iter().any(|field| number(field, dialect.decimal).is_some()) {
        return names_anew(row, dialect, columns).map_or(Ok(false), |found| {
            let message = format!(
                "line {line} names the columns anew, and otherwise than the first heading: `{found}`"
            );
            Err(refuse(message, "split the file there: each part is a record with its own heading"))
        });
    }
    if row.iter().skip(columns.len()).any(|field| !field.is_empty()) {
        let message = format!("line {line} has {} fields, but the heading has {}", row.len(), columns.len());
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
                    let place = if grouped(field, dialect.decimal) {
                        &mut column.grouped
                    } else {
                        &mut column.first_word
                    };
                    place.get_or_insert_with(|| (field.to_owned(), line));
                    f64::NAN
                }
            },
        };
        column.values.push(value);
    }
    Ok(true)
}

/// The first field of a row that is another heading than that of `columns`.
fn names_anew(row: &StringRecord, dialect: Dialect, columns: &[RawColumn]) -> Option<String> {
    let fields = heading_fields(row, dialect);
    let other = |(field, column): (&String, &RawColumn)| {
        let named = *field != column.heading && super::heading::quantity_of(field).is_some();
        named.then(|| field.clone())
    };
    fields.iter().zip(columns).find_map(other)
}

/// Whether a field is a number with signs between its thousands: `1,058.5`, `1.058,5`, `1'058`.
fn grouped(field: &str, decimal: char) -> bool {
    let plain = field.trim_start_matches(['+', '-']);
    let (whole, fraction) = plain.split_once(decimal).unwrap_or((plain, ""));
    let sign = |letter: char| letter != decimal && ",.'\u{2019} \u{a0}\u{202f}".contains(letter);
    let mut groups = whole.split(sign);
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let first = groups.next().is_some_and(|first| (1..=3).contains(&first.len()) && digits(first));
    let mut rest = groups.peekable();
    first && rest.peek().is_some() && rest.all(|group| group.len() == 3 && digits(group)) && digits(fraction)
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
