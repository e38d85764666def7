//! A comparison as text for a terminal.

use stickslip::diagnose::{Comparison, Noise};
use stickslip::fit::ring_down::RingDown;

use crate::comparison::floors;
use crate::comparison::summary::{self, Levels, Summary};
use crate::explorer::Harmonics;
use crate::format::{self, Scale, printable};
use crate::plots::{error_name, prose};
use crate::tables;

pub(crate) const BOLD: &str = "\u{1b}[1m";
pub(crate) const RED: &str = "\u{1b}[31m";
const BLUE: &str = "\u{1b}[34m";
const YELLOW: &str = "\u{1b}[33m";
const RESET: &str = "\u{1b}[0m";

/// The comparison as a table of stages with bars, then the error at every level of a backbone and in
/// every record; where the stages do not fit side by side the table continues below.
///
/// Lines are at most `width` columns wide (at least 40 are used; 80 is usual). With `color`, ANSI
/// sequences are added, which take no columns; without it the text has none, and control characters
/// in names never reach the terminal.
pub fn terminal_table(comparison: &Comparison, noise: &[Noise], width: usize, color: bool) -> String {
    let summary = summary::summarise(comparison);
    let levels = summary::levels(comparison);
    let mut out = Text::new(width, color);
    out.paragraph(&comparison.title, BOLD);
    out.paragraph(&floors::with_noise(&summary.verdict, comparison, &summary, noise), "");
    for note in &summary.notes {
        out.paragraph(note, RED);
    }
    stages(&mut out, comparison, &summary);
    fitted(&mut out, comparison);
    steps(&mut out, comparison);
    comparison.ring_downs.iter().for_each(|one| ring_down(&mut out, one));
    for table in &levels {
        level_table(&mut out, comparison, table);
    }
    if comparison.records.len() > 1 || levels.is_empty() {
        record_table(&mut out, comparison, noise);
    }
    failures(&mut out, comparison);
    out.finish()
}

/// Text under construction.
pub(crate) struct Text {
    text: String,
    width: usize,
    color: bool,
}

impl Text {
    /// Lines will be at most `width` columns wide; at least 40 are used.
    pub fn new(width: usize, color: bool) -> Self {
        Self { text: String::new(), width: width.max(40), color }
    }

    pub fn finish(self) -> String {
        self.text
    }

    pub fn line(&mut self, line: &str) {
        self.text.push_str(line.trim_end());
        self.text.push('\n');
    }

    fn painted(&self, text: &str, paint: &str) -> String {
        if self.color && !paint.is_empty() { format!("{paint}{text}{RESET}") } else { text.to_owned() }
    }

    /// `text` broken at spaces; a longer word is broken where the line ends.
    pub fn paragraph(&mut self, text: &str, paint: &str) {
        self.wrapped(text, paint, "");
    }

    /// As [`Text::paragraph`], four columns to the right.
    pub fn indented(&mut self, text: &str) {
        self.wrapped(text, "", "    ");
    }

    fn wrapped(&mut self, text: &str, paint: &str, indent: &str) {
        let width = self.width - indent.len();
        let mut line = String::new();
        for word in printable(text).split(' ').filter(|word| !word.is_empty()) {
            if !line.is_empty() && columns(&line) + 1 + columns(word) > width {
                self.line(&format!("{indent}{}", self.painted(&line, paint)));
                line.clear();
            }
            if !line.is_empty() {
                line.push(' ');
            }
            for c in word.chars() {
                if columns(&line) + char_columns(c) > width {
                    self.line(&format!("{indent}{}", self.painted(&line, paint)));
                    line.clear();
                }
                line.push(c);
            }
        }
        self.line(&format!("{indent}{}", self.painted(&line, paint)));
    }

    /// A table of right-aligned cells under a left column, broken into parts as wide as the terminal.
    /// `left` and every row of `cells` begin with the heading; the first `fixed` columns are repeated.
    pub fn grid(&mut self, left: &[String], cells: &[Vec<String>], fixed: usize) {
        let wide = |column: usize| cells.iter().map(|row| columns(&row[column])).max().unwrap_or(0) + 2;
        let count = cells.first().map_or(0, Vec::len);
        let repeated: usize = (0..fixed).map(wide).sum();
        let left_width = left.iter().map(|cell| columns(cell)).max().unwrap_or(0);
        let widest = (fixed..count).map(wide).max().unwrap_or(0).max(12);
        let left_width = left_width.min(self.width.saturating_sub(repeated + widest).max(10));
        let mut start = fixed;
        while start < count {
            let mut end = start;
            let mut used = left_width + repeated;
            while end < count && (end == start || used + wide(end) <= self.width) {
                used += wide(end);
                end += 1;
            }
            for (row, (left, cells)) in left.iter().zip(cells).enumerate() {
                let mut line = pad(left, left_width, false);
                for column in (0..fixed).chain(start..end) {
                    let cell = pad(&cells[column], wide(column), true);
                    let paint = if cells[column] == FAILED { RED } else { "" };
                    line.push_str(&self.painted(&cell, paint));
                }
                let paint = if row == 0 { BOLD } else { "" };
                self.line(&self.painted(line.trim_end(), paint));
            }
            start = end;
            if start < count {
                self.line("");
            }
        }
    }
}

const FAILED: &str = "failed";

/// What a fit made of each parameter.
pub(crate) fn fitted(out: &mut Text, comparison: &Comparison) {
    if let Some((heading, lines)) = crate::comparison::fitted::sentences(comparison) {
        out.line("");
        out.paragraph(&heading, BOLD);
        lines.iter().for_each(|line| out.paragraph(line, ""));
    }
}

/// What each step rests on, where the values are few.
fn steps(out: &mut Text, comparison: &Comparison) {
    let steps = comparison.steps();
    if steps.is_empty() {
        return;
    }
    out.line("");
    out.paragraph("Steps: what each gains, and the probability that chance explains the gain", BOLD);
    for step in steps {
        let [from, to] = step.stages.map(|index| comparison.stages[index].name.as_str());
        out.paragraph(&format!("{from} → {to}: {}", step.words), "");
    }
}

fn stages(out: &mut Text, comparison: &Comparison, summary: &Summary) {
    if comparison.stages.is_empty() {
        return;
    }
    let (errors, scale, what) = (&summary.errors, &summary.scale, error_name(summary));
    out.line("");
    out.paragraph(&format!("Stages: {}", scale.label(&what)), BOLD);
    let count = comparison.stages.len();
    let numbers: Vec<String> = errors.iter().map(|&error| scale.number(error)).collect();
    let number_width = numbers.iter().map(|number| columns(number)).max().unwrap_or(0);
    let index_width = count.to_string().len();
    let longest = comparison.stages.iter().map(|stage| columns(&printable(&stage.name))).max().unwrap_or(0);
    let name_width = longest.min(out.width / 2 - 4);
    let bar_width = out.width.saturating_sub(index_width + name_width + number_width + 6).min(50);
    let top = errors.iter().copied().filter(|error| error.is_finite()).fold(0.0, f64::max);
    for (index, stage) in comparison.stages.iter().enumerate() {
        let last = index + 1 == count;
        let fraction = if top > 0.0 && errors[index].is_finite() { errors[index] / top } else { 0.0 };
        let paint = if last {
            BLUE
        } else if index == 0 {
            YELLOW
        } else {
            ""
        };
        let name = pad(&printable(&stage.name), name_width, false);
        let line = format!(
            "{}  {}  {}  {}",
            pad(&(index + 1).to_string(), index_width, true),
            out.painted(&name, if last { BOLD } else { "" }),
            out.painted(&pad(&numbers[index], number_width, true), if last { BOLD } else { "" }),
            out.painted(&bar(fraction, bar_width), paint),
        );
        out.line(&line);
    }
}

/// A bar of `fraction` of `width` columns, in steps of an eighth of a column.
fn bar(fraction: f64, width: usize) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (fraction.clamp(0.0, 1.0) * 8.0 * width as f64).round() as usize;
    // Something is left of the error, however little: an empty bar would say there is none.
    let eighths = if fraction > 0.0 { eighths.max(1) } else { eighths };
    format!("{}{}", "█".repeat(eighths / 8), EIGHTHS[eighths % 8])
}

/// The levels that a free decay was cut into.
fn ring_down(out: &mut Text, ring_down: &RingDown) {
    let (heading, header, rows) = crate::comparison::ring_down::table(ring_down);
    out.line("");
    out.paragraph(&heading, BOLD);
    let mut left = vec![header[0].clone()];
    let mut cells = vec![header[1..].to_vec()];
    for row in rows {
        left.push(row[0].clone());
        cells.push(row[1..].to_vec());
    }
    out.grid(&left, &cells, 0);
}

fn level_table(out: &mut Text, comparison: &Comparison, levels: &Levels) {
    let count = comparison.stages.len();
    let amplitude = Scale::of(levels.amplitude.iter().copied(), levels.amplitude_unit);
    let value = Scale::of(levels.measured.iter().copied(), levels.unit);
    let value = Scale { decimals: value.decimals.max(2), ..value };
    let residual = levels.residual_scale();
    out.line("");
    let record = &comparison.records[levels.record].name;
    let heading = residual.label(&prose(&levels.channel));
    out.paragraph(&format!("{record}: predicted minus measured {heading}, by stage"), BOLD);
    let mut left = vec![amplitude.label(levels.over)];
    let mut first = vec![value.label("measured")];
    first.extend((1..=count).map(|stage| stage.to_string()));
    let mut cells = vec![first];
    for level in 0..levels.amplitude.len() {
        let shown = format::engineering(levels.amplitude[level] * amplitude.factor, "1");
        left.push(pad(&shown, columns(&left[0]), true));
        let mut row = vec![value.number(levels.measured[level])];
        row.extend((0..count).map(|stage| residual.signed(levels.residual(stage, level))));
        cells.push(row);
    }
    out.grid(&left, &cells, 1);
}

fn record_table(out: &mut Text, comparison: &Comparison, noise: &[Noise]) {
    if comparison.records.is_empty() || comparison.stages.is_empty() {
        return;
    }
    out.line("");
    out.paragraph(
        "Normalised error in each record, by stage, and the error that noise alone would cause",
        BOLD,
    );
    let scale = summary::error_scale(comparison);
    let mut left = vec!["record".to_owned()];
    let stages = (1..=comparison.stages.len()).map(|stage| stage.to_string());
    let mut cells = vec![stages.chain(["noise".to_owned()]).collect::<Vec<_>>()];
    for (record, measured) in comparison.records.iter().enumerate() {
        left.push(printable(&measured.name));
        let row = comparison.stages.iter().map(|stage| match summary::failure(stage, record) {
            Some(_) => FAILED.to_owned(),
            None => scale.number(summary::record_error(stage, record)),
        });
        let floor = floors::of_record(comparison, noise, record);
        let floor = floor.map_or_else(|| "unknown".to_owned(), |floor| scale.number(floor));
        cells.push(row.chain([floor]).collect());
    }
    if comparison.records.len() > 1 {
        left.push("all".to_owned());
        let row = comparison.stages.iter().map(|stage| scale.number(stage.error));
        let floor = floors::total(comparison, noise);
        let floor = floor.map_or_else(|| "unknown".to_owned(), |floor| scale.number(floor));
        cells.push(row.chain([floor]).collect());
    }
    out.grid(&left, &cells, 0);
}

/// The residual of the last stage of every record that repeats, by harmonic, in lines of at most `width`
/// columns (at least 40 are used).
pub fn harmonic_text(comparison: &Comparison, width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    let all = tables::all_harmonics(comparison);
    let last = |one: &Harmonics| one.residuals.last().cloned().flatten().unwrap_or_default();
    let count = all.iter().map(|one| last(one).len()).max().unwrap_or(0);
    if count == 0 {
        out.line("");
        out.paragraph("No record repeats, so that there are no harmonics to tell apart.", "");
        return out.finish();
    }
    out.line("");
    out.paragraph("Normalised error of the last stage at the harmonics of each record's fundamental", BOLD);
    let mut left = vec!["record".to_owned()];
    let heading =
        (0..count).map(|harmonic| if harmonic == 0 { "mean".to_owned() } else { harmonic.to_string() });
    let mut cells = vec![["fundamental".to_owned()].into_iter().chain(heading).collect::<Vec<_>>()];
    let channels: Vec<&str> = all.iter().map(|one| one.channel.as_str()).collect();
    let several = channels.iter().any(|name| *name != channels[0]);
    for one in &all {
        let record = printable(&comparison.records[one.record].name);
        left.push(if several { format!("{record} {}", prose(&printable(&one.channel))) } else { record });
        let values = last(one);
        let value = |harmonic| values.get(harmonic).map_or(format::ABSENT.to_owned(), |v| format!("{v:.3}"));
        let fundamental =
            format::engineering(format!("{:.3e}", one.fundamental).parse().unwrap_or(f64::NAN), "Hz");
        cells.push([fundamental].into_iter().chain((0..count).map(value)).collect());
    }
    out.grid(&left, &cells, 1);
    out.finish()
}

fn failures(out: &mut Text, comparison: &Comparison) {
    let mut first = true;
    for stage in &comparison.stages {
        for (record, measured) in comparison.records.iter().enumerate() {
            if let Some(reason) = summary::failure(stage, record) {
                if first {
                    out.line("");
                    out.paragraph("No prediction", BOLD);
                }
                first = false;
                out.paragraph(&format!("{}, {}: {reason}", stage.name, measured.name), "");
            }
        }
    }
}

/// `text` cut or filled to `width` columns.
fn pad(text: &str, width: usize, right: bool) -> String {
    let mut shown = text.to_owned();
    if columns(text) > width {
        shown.clear();
        let mut used = 1;
        for c in text.chars() {
            used += char_columns(c);
            if used > width {
                break;
            }
            shown.push(c);
        }
        shown.push('…');
    }
    let fill = " ".repeat(width.saturating_sub(columns(&shown)));
    if right { fill + &shown } else { shown + &fill }
}

/// Columns that `text` takes in a terminal.
fn columns(text: &str) -> usize {
    text.chars().map(char_columns).sum()
}

/// Columns of one character: none for combining marks, two for East Asian wide ones and emoji.
fn char_columns(c: char) -> usize {
    match c as u32 {
        0x300..=0x36f | 0x200b..=0x200d | 0xfe00..=0xfe0f => 0,
        0x1100..=0x115f | 0x2e80..=0xa4cf | 0xac00..=0xd7a3 | 0xf900..=0xfaff | 0xfe30..=0xfe6f => 2,
        0xff00..=0xff60 | 0xffe0..=0xffe6 | 0x1f300..=0x1faff | 0x20000..=0x3fffd => 2,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_proportional_and_never_empty_for_an_error() {
        assert_eq!(bar(1.0, 10), "█".repeat(10));
        assert_eq!(bar(0.5, 10), "█".repeat(5));
        assert_eq!(bar(1e-9, 10), "▏");
        assert_eq!(bar(0.0, 10), "");
    }

    #[test]
    fn padding_counts_columns_and_not_bytes() {
        assert_eq!(pad("µm", 4, true), "  µm");
        assert_eq!(columns(&pad("摩擦 contact", 7, false)), 7);
        assert_eq!(pad("abcdef", 4, false), "abc…");
    }
}
