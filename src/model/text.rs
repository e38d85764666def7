//! Lines of a model file.

use std::fmt::Write;

use toml_writer::ToTomlValue;

use crate::vocabulary::Quantity;

pub(super) fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{arguments}");
}

/// `name = value`, with the unit as a comment. `{:?}` gives the shortest digits that read back the same.
pub(super) fn write_quantity(text: &mut String, quantity: &Quantity, value: f64) {
    let assignment = format!("{} = {value:?}", quantity.name);
    match quantity.unit {
        "1" => line(text, format_args!("{assignment}")),
        unit => line(text, format_args!("{assignment:<40} # {unit}")),
    }
}

pub(super) fn quoted(string: &str) -> String {
    string.to_toml_value()
}
