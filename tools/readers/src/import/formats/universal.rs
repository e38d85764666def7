//! Universal files (UFF): functions at nodes, dataset 58, as text and in binary (58b), and the units of dataset 164.
//!
//! A dataset stands between two lines `    -1`; its first line is its number. A function has eleven lines of description, then
//! its values: those of the ordinate alone at equal steps, else pairs with the abscissa. Every time response is a series. A
//! function whose name is there already begins the next record.

use super::{Format, Series, unreadable};
use crate::import::Refusal;
use crate::import::heading::quantity_of;

pub(super) const FORMAT: Format = Format {
    name: "a universal file (UFF 58)",
    is,
    read,
    help: "write time responses (function type 1) with the data types of what was measured, or one CSV file of all channels: \
           in Python: `pyuff.UFF('…').read_sets()`",
};

/// Lines of description of a function.
const LINES: usize = 11;
/// What the specific data types of the format are called here.
const TYPES: [(u32, &str, &str); 7] = [
    (8, "displacement", "m"),
    (9, "force", "N"),
    (11, "velocity", "m/s"),
    (12, "acceleration", "m/s^2"),
    (13, "excitation", "N"),
    (17, "time", "s"),
    (18, "frequency", "Hz"),
];
/// Types of functions, for messages.
const FUNCTIONS: [&str; 13] = [
    "a general function",
    "a time response",
    "an auto spectrum",
    "a cross spectrum",
    "a frequency response function",
    "a transmissibility",
    "a coherence",
    "an auto correlation",
    "a cross correlation",
    "a power spectral density",
    "an energy spectral density",
    "a probability density",
    "a spectrum",
];

fn is(head: &[u8]) -> bool {
    let mut lines = head.split(|byte| *byte == b'\n').map(|line| line.trim_ascii());
    lines.next() == Some(b"-1")
        && lines.next().is_some_and(|line| line.first().is_some_and(u8::is_ascii_digit))
}

fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    let failed = |reason: String| unreadable(&FORMAT, reason);
    let (mut rest, mut si) = (Lines { bytes, at: 0, number: 0 }, false);
    let (mut series, mut record, mut number) = (Vec::<Series>::new(), 1_usize, 0);
    while let Some(line) = rest.next() {
        if line.trim() != "-1" {
            continue;
        }
        let Some(kind) = rest.next() else { break };
        match kind.split_whitespace().next() {
            Some("164") => {
                si = rest.next().is_some_and(|units| units.get(..10).is_some_and(|code| code.trim() == "1"))
            }
            Some("58" | "58b") => {
                number += 1;
                let function = function(&kind, &mut rest)
                    .map_err(|reason| failed(format!("function {number}: {reason}")))?;
                let even = function.even.is_some();
                match function.series(si) {
                    Ok(mut one) => {
                        if let (false, Some([_, step])) = (even, one.times) {
                            notes.push(format!(
                                "the time stamps of `{}` are taken for equal steps of {step} s",
                                one.name
                            ));
                        }
                        let taken = |one: &Series, record: usize| {
                            series.iter().any(|other| other.group == group(record) && other.name == one.name)
                        };
                        record += usize::from(taken(&one, record));
                        one.group = group(record);
                        series.push(one);
                    }
                    Err(reason) => notes.push(format!("function {number} was not used: {reason}")),
                }
            }
            // Everything else ends where the next mark stands.
            _ => {}
        }
        while rest.peek().is_some_and(|line| line.trim() != "-1") {
            rest.next();
        }
        rest.next();
    }
    if series.is_empty() {
        let reason = notes.pop().unwrap_or_else(|| "it holds no function (dataset 58)".to_owned());
        return Err(failed(reason));
    }
    if record == 1 {
        series.iter_mut().for_each(|one| one.group.clear());
    }
    Ok(series)
}

fn group(record: usize) -> String {
    record.to_string()
}

/// Lines of a file that may hold binary stretches.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
}

impl Lines<'_> {
    fn peek(&self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        Some(String::from_utf8_lossy(&rest[..end]).trim_end_matches('\r').to_owned())
    }
}

impl Iterator for Lines<'_> {
    type Item = String;

    fn next(&mut self) -> Option<String> {
        let line = self.peek()?;
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| end + 1);
        self.number += 1;
        Some(line)
    }
}

/// A function as it stands in the file.
struct Function {
    id: String,
    kind: usize,
    node: i64,
    direction: i64,
    complex: bool,
    /// Minimum and increment of an even abscissa.
    even: Option<[f64; 2]>,
    abscissa: u32,
    ordinate: u32,
    label: String,
    unit: String,
    /// Values, or pairs of abscissa and value.
    values: Vec<f64>,
}

fn function(kind: &str, rest: &mut Lines) -> Result<Function, String> {
    let mut lines = Vec::with_capacity(LINES);
    for _ in 0..LINES {
        lines.push(rest.next().ok_or("the file ends in its description")?);
    }
    let cut = |line: usize, from: usize, to: usize| -> &str {
        let text = lines[line].as_str();
        let to = to.min(text.len());
        text.get(from.min(to)..to).unwrap_or("").trim()
    };
    let integer = |line, from, to| cut(line, from, to).parse::<i64>().unwrap_or(0);
    let float =
        |line, from, to| cut(line, from, to).replace(['D', 'd'], "e").parse::<f64>().unwrap_or(f64::NAN);
    let data = integer(6, 0, 10);
    let count = usize::try_from(integer(6, 10, 20)).map_err(|_| "its number of values is below zero")?;
    let even = (integer(6, 20, 30) == 1).then(|| [float(6, 30, 43), float(6, 43, 56)]);
    if even.is_some_and(|[start, step]| !(start.is_finite() && step > 0.0)) {
        return Err(format!("the step of its abscissa is `{}`", cut(6, 43, 56)));
    }
    let complex = data == 5 || data == 6;
    let parts = (1 + usize::from(complex)) + usize::from(even.is_none());
    let total = count
        .checked_mul(parts)
        .filter(|total| *total <= rest.bytes.len())
        .ok_or("it has more values than the file")?;
    let values = match kind.trim_start().starts_with("58b") {
        true => binary(kind, rest, total, parts, even.is_none())?,
        false => text(rest, total)?,
    };
    Ok(Function {
        id: cut(0, 0, 80).to_owned(),
        kind: usize::try_from(integer(5, 0, 5)).unwrap_or(usize::MAX),
        node: integer(5, 41, 51),
        direction: integer(5, 51, 55),
        complex,
        even,
        abscissa: u32::try_from(integer(7, 0, 10)).unwrap_or(0),
        ordinate: u32::try_from(integer(8, 0, 10)).unwrap_or(0),
        label: cut(8, 26, 46).to_owned(),
        unit: cut(8, 47, 67).to_owned(),
        values,
    })
}

/// Numbers in columns that may touch: `1.0E+00-2.0E+00`.
fn text(rest: &mut Lines, total: usize) -> Result<Vec<f64>, String> {
    let mut values = Vec::with_capacity(total);
    while values.len() < total {
        let at = rest.number + 1;
        let line = rest.next().ok_or("the file ends in its values")?;
        for word in line.split_whitespace() {
            let mut start = 0;
            for (place, pair) in word.as_bytes().windows(2).enumerate() {
                if matches!(pair[1], b'+' | b'-') && !matches!(pair[0], b'e' | b'E' | b'd' | b'D') {
                    values.push(number(&word[start..=place], at)?);
                    start = place + 1;
                }
            }
            values.push(number(&word[start..], at)?);
        }
    }
    values.truncate(total);
    Ok(values)
}

fn number(word: &str, line: usize) -> Result<f64, String> {
    word.replace(['D', 'd'], "e").parse().map_err(|_| format!("`{word}` in line {line} is no number"))
}

/// Which sizes the numbers have shows where the mark of the end stands: programs differ in what they write.
fn binary(
    kind: &str,
    rest: &mut Lines,
    total: usize,
    parts: usize,
    uneven: bool,
) -> Result<Vec<f64>, String> {
    let word = |at: usize| kind.split_whitespace().nth(at).and_then(|word| word.parse::<u32>().ok());
    let little = match (word(1), word(2)) {
        (Some(order), Some(2)) => order != 2,
        (_, format) => return Err(format!("its numbers are of format {}, not IEEE", format.unwrap_or(0))),
    };
    let bytes = &rest.bytes[rest.at..];
    let sizes = [[8, 8], [4, 8], [4, 4]].into_iter().filter(|[first, other]| uneven || first == other);
    for [first, other] in sizes {
        let group = if uneven { first + other * (parts - 1) } else { other * parts };
        let length = total / parts * group;
        let after = bytes.get(length..).unwrap_or_default();
        let mark: Vec<u8> =
            after.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).take(2).collect();
        if length > bytes.len() || mark != b"-1" && !after.is_empty() {
            continue;
        }
        rest.at += length;
        let mut values = Vec::with_capacity(total);
        let mut at = 0;
        for index in 0..total {
            let size = if uneven && index % parts == 0 { first } else { other };
            values.push(float(&bytes[at..at + size], little));
            at += size;
        }
        return Ok(values);
    }
    Err("its values do not end where the file says".to_owned())
}

fn float(bytes: &[u8], little: bool) -> f64 {
    match (<[u8; 8]>::try_from(bytes), <[u8; 4]>::try_from(bytes)) {
        (Ok(eight), _) => {
            if little {
                f64::from_le_bytes(eight)
            } else {
                f64::from_be_bytes(eight)
            }
        }
        (_, Ok(four)) => f64::from(if little { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) }),
        _ => f64::NAN,
    }
}

impl Function {
    /// The series, or why it is none.
    fn series(self, si: bool) -> Result<Series, String> {
        let what = FUNCTIONS.get(self.kind).copied().unwrap_or("a function of another kind");
        if self.kind > 1 || self.complex || ![0, 1, 17].contains(&self.abscissa) {
            return Err(format!("it is {what}, and only time responses are read"));
        }
        let known = TYPES.iter().find(|(code, ..)| *code == self.ordinate);
        let stated = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty() && text != "NONE");
        // The name that says what it is; else what the data type says, with its place in the mesh.
        let spoken = [&self.label, &self.id].into_iter().find(|name| quantity_of(name).is_some()).cloned();
        let typed = known.map(|(_, name, _)| match self.node {
            0 => (*name).to_owned(),
            node => format!("{name} {node}{}", direction(self.direction)),
        });
        let name = spoken.or(typed).or_else(|| stated(&self.label)).or_else(|| stated(&self.id));
        let name = name.unwrap_or_else(|| format!("function {}{}", self.node, direction(self.direction)));
        let unit = stated(&self.unit).or_else(|| known.filter(|_| si).map(|(.., unit)| (*unit).to_owned()));
        let times = match self.even {
            Some(even) => even,
            None => return self.uneven(name, unit),
        };
        Ok(Series { unit, times: Some(times), ..Series::new("", &name, self.values) })
    }

    /// Pairs: equal steps are made of the stamps where they are equal up to their digits.
    fn uneven(self, name: String, unit: Option<String>) -> Result<Series, String> {
        let (stamps, values): (Vec<f64>, Vec<f64>) =
            self.values.chunks_exact(2).map(|pair| (pair[0], pair[1])).unzip();
        let (Some(first), Some(last)) = (stamps.first(), stamps.last()) else {
            return Err("it is empty".to_owned());
        };
        let step = (last - first) / (stamps.len().max(2) - 1) as f64;
        let largest = stamps.iter().fold(0.0_f64, |top, stamp| top.max(stamp.abs()));
        // Abscissae are written with six digits.
        let apart =
            |(index, stamp): (usize, &f64)| (first + index as f64 * step - stamp).abs() > 1e-5 * largest;
        if step.is_nan() || step <= 0.0 || stamps.iter().enumerate().any(apart) {
            return Err("its time stamps are not equally spaced: write it with an even abscissa, or as CSV"
                .to_owned());
        }
        Ok(Series { unit, times: Some([*first, step]), ..Series::new("", &name, values) })
    }
}

fn direction(code: i64) -> String {
    let axis = ["", "X", "Y", "Z", "RX", "RY", "RZ"]
        .get(usize::try_from(code.abs()).unwrap_or(0))
        .copied()
        .unwrap_or("");
    let sign = if code < 0 { "-" } else { "+" };
    if axis.is_empty() { String::new() } else { format!("{sign}{axis}") }
}
