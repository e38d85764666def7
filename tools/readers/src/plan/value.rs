//! Numbers in bounds, with errors at their places.

use stickslip::document::{DocumentError, Located, Numbers, Table};

/// Largest whole number that is one for certain.
const LARGEST_WHOLE: f64 = 9e15;

/// The number at `key`, if it is there, above zero.
pub(super) fn positive(table: &Table<'_>, key: &str) -> Result<Option<f64>, DocumentError> {
    bounded(table, key, |value| value > 0.0, "above 0")
}

/// The number at `key`, above zero.
pub(super) fn required_positive(table: &Table<'_>, key: &str, unit: &str) -> Result<f64, DocumentError> {
    positive(table, key)?.ok_or_else(|| table.missing(key).with_help(format!("`{key}` [{unit}]")))
}

/// The number at `key`, if it is there, not below zero.
pub(super) fn not_negative(table: &Table<'_>, key: &str) -> Result<Option<f64>, DocumentError> {
    bounded(table, key, |value| value >= 0.0, "0 or above")
}

/// How many records or the like: what is counted has to have room, and be carried out some day.
pub(super) fn count(table: &Table<'_>, key: &str) -> Result<Option<usize>, DocumentError> {
    const LEAST: f64 = 2.0;
    const MOST: f64 = 10_000.0;
    let legal = |value: f64| value.fract() == 0.0 && (LEAST..=MOST).contains(&value);
    let bounds = format!("a whole number from {LEAST} to {MOST}");
    Ok(bounded(table, key, legal, &bounds)?.map(|value| value as usize))
}

/// The whole number at `key`, if it is there, at least `least`.
pub(super) fn whole(table: &Table<'_>, key: &str, least: usize) -> Result<Option<usize>, DocumentError> {
    let legal = |value: f64| value.fract() == 0.0 && (least as f64..LARGEST_WHOLE).contains(&value);
    Ok(bounded(table, key, legal, &format!("a whole number from {least}"))?.map(|value| value as usize))
}

fn bounded(
    table: &Table<'_>,
    key: &str,
    legal: impl Fn(f64) -> bool,
    bounds: &str,
) -> Result<Option<f64>, DocumentError> {
    table.number(key)?.map(|number| checked(key, number, &legal, bounds)).transpose()
}

/// The value, if it is legal.
pub(super) fn checked(
    key: &str,
    number: Located<f64>,
    legal: &impl Fn(f64) -> bool,
    bounds: &str,
) -> Result<f64, DocumentError> {
    if legal(number.value) {
        return Ok(number.value);
    }
    Err(number.error(format!("`{key}` must be {bounds}, not {}", number.value)))
}

/// The number or the numbers at `key`, if they are there, at least one, all above zero.
pub(super) fn positive_list(table: &Table<'_>, key: &str) -> Result<Option<Vec<f64>>, DocumentError> {
    let list = match table.number_or_numbers(key)? {
        None => return Ok(None),
        Some(Numbers::One(value)) => vec![value],
        Some(Numbers::Many(list)) => list,
    };
    if list.is_empty() || list.iter().any(|value| *value <= 0.0) {
        let message = format!("`{key}` must be one or several numbers above 0");
        return Err(DocumentError::new(message, table.span_of(key)));
    }
    Ok(Some(list))
}
