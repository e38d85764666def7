//! From columns to records: cut at gaps, and where time begins anew.

use std::ops::Range;

use stickslip::data::{Record, Regime};

use super::{ImportOptions, Refusal, refuse};
use crate::table::{Column, bounds, within};

/// A stretch between gaps with fewer rows is of no use.
const SHORTEST: usize = 16;

pub(super) fn cut(
    stem: &str,
    columns: Vec<Column>,
    options: &ImportOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<Record>, Refusal> {
    let regime = regime_of(&columns, options, notes)?;
    check_bounds(&columns)?;
    let rows = columns.first().map_or(0, |column| column.values.len());
    let complete = |row: usize| columns.iter().all(|column| column.values[row].is_finite());
    let time = columns.iter().find(|column| column.name.quantity.name == "time");
    let missing = (0..rows).filter(|row| !complete(*row)).count();
    if regime.is_table() || time.is_none() {
        if missing > 0 {
            notes.push(format!("{missing} rows of the table lack a value and were left out"));
        }
        let kept: Vec<usize> = (0..rows).filter(|row| complete(*row)).collect();
        return record(stem, columns, regime, &kept).map(|record| vec![record]);
    }
    let times = time.map_or(&[][..], |time| &time.values);
    let all = stretches(rows, complete, times)?;
    let longest = all.iter().map(Range::len).max().unwrap_or(0);
    let useful: Vec<Range<usize>> =
        all.iter().filter(|rows| rows.len() >= SHORTEST.min(longest)).cloned().collect();
    if missing > 0 {
        notes.push(format!("{missing} rows lack a value: the record was cut there, nothing was filled in"));
    }
    if useful.len() > 1 {
        notes.push(format!("the file gives {} records", useful.len()));
    }
    let short: usize =
        all.iter().map(Range::len).sum::<usize>() - useful.iter().map(Range::len).sum::<usize>();
    if short > 0 {
        notes.push(format!("{short} rows lie in stretches of fewer than {SHORTEST} and were left out"));
    }
    let several = useful.len() > 1;
    let named = useful.into_iter().zip(1..).map(|(rows, number)| {
        let name = if several { format!("{stem}-{number}") } else { stem.to_owned() };
        let part = columns.iter().map(|column| Column {
            name: column.name.clone(),
            factor: 1.0,
            values: column.values.clone(),
        });
        record(&name, part.collect(), regime, &rows.collect::<Vec<_>>())
    });
    let mut records = named.collect::<Result<Vec<_>, _>>()?;
    let factor = time.map_or(1.0, |time| time.factor);
    let rates: Vec<f64> = records.iter_mut().filter_map(|record| evened(record, factor)).collect();
    if let (Some(rate), count) = (rates.first(), rates.len()) {
        let of = if count > 1 { format!(" of {count} records") } else { String::new() };
        notes.push(format!(
            "the time stamps{of} are rounded to a large part of the step: they were taken for even, {rate:.6} samples a second"
        ));
    }
    if records.is_empty() {
        return Err(refuse(
            "no row has a value in every used column",
            "export the channels on one time base",
        ));
    }
    Ok(records)
}

/// Runs of complete rows in which time goes on.
fn stretches(
    rows: usize,
    complete: impl Fn(usize) -> bool,
    times: &[f64],
) -> Result<Vec<Range<usize>>, Refusal> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for row in (0..rows).filter(|row| complete(*row)) {
        match all.last_mut() {
            Some(last) if last.end == row && times[row] > times[row - 1] => last.end = row + 1,
            // Less than half of what it was: another record begins. Everything else is a fault of the stamps.
            Some(last)
                if last.end == row
                    && (times[row] == times[row - 1]
                        || last.len() == 1
                        || times[row] - times[last.start] > 0.5 * (times[row - 1] - times[last.start])) =>
            {
                let message = format!("time does not increase: {} s after {} s", times[row], times[row - 1]);
                return Err(refuse(message, "export the time stamps with more digits, and rows in order"));
            }
            _ => all.push(row..row + 1),
        }
    }
    Ok(all)
}

/// Makes time stamps even that differ from even ones by no more than they were rounded, in a unit of `factor` seconds; then
/// the rate (Hz).
fn evened(record: &mut Record, factor: f64) -> Option<f64> {
    let is_even = record.sample_step().is_some();
    let time = record.channels.iter_mut().find(|channel| channel.name == "time")?;
    let count = time.values.len();
    if is_even || count < SHORTEST {
        return None;
    }
    let (first, last) = (time.values[0], time.values[count - 1]);
    let step = (last - first) / (count - 1) as f64;
    let whole =
        |digit: f64| time.values.iter().all(|stamp| (stamp / digit - (stamp / digit).round()).abs() < 1e-3);
    let digit = (0..=9).map(|decimals| factor * 0.1_f64.powi(decimals)).find(|digit| whole(*digit))?;
    let even = |index: usize| first + index as f64 * step;
    let is_rounded = |(index, stamp): (usize, &f64)| (stamp - even(index)).abs() <= digit * (1.0 + 1e-6);
    let rounded = step > digit && time.values.iter().enumerate().all(is_rounded);
    if rounded {
        time.values.iter_mut().enumerate().for_each(|(index, stamp)| *stamp = even(index));
    }
    rounded.then(|| step.recip())
}

fn record(name: &str, columns: Vec<Column>, regime: Regime, rows: &[usize]) -> Result<Record, Refusal> {
    if rows.is_empty() {
        return Err(refuse(
            "no row has a value in every used column",
            "export the channels on one time base",
        ));
    }
    let channels = columns.into_iter().map(|column| {
        let values = rows.iter().map(|row| column.values[*row]).collect();
        Column { values, ..column }.into_channel(None)
    });
    Ok(Record { name: format!("{name}.csv"), regime, use_for: None, channels: channels.collect() })
}

fn regime_of(
    columns: &[Column],
    options: &ImportOptions,
    notes: &mut Vec<String>,
) -> Result<Regime, Refusal> {
    let has = |name: &str| columns.iter().any(|column| column.name.quantity.name == name);
    let guessed = match (has("time"), has("frequency"), has("amplitude"), has("excitation")) {
        (true, ..) => Regime::UnknownInitialState,
        (false, true, _, true) => Regime::SteppedSine,
        (false, true, true, false) => Regime::Backbone,
        _ => {
            let names: Vec<String> = columns.iter().map(|column| format!("`{}`", column.name)).collect();
            let message = format!("there is no column of time; known are {}", names.join(", "));
            let help = "export the time stamps as a column `time [s]`, say which it is: --column 'HEADING=time [s]', or how \
                        many samples there are in a second: --sample-rate 2048";
            return Err(Refusal { is_other: true, ..refuse(message, help) });
        }
    };
    if options.regime.is_none() {
        let name = crate::dataset::REGIMES
            .iter()
            .find(|(_, regime)| *regime == guessed)
            .map_or("", |(name, _)| name);
        notes.push(format!("the regime is taken to be `{name}`"));
    }
    Ok(options.regime.unwrap_or(guessed))
}

fn check_bounds(columns: &[Column]) -> Result<(), Refusal> {
    for column in columns {
        let quantity = column.name.quantity;
        if let Some(value) =
            column.values.iter().find(|value| value.is_finite() && !within(quantity, **value))
        {
            let message = format!(
                "`{}` is {value} {} in a row: it must be {}",
                column.name,
                quantity.unit,
                bounds(quantity)
            );
            return Err(refuse(message, "correct the value, its unit or the sign of the column"));
        }
    }
    Ok(())
}
