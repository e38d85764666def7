//! What the user says of columns: meaning, unit, scale, sign, delay.

use stickslip::data::ChannelName;

use super::raw::{RawColumn, RawTable};
use super::{ImportOptions, Refusal, refuse};
use crate::table::Column;

/// What a column is, and what is to be done with its numbers.
///
/// ```
/// use stickslip_readers::{ColumnRule, ImportOptions, import_table};
/// let flipped = ColumnRule { factor: -1.0, ..ColumnRule::of("displacement [mm]") };
/// let options = ImportOptions { columns: vec![("AI0".into(), flipped)], ..ImportOptions::default() };
/// let bytes = b"time [s],AI0\n0,1\n1,2\n".to_vec();
/// let imported = import_table("a.csv".as_ref(), bytes, &options)?;
/// assert_eq!(imported.records[0].channel("displacement").unwrap().values, [-0.001, -0.002]);
/// # Ok::<(), stickslip_readers::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnRule {
    /// The column as `name [unit]`, with its place: `acceleration:x=0.55 [g]`; without a unit, that of the file holds. `None`
    /// where the heading says it.
    pub name: Option<String>,
    /// What the numbers are multiplied by before their unit is converted; a negative one turns their sign.
    pub factor: f64,
    /// How much later than the others the channel was sampled (s): its values are moved to where they belong.
    pub delay: f64,
}

impl Default for ColumnRule {
    fn default() -> Self {
        Self { name: None, factor: 1.0, delay: 0.0 }
    }
}

impl ColumnRule {
    /// A column that is `name [unit]`.
    pub fn of(name: &str) -> Self {
        Self { name: Some(name.to_owned()), ..Self::default() }
    }
}

/// The rule for a column, if there is one.
pub(super) fn rule<'o>(
    options: &'o ImportOptions,
    index: usize,
    column: &RawColumn,
) -> Option<&'o ColumnRule> {
    options.columns.iter().find(|(key, _)| is_meant(key, index, column)).map(|(_, rule)| rule)
}

fn is_meant(key: &str, index: usize, column: &RawColumn) -> bool {
    key == column.heading
        || key == super::heading::without_unit(&column.heading)
        || key.parse() == Ok(index + 1)
}

/// Refuses a rule for a column that no table has, and two for one column.
pub(super) fn check(tables: &[RawTable], options: &ImportOptions) -> Result<(), Refusal> {
    let all = || tables.iter().flat_map(|table| table.columns.iter().enumerate());
    for (index, column) in all() {
        let rules: Vec<&str> = options
            .columns
            .iter()
            .map(|(key, _)| key.as_str())
            .filter(|key| is_meant(key, index, column))
            .collect();
        if let [first, second, ..] = rules[..] {
            return Err(refuse(
                format!("column `{}` is described twice, as `{first}` and as `{second}`", column.heading),
                "describe it once",
            ));
        }
    }
    let known = |key: &str| all().any(|(index, column)| is_meant(key, index, column));
    match options.columns.iter().find(|(key, _)| !known(key)) {
        Some((key, _)) => {
            let listed: Vec<String> = all().map(|(_, column)| format!("`{}`", column.heading)).collect();
            Err(refuse(
                format!("there is no column `{key}`"),
                format!("the columns are {}", listed.join(", ")),
            ))
        }
        None => Ok(()),
    }
}

/// A recognised column with the delay that is told of it (s).
pub(super) struct Delayed {
    pub column: Column,
    pub delay: f64,
}

/// Columns with time stamps of the sample rate that the user tells, where the file has none.
pub(super) fn clocked(mut columns: Vec<Delayed>, options: &ImportOptions) -> Result<Vec<Delayed>, Refusal> {
    let Some(rate) = options.sample_rate else { return Ok(columns) };
    if columns.iter().any(|one| one.column.name.quantity.name == "time") {
        return Err(refuse("the file has time stamps, and a sample rate is told", "leave out --sample-rate"));
    }
    let rows = columns.first().map_or(0, |one| one.column.values.len());
    let values = (0..rows).map(|row| row as f64 / rate).collect();
    columns.insert(0, Delayed { column: Column { name: named("time")?, factor: 1.0, values }, delay: 0.0 });
    Ok(columns)
}

/// Columns with a delay moved to the time at which their values were measured, by straight lines between samples; NaN where
/// there is none any more.
pub(super) fn shifted(columns: Vec<Delayed>, notes: &mut Vec<String>) -> Result<Vec<Column>, Refusal> {
    let time = columns.iter().find(|one| one.column.name.quantity.name == "time");
    let time = time.map(|one| one.column.values.clone());
    let move_one = |Delayed { mut column, delay }: Delayed| {
        if delay == 0.0 {
            return Ok(column);
        }
        let Some(time) = time.as_ref().filter(|_| column.name.quantity.name != "time") else {
            return Err(refuse(format!("`{}` cannot be moved in time", column.name), "remove its `delay`"));
        };
        notes.push(format!(
            "`{}` was moved by its delay of {delay} s, with straight lines between samples",
            column.name
        ));
        column.values = moved(time, &column.values, delay);
        Ok(column)
    };
    columns.into_iter().map(move_one).collect()
}

/// `values` at `delay` after each time.
fn moved(times: &[f64], values: &[f64], delay: f64) -> Vec<f64> {
    let mut at = 0;
    let one = |time: &f64| {
        let wanted = time + delay;
        // The delay is one for all rows: the place only goes on, but for a negative one at the start of a record.
        while at > 0 && times[at] > wanted {
            at -= 1;
        }
        while at + 2 < times.len() && times[at + 1] <= wanted {
            at += 1;
        }
        let [Some(before), Some(after)] = [times.get(at), times.get(at + 1)] else { return f64::NAN };
        if !(*before <= wanted && wanted <= *after) {
            return f64::NAN;
        }
        let part = (wanted - before) / (after - before);
        values[at] + part * (values[at + 1] - values[at])
    };
    times.iter().map(one).collect()
}

/// The name that a rule gives, parsed; the rule's own text where it is none.
pub(super) fn named(text: &str) -> Result<ChannelName, Refusal> {
    ChannelName::parse(text).map_err(|error| refuse(error.to_string(), "write --column 'HEADING=force [kN]'"))
}
