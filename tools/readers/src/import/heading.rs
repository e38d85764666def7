//! Which column means what, in which unit.

use stickslip::data::{ChannelName, Place, unit_factor};

use super::columns::{self, ColumnRule, Delayed};
use super::grid::bare;
use super::raw::RawColumn;
use super::{ImportOptions, Refusal, refuse};
use crate::table::Column;

/// Words for quantities, in lower case, as headings of measurements use them. Where a word stands for two, the unit decides.
const WORDS: &[(&str, &[&str])] = &[
    ("time", &["time", "t", "zeit", "temps", "tiempo", "timestamp", "elapsed", "x_value", "clock"]),
    ("displacement", &["displacement", "disp", "displ", "weg", "slip", "u", "x", "stroke", "deplacement"]),
    ("velocity", &["velocity", "vel", "v", "speed", "geschwindigkeit", "vitesse"]),
    ("acceleration", &["acceleration", "accel", "acc", "a", "beschleunigung"]),
    ("normal_load", &["normal_load", "normal_force", "normalkraft", "preload", "fn", "clamp_force"]),
    ("normal_displacement", &["normal_displacement"]),
    ("force", &["force", "kraft", "load", "load_cell", "f", "friction_force", "tangential_force", "ft"]),
    ("excitation", &["excitation", "shaker_force", "drive_force", "input_force", "anregung", "hammer"]),
    ("frequency", &["frequency", "freq", "f", "frequenz"]),
    ("amplitude", &["amplitude", "amp"]),
    ("damping_ratio", &["damping_ratio", "zeta", "damping"]),
    ("phase", &["phase", "phasenwinkel"]),
    ("contact_force", &["contact_force"]),
];

/// Without one of them there is no measurement of a contact or a structure.
const MOTIONS: [&str; 4] = ["displacement", "velocity", "acceleration", "frequency"];

/// Words beside the quantity that change nothing.
const FILLERS: [&str; 9] = ["sensor", "channel", "ch", "signal", "measured", "in", "raw", "value", "data"];

/// The words of a heading without its unit: `Kraft` of `Kraft (kN)`.
pub(super) fn without_unit(heading: &str) -> &str {
    split_unit(heading).0
}

/// The quantity that a heading names, whatever its unit.
pub(super) fn quantity_of(heading: &str) -> Option<&'static str> {
    let (words, unit) = split_unit(heading);
    let name = ChannelName::parse(words)
        .ok()
        .or_else(|| guess(words, unit.map(|unit| unit_spelling(&unit))).map(|found| found.0));
    name.map(|name| name.quantity.name)
}

/// The known columns with their values in SI.
pub(super) fn recognise(
    raw: Vec<RawColumn>,
    options: &ImportOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<Delayed>, Refusal> {
    let listed = raw.iter().map(|column| format!("`{}`", column.heading)).collect::<Vec<_>>().join(", ");
    let mut columns: Vec<Delayed> = Vec::new();
    let mut unused = Vec::new();
    for (index, raw) in raw.into_iter().enumerate() {
        let heading = raw.heading.clone();
        let rule = columns::rule(options, index, &raw).cloned().unwrap_or_default();
        let Some((name, unit)) = meaning(&raw, &rule)? else {
            unused.push(format!("`{heading}`"));
            continue;
        };
        if columns.iter().any(|other| other.column.name == name) {
            return Err(refuse(
                format!("two columns would be `{name}`, the second is `{heading}`"),
                "say which is which, with the place where it was measured: \
                 --column 'HEADING=acceleration:x=0.55 [g]'",
            ));
        }
        let column = convert(raw, name, &unit, &rule, notes)?;
        columns.push(Delayed { column, delay: rule.delay });
    }
    if !unused.is_empty() {
        notes.push(format!("not used: {}", unused.join(", ")));
    }
    if columns.is_empty() {
        let help = "say what they are: --column 'HEADING=force [kN]'";
        return Err(Refusal {
            is_other: true,
            ..refuse(format!("no column has a known name: {listed}"), help)
        });
    }
    let moves = |one: &Delayed| MOTIONS.contains(&one.column.name.quantity.name);
    if !columns.iter().any(moves) {
        let known: Vec<String> = columns.iter().map(|one| format!("`{}`", one.column.name)).collect();
        let help = "say which column is a motion, with a place where there are several: \
                    --column 'HEADING=displacement [mm]', --column 'HEADING=acceleration:x=0.55 [g]'";
        let message = format!("no motion is known, only {}; the columns are {listed}", known.join(", "));
        return Err(Refusal { is_other: true, ..refuse(message, help) });
    }
    tell_force(&mut columns, options, notes);
    Ok(columns)
}

/// Name and unit of a column; `None` where it has no known name.
fn meaning(raw: &RawColumn, rule: &ColumnRule) -> Result<Option<(ChannelName, String)>, Refusal> {
    let told = rule.name.as_deref();
    let (words, unit) = split_unit(told.unwrap_or(&raw.heading));
    if let (None, Some(unit), Some(below)) = (told, &unit, &raw.unit)
        && unit_spelling(unit) != unit_spelling(below)
    {
        return Err(refuse(
            format!(
                "column `{}` is in `{unit}` by its name and in `{below}` by the unit below or beside it",
                raw.heading
            ),
            format!("say which it is: --column '{}=NAME [UNIT]'", raw.heading),
        ));
    }
    let unit = unit.or_else(|| raw.unit.clone()).map(|unit| unit_spelling(&unit));
    let name = match (told, ChannelName::parse(words)) {
        (_, Ok(name)) => Some((name, unit)),
        (Some(_), Err(_)) => Some((columns::named(words)?, unit)),
        (None, Err(_)) => guess(words, unit),
    };
    let Some((name, unit)) = name else { return Ok(None) };
    match unit {
        Some(unit) => Ok(Some((name, unit))),
        None if raw.clock => Ok(Some((name, "s".to_owned()))),
        None => Err(no_unit(&name, &raw.heading)),
    }
}

fn no_unit(name: &ChannelName, heading: &str) -> Refusal {
    let unit = name.quantity.unit;
    refuse(
        format!("column `{heading}` has no unit"),
        format!("write it in the heading, `{heading} [{unit}]`, or say --column '{heading}={name} [{unit}]'"),
    )
}

/// `name [unit]`, `name (unit)`, `name / unit`, `name, unit` or `name in unit`.
fn split_unit(heading: &str) -> (&str, Option<String>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, unit)) = heading.strip_suffix(close).and_then(|heading| heading.rsplit_once(open))
        {
            return (name.trim().trim_end_matches('_'), Some(bare(unit).to_owned()));
        }
    }
    let is_unit = |unit: &str| stickslip::data::unit_size(&unit_spelling(unit)).is_some();
    for sign in [" in ", ", ", " / ", "/", " - "] {
        if let Some((name, unit)) = heading.split_once(sign)
            && is_unit(unit)
        {
            return (name.trim(), Some(unit.trim().to_owned()));
        }
    }
    (heading.trim(), None)
}

/// From the words of a heading: the quantity, a mass (`m1`), a unit behind the last underscore.
fn guess(words: &str, unit: Option<String>) -> Option<(ChannelName, Option<String>)> {
    let lower = words.to_lowercase();
    // `force_kN` and `acc_m/s^2`: the unit keeps its capital letters.
    if unit.is_none()
        && let Some(cut) = words.rfind(['_', ' '])
        && let Some(found) = guess(&words[..cut], Some(unit_spelling(&words[cut + 1..])))
    {
        return Some(found);
    }
    let mut tokens: Vec<&str> =
        lower.split(|letter: char| !letter.is_alphanumeric()).filter(|token| !token.is_empty()).collect();
    let is_place = |token: &&str| token.strip_prefix('m').is_some_and(|digits| digits.parse::<u32>().is_ok());
    let place = tokens.iter().position(is_place).map(|at| tokens.remove(at).to_owned());
    let whole = tokens.join("_");
    tokens.retain(|token| !FILLERS.contains(token));
    let phrase = tokens.join("_");
    let suits =
        |name: &ChannelName| unit.as_ref().is_none_or(|unit| unit_factor(unit, name.quantity).is_ok());
    let names =
        WORDS.iter().filter(|(_, words)| [&whole, &phrase].iter().any(|text| words.contains(&text.as_str())));
    names
        .filter_map(|(name, _)| ChannelName::parse(name).ok())
        .find(suits)
        .and_then(|name| match &place {
            Some(place) => ChannelName::parse(&format!("{}:{place}", name.quantity.name)).ok(),
            None => Some(name),
        })
        .map(|name| (name, unit))
}

/// Spellings of units that the table of units does not hold.
pub(super) fn unit_spelling(unit: &str) -> String {
    let unit = bare(unit);
    match unit.to_lowercase().as_str() {
        "sec" | "secs" | "second" | "seconds" | "sekunden" => "s".to_owned(),
        "msec" | "milliseconds" => "ms".to_owned(),
        "usec" => "us".to_owned(),
        "newton" | "newtons" => "N".to_owned(),
        "kilonewton" => "kN".to_owned(),
        "micron" | "microns" | "micrometer" => "um".to_owned(),
        "millimeter" | "millimetre" => "mm".to_owned(),
        "inch" | "inches" => "in".to_owned(),
        "hertz" => "Hz".to_owned(),
        "grad" | "degree" | "degrees" | "deg" => "deg".to_owned(),
        "m/s/s" => "m/s^2".to_owned(),
        "m/sec^2" => "m/s^2".to_owned(),
        _ => unit.replace("**", "^"),
    }
}

fn convert(
    raw: RawColumn,
    name: ChannelName,
    unit: &str,
    rule: &ColumnRule,
    notes: &mut Vec<String>,
) -> Result<Column, Refusal> {
    let factor = unit_factor(unit, name.quantity).map_err(|error| {
        refuse(format!("column `{}`: {error}", raw.heading), "correct the unit in the heading")
    })?;
    let written = format!("{name} [{unit}]");
    // `force [kN]`, or `force` with its unit among the properties.
    if raw.heading != written && !(raw.heading == name.to_string() && raw.unit.as_deref() == Some(unit)) {
        notes.push(format!("`{}` was read as {written}", raw.heading));
    }
    if let Some((number, line)) = &raw.grouped {
        return Err(refuse(
            format!("line {line}: `{number}` in `{}` is written with signs between thousands", raw.heading),
            "export the numbers without them",
        ));
    }
    if let Some((word, line)) = &raw.first_word {
        notes.push(format!(
            "`{}` holds no number in {} rows, first `{word}` in line {line}",
            raw.heading, raw.words
        ));
    }
    let mut values = raw.values;
    if raw.clock && name.quantity.name == "time" {
        notes.push("times of day were counted from the first row, in seconds".to_owned());
        let start = values.first().copied().unwrap_or(0.0);
        let mut days = 0.0;
        let mut before = start;
        for value in &mut values {
            if *value < before - 43_200.0 {
                days += 86_400.0;
            }
            before = *value;
            *value += days - start;
        }
    }
    if rule.factor != 1.0 {
        notes.push(format!("`{}` was multiplied by {}", raw.heading, rule.factor));
    }
    let factor = factor * rule.factor.abs();
    values.iter_mut().for_each(|value| *value *= factor * rule.factor.signum());
    Ok(Column { name, factor, values })
}

/// A force beside accelerations, without a displacement, is that on a structure.
fn tell_force(columns: &mut [Delayed], options: &ImportOptions, notes: &mut Vec<String>) {
    let has = |name: &str| columns.iter().any(|one| one.column.name.quantity.name == name);
    let guessed = has("acceleration") && !has("displacement");
    if !options.structure.unwrap_or(guessed) || has("excitation") {
        return;
    }
    let force = columns
        .iter_mut()
        .map(|one| &mut one.column)
        .find(|column| column.name.quantity.name == "force" && column.name.place == Place::Unnamed);
    if let (Some(force), Ok(excitation)) = (force, ChannelName::parse("excitation")) {
        force.name = excitation;
        notes.push("the force is taken for the one on the structure (`excitation`)".to_owned());
    }
}
