//! `kind = "oscillator"`: masses by their names, springs with dampers between them and the ground.
//!
//! ```toml
//! [[mass]]
//! name = "m1"
//! mass = 1.0                    # kg
//!
//! [[spring]]
//! between = ["ground", "m1"]
//! stiffness = 1.0               # N/m
//! damping = 0.1                 # N s/m
//!
//! [contact]
//! at = "m1"                     # against the ground
//! ```

use std::collections::BTreeMap;

use super::ModelError;
use super::error::ParameterError;
use super::text::{line, quoted, write_quantity};
use crate::document::{Located, Table, nearest, suggestion};
use crate::system::{Anchor, Mass, Oscillator, Spring};
use crate::vocabulary::{self as v, Quantity};

/// The name that stands for the ground in `between`.
pub const GROUND: &str = "ground";

pub(super) const MASS_KEYS: [&str; 2] = ["name", "mass"];
pub(super) const SPRING_KEYS: [&str; 3] = ["between", "stiffness", "damping"];

/// Most names a message lists.
const MOST_LISTED: usize = 12;

/// Reads the tables of an oscillator.
pub(super) fn parse(root: &Table<'_>) -> Result<Oscillator, ModelError> {
    let tables = root.tables("mass")?.unwrap_or_default();
    if tables.is_empty() {
        let help = "an oscillator has at least one mass: [[mass]] name = \"m1\", mass = 1.0";
        return Err(root.missing("mass").with_help(help));
    }
    let masses = tables.iter().map(mass).collect::<Result<Vec<_>, _>>()?;
    let places = check_names(&masses).map_err(|error| ModelError {
        span: root.locate(&error.path),
        message: error.message,
        help: error.help,
    })?;
    let springs = root.tables("spring")?.unwrap_or_default();
    let springs = springs.iter().map(|table| spring(table, &places)).collect::<Result<_, _>>()?;
    let at = |table: Table<'_>| mass_at(&table.required_string("at")?, &places);
    let contact = root.table("contact")?.map(|table| at(table).map_err(|error| contact_help(error, &masses)));
    let excitation = root.table("excitation")?.map(|table| table.allow(&["at"]).and_then(|()| at(table)));
    Ok(Oscillator {
        springs,
        contact: contact.transpose()?,
        excitation: excitation.transpose()?.unwrap_or(0),
        masses,
    })
}

fn mass(table: &Table<'_>) -> Result<Mass, ModelError> {
    table.allow(&MASS_KEYS)?;
    let name = table.required_string("name")?.value.to_owned();
    Ok(Mass { name, mass: table.quantity(&v::MASS)? })
}

fn spring(table: &Table<'_>, masses: &BTreeMap<&str, usize>) -> Result<Spring, ModelError> {
    table.allow(&SPRING_KEYS)?;
    let example = "between = [\"ground\", \"m1\"]";
    let ends = table.strings("between")?.ok_or_else(|| table.missing("between").with_help(example))?;
    let [first, second] = ends.as_slice() else {
        let message = format!("`between` must name two ends, not {}", ends.len());
        return Err(ModelError::new(message, table.span_of("between")).with_help(example));
    };
    let anchor = |end: &Located<&str>| match end.value {
        GROUND => Ok(Anchor::Ground),
        _ => anchor_at(end, masses),
    };
    let between = [anchor(first)?, anchor(second)?];
    let value = |quantity: &Quantity| table.number(quantity.name);
    let (stiffness, damping) = (value(&v::STIFFNESS)?, value(&v::DAMPING)?);
    if stiffness.is_none() && damping.is_none() {
        let help = "give `stiffness` [N/m], `damping` [N.s/m], or both";
        return Err(table.missing("stiffness").with_help(help));
    }
    let or_zero = |value: Option<Located<f64>>| value.map_or(0.0, |value| value.value);
    Ok(Spring { between, stiffness: or_zero(stiffness), damping: or_zero(damping) })
}

fn anchor_at(name: &Located<&str>, masses: &BTreeMap<&str, usize>) -> Result<Anchor, ModelError> {
    match masses.get(name.value) {
        Some(mass) => Ok(Anchor::Mass(*mass)),
        None => {
            let names: Vec<&str> = [GROUND].into_iter().chain(masses.keys().copied()).collect();
            Err(unknown_mass(name, &names))
        }
    }
}

fn mass_at(name: &Located<&str>, masses: &BTreeMap<&str, usize>) -> Result<usize, ModelError> {
    let names: Vec<&str> = masses.keys().copied().collect();
    masses.get(name.value).copied().ok_or_else(|| unknown_mass(name, &names))
}

fn unknown_mass(name: &Located<&str>, names: &[&str]) -> ModelError {
    let help = if names.len() <= MOST_LISTED {
        suggestion(name.value, names, "names")
    } else {
        let start =
            names[..MOST_LISTED].iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let guess = nearest(name.value, names).map(|guess| format!("did you mean `{guess}`? "));
        format!("{}{} names: {start}, …", guess.unwrap_or_default(), names.len())
    };
    name.error(format!("there is no mass \"{}\"", name.value)).with_help(help)
}

/// A contact without its place says where it could be.
fn contact_help(error: ModelError, masses: &[Mass]) -> ModelError {
    if error.help.is_some() {
        return error;
    }
    error.with_help(format!("the contact acts between a mass and the ground: at = \"{}\"", masses[0].name))
}

impl Oscillator {
    /// The rules of an oscillator's names and references; bounds of its numbers are checked elsewhere.
    pub(super) fn check(&self, has_contact: bool) -> Result<(), ParameterError> {
        if self.masses.is_empty() {
            return Err(ParameterError::new("mass", "an oscillator has at least one mass"));
        }
        check_names(&self.masses)?;
        for (index, spring) in self.springs.iter().enumerate() {
            let path = format!("spring.{}.between", index + 1);
            for end in spring.between {
                if let Anchor::Mass(mass) = end {
                    self.check_reference(&path, mass)?;
                }
            }
            if spring.between[0] == spring.between[1] {
                let message = format!("both ends are at \"{}\"", self.name_of(spring.between[0]));
                return Err(ParameterError::new(path, message)
                    .with_help("a spring acts between a mass and the ground, or between two masses"));
            }
        }
        self.check_reference("excitation.at", self.excitation)?;
        match (self.contact, has_contact) {
            (Some(mass), true) => self.check_reference("contact.at", mass),
            (None, false) => Ok(()),
            (None, true) => Err(ParameterError::new("contact", "`at` is missing from [contact]")),
            (Some(_), false) => {
                Err(ParameterError::new("contact", "there is a place for a contact, but no contact"))
            }
        }
    }

    fn check_reference(&self, path: &str, mass: usize) -> Result<(), ParameterError> {
        if mass < self.masses.len() {
            return Ok(());
        }
        Err(ParameterError::new(path, format!("there is no mass {} of {}", mass + 1, self.masses.len())))
    }

    fn name_of(&self, anchor: Anchor) -> &str {
        match anchor {
            Anchor::Ground => GROUND,
            Anchor::Mass(mass) => self.masses.get(mass).map_or("", |mass| &mass.name),
        }
    }

    /// Name of the mass that the contact touches.
    pub(super) fn contact_name(&self) -> Option<&str> {
        self.contact.map(|mass| self.name_of(Anchor::Mass(mass)))
    }

    /// Writes masses, springs and excitation.
    pub(super) fn write(&self, text: &mut String) {
        for mass in &self.masses {
            line(text, format_args!("\n[[mass]]\nname = {}", quoted(&mass.name)));
            write_quantity(text, &v::MASS, mass.mass);
        }
        for spring in &self.springs {
            let [first, second] = spring.between.map(|end| quoted(self.name_of(end)));
            line(text, format_args!("\n[[spring]]\nbetween = [{first}, {second}]"));
            if spring.stiffness != 0.0 || spring.damping == 0.0 {
                write_quantity(text, &v::STIFFNESS, spring.stiffness);
            }
            if spring.damping != 0.0 {
                write_quantity(text, &v::DAMPING, spring.damping);
            }
        }
        let excited = quoted(self.name_of(Anchor::Mass(self.excitation)));
        line(text, format_args!("\n[excitation]\nat = {excited}"));
    }
}

/// The place of each name; no name is listed twice.
fn check_names(masses: &[Mass]) -> Result<BTreeMap<&str, usize>, ParameterError> {
    let mut places = BTreeMap::new();
    for (index, mass) in masses.iter().enumerate() {
        let path = format!("mass.{}.name", index + 1);
        check_name(&path, &mass.name)?;
        if let Some(before) = places.insert(mass.name.as_str(), index) {
            let message = format!("the mass \"{}\" is listed twice", mass.name);
            return Err(ParameterError::new(path, message)
                .with_help(format!("mass {} has this name too", before + 1)));
        }
    }
    Ok(places)
}

/// A mass's name is part of the names of columns: `displacement:m1`.
fn check_name(path: &str, name: &str) -> Result<(), ParameterError> {
    if name == GROUND {
        return Err(ParameterError::new(path, "no mass can be called \"ground\"")
            .with_help("the ground is what springs are fixed to"));
    }
    let legal = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    if name.is_empty() || !name.chars().all(legal) {
        return Err(ParameterError::new(path, format!("\"{name}\" cannot be a mass's name"))
            .with_help("letters, digits, `_` and `-`"));
    }
    Ok(())
}
