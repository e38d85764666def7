//! `[columns]` of `dataset.toml`: what a column of a file is.

use stickslip::document::{DocumentError, Table};

use crate::import::ColumnRule;

/// Keys of a column that is a table.
pub(crate) const KEYS: &[&str] = &["name", "place", "unit", "scale", "sign", "delay"];

/// The rules of the table `columns`, by heading or number of the column.
///
/// ```toml
/// [columns]
/// "AI0" = "force [kN]"
/// "AI1" = { name = "acceleration", place = "x=0.55", unit = "g", scale = 1.02, sign = -1, delay = 1e-4 }
/// ```
pub(crate) fn read(table: &Table<'_>) -> Result<Vec<(String, ColumnRule)>, DocumentError> {
    let Some(entries) = table.table("columns")? else { return Ok(Vec::new()) };
    let one = |key: &str| -> Result<(String, ColumnRule), DocumentError> {
        if let Ok(Some(text)) = entries.string(key) {
            return Ok((key.to_owned(), ColumnRule::of(text.value)));
        }
        let rule = entries.table(key)?.map(|table| rule(&table)).transpose()?;
        Ok((key.to_owned(), rule.unwrap_or_default()))
    };
    entries.keys().iter().map(|key| one(key.value)).collect()
}

fn rule(table: &Table<'_>) -> Result<ColumnRule, DocumentError> {
    table.allow(KEYS)?;
    let text = |key| Ok::<_, DocumentError>(table.string(key)?.map(|text| text.value.to_owned()));
    let (name, place, unit) = (text("name")?, text("place")?, text("unit")?);
    let placed = place.map_or(String::new(), |place| format!(":{place}"));
    let with_unit = unit.map_or(String::new(), |unit| format!(" [{unit}]"));
    let name = match name {
        Some(name) => Some(format!("{name}{placed}{with_unit}")),
        None if placed.is_empty() && with_unit.is_empty() => None,
        None => {
            return Err(table
                .missing("name")
                .with_help("a place or a unit needs the quantity: name = \"acceleration\""));
        }
    };
    let scale = table.number("scale")?;
    if let Some(scale) = scale.as_ref().filter(|scale| scale.value == 0.0 || !scale.value.is_finite()) {
        return Err(scale.error(format!("a scale of {} leaves nothing", scale.value)));
    }
    let sign = table.number("sign")?;
    if let Some(sign) = sign.as_ref().filter(|sign| sign.value.abs() != 1.0) {
        return Err(sign.error(format!("the sign is 1 or -1, not {}", sign.value)));
    }
    let delay = table.number("delay")?;
    if let Some(delay) = delay.as_ref().filter(|delay| !delay.value.is_finite()) {
        return Err(delay.error("the delay is a time in seconds"));
    }
    let factor = scale.map_or(1.0, |scale| scale.value) * sign.map_or(1.0, |sign| sign.value);
    Ok(ColumnRule { name, factor, delay: delay.map_or(0.0, |delay| delay.value) })
}
