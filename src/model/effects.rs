//! `[[effect]]`: effects added to a model.
//!
//! ```toml
//! [[effect]]
//! id = "added_mass"
//! at = "x=0.55"                 # a mass's name on an oscillator
//! mass = 0.012                  # kg
//!
//! [[effect]]
//! id = "sensor_gain"
//! channel = "acceleration:x=0.55"
//! gain = 1.07
//! ```

use super::error::ParameterError;
use super::text::{line, quoted, write_quantity};
use super::{Model, ModelError, PinnedBeam, Structure};
use crate::document::{Table, suggestion};
use crate::effects::{self, ALL_KINDS, AppliedEffect, CATALOGUE, Kind, Location, PlaceKind};
use crate::vocabulary::{Quantity, Scale};

/// Reads `[[effect]]` of a model of `kind`.
pub(super) fn parse(root: &Table<'_>, kind: Kind) -> Result<Vec<AppliedEffect>, ModelError> {
    let tables = root.tables("effect")?.unwrap_or_default();
    tables.iter().map(|table| applied(table, kind)).collect()
}

fn applied(table: &Table<'_>, kind: Kind) -> Result<AppliedEffect, ModelError> {
    let id = table.required_string("id")?;
    let effect = effects::find(id.value).ok_or_else(|| {
        let known: Vec<&str> = CATALOGUE.iter().map(|effect| effect.id).collect();
        id.error(format!("unknown effect \"{}\"", id.value))
            .with_help(suggestion(id.value, &known, "effects"))
    })?;
    let place_key = place_key(effect.place);
    let mut keys = vec!["id"];
    keys.extend(place_key);
    keys.extend(effect.parameters.iter().map(|parameter| parameter.quantity.name));
    table.allow(&keys)?;
    let location = match place_key {
        None => None,
        Some(key) => {
            let text =
                table.required_string(key).map_err(|error| missing_place(error, effect.place, kind))?;
            let read = match effect.place {
                PlaceKind::Channel => Location::parse_channel(text.value),
                PlaceKind::Structure | PlaceKind::Nowhere => Location::parse_at(text.value),
            };
            Some(read.map_err(|error| text.error(error.to_string()))?)
        }
    };
    let values = effect.parameters.iter().map(|parameter| table.quantity(parameter.quantity));
    Ok(AppliedEffect { effect, location, values: values.collect::<Result<_, _>>()? })
}

/// The key for the place of an effect.
fn place_key(place: PlaceKind) -> Option<&'static str> {
    match place {
        PlaceKind::Nowhere => None,
        PlaceKind::Structure => Some("at"),
        PlaceKind::Channel => Some("channel"),
    }
}

fn missing_place(error: ModelError, place: PlaceKind, kind: Kind) -> ModelError {
    if error.help.is_some() {
        return error;
    }
    error.with_help(match (place, kind) {
        (PlaceKind::Channel, _) => "name the column of the measurement: channel = \"force\"",
        (_, Kind::Beam | Kind::PinRig) => "say where on the beam, in metres from the clamp: at = \"x=0.55\"",
        _ => "name the mass: at = \"m1\"",
    })
}

/// Writes `[[effect]]` tables.
pub(super) fn write(text: &mut String, effects: &[AppliedEffect]) {
    for applied in effects {
        line(text, format_args!("\n[[effect]]\nid = \"{}\"", applied.effect.id));
        if let (Some(key), Some(location)) = (place_key(applied.effect.place), &applied.location) {
            line(text, format_args!("{key} = {}", quoted(&location.to_string())));
        }
        for (index, value) in applied.values.iter().enumerate() {
            write_quantity(text, applied.quantity(index), *value);
        }
    }
}

/// Bounds and scale for a fit of an effect's parameter, without the magnitudes of a problem to go by:
/// [`crate::effects::EffectParameter::range`] has those.
pub(super) fn fit_range(quantity: &Quantity, value: f64) -> (f64, f64, Scale) {
    const FACTOR: f64 = 1e3;
    let size = if value == 0.0 { quantity.nominal } else { value.abs() };
    // A fraction needs no wide range, and its open ends are no values of it.
    let inside = |end: f64| if quantity.open { 0.95 * end } else { end };
    let upper = quantity.max.map_or(FACTOR * size, inside);
    match quantity.min {
        Some(min) if min >= 0.0 && quantity.open => (size / FACTOR, upper, Scale::Logarithmic),
        Some(min) => (inside(min), upper, Scale::Linear),
        None => (-upper, upper, Scale::Linear),
    }
}

/// The rules of effects; bounds of their numbers are checked elsewhere.
pub(super) fn check(model: &Model) -> Result<(), ParameterError> {
    for (index, applied) in model.effects.iter().enumerate() {
        let path = format!("effect.{}", index + 1);
        check_shape(&path, applied)?;
        check_kind(&path, applied, model)?;
        if let Some(location) = &applied.location {
            let key = place_key(applied.effect.place).unwrap_or("at");
            check_location(&format!("{path}.{key}"), location, &model.structure)?;
        }
        let same =
            |other: &&AppliedEffect| other.effect == applied.effect && other.location == applied.location;
        if model.effects[..index].iter().any(|other| same(&other)) {
            let message = format!("the effect \"{}\" is listed twice", applied.effect.id);
            return Err(ParameterError::new(format!("{path}.id"), message)
                .with_help("two of one kind act as one: add their values"));
        }
    }
    Ok(())
}

/// What a model built in code could get wrong and a file cannot.
fn check_shape(path: &str, applied: &AppliedEffect) -> Result<(), ParameterError> {
    let effect = applied.effect;
    if applied.values.len() != effect.parameters.len() {
        let message = format!(
            "{} values for the {} parameters of {}",
            applied.values.len(),
            effect.parameters.len(),
            effect.id
        );
        return Err(ParameterError::new(path, message));
    }
    let fits = match (effect.place, &applied.location) {
        (PlaceKind::Nowhere, None) | (PlaceKind::Channel, Some(Location::Channel(_))) => true,
        (PlaceKind::Structure, Some(location)) => !matches!(location, Location::Channel(_)),
        _ => false,
    };
    if fits {
        Ok(())
    } else {
        Err(ParameterError::new(path, format!("{} has another kind of place", effect.id)))
    }
}

fn check_kind(path: &str, applied: &AppliedEffect, model: &Model) -> Result<(), ParameterError> {
    let (effect, path) = (applied.effect, format!("{path}.id"));
    if !effect.kinds.contains(&model.kind()) {
        let owners: Vec<&str> =
            ALL_KINDS.iter().filter(|kind| effect.kinds.contains(kind)).map(|kind| kind.name()).collect();
        let message =
            format!("\"{}\" does not belong to a model of kind \"{}\"", effect.id, model.kind().name());
        return Err(ParameterError::new(path, message)
            .with_help(format!("it belongs to kind = \"{}\"", owners.join("\" or \""))));
    }
    if model.contact.is_none() && effect.part.is_contact() {
        let message = format!("\"{}\" acts in the contact, and the model has no [contact]", effect.id);
        return Err(ParameterError::new(path, message));
    }
    match model.contact.map(|contact| contact.law) {
        Some(law) if effect.splits_slider() && !law.kind.one_slider => {
            let message = format!("\"{}\" does not go with law = \"{}\"", effect.id, law.kind.name);
            Err(ParameterError::new(path, message)
                .with_help("this law slips gradually by itself: fit its shape, or use law = \"jenkins\""))
        }
        _ => Ok(()),
    }
}

fn check_location(path: &str, location: &Location, structure: &Structure) -> Result<(), ParameterError> {
    match (location, structure) {
        (Location::Channel(_), _) | (_, Structure::Prescribed) => Ok(()),
        (Location::Mass(name), Structure::Oscillator(oscillator)) => {
            let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
            if names.contains(&name.as_str()) {
                return Ok(());
            }
            Err(ParameterError::new(path, format!("there is no mass \"{name}\""))
                .with_help(suggestion(name, &names, "names")))
        }
        (
            Location::Position(position),
            Structure::Beam(beam) | Structure::PinRig(PinnedBeam { beam, .. }),
        ) => {
            if (0.0..=beam.length).contains(position) {
                return Ok(());
            }
            let length = beam.length;
            let message =
                format!("position {position} m is not on the beam, which runs from 0 to {length} m");
            Err(ParameterError::new(path, message))
        }
        (Location::Mass(name), Structure::Beam(_) | Structure::PinRig(_)) => {
            Err(ParameterError::new(path, format!("\"{name}\" is no position on a beam"))
                .with_help("metres from the clamp: at = \"x=0.55\""))
        }
        (Location::Position(position), Structure::Oscillator(_)) => {
            Err(ParameterError::new(path, format!("\"x={position}\" is no mass of an oscillator"))
                .with_help("name a mass: at = \"m1\""))
        }
    }
}
