//! `kind = "pin_rig"`: a beam with a pin at its free end, pressed on a support by a mass on a string.
//!
//! ```toml
//! [beam]                        # as of kind = "beam"
//!
//! [pin]
//! mass = 0.0355                 # kg
//! inertia = 6.4e-7              # kg.m^2, 0 if left out
//! tangential_lever = 0.006      # m, of the friction about the beam's end
//! normal_lever = 0.006          # m, of the normal force
//!
//! [string]
//! stiffness = 1e5               # N/m
//! length = 0.3                  # m
//! mass = 7.0                    # kg
//! inertia = 0.005               # kg.m^2, 0 if left out
//!
//! [contact]
//! law = "jenkins"
//! tangential_stiffness = 3.95e6 # N/m
//! friction_coefficient = 0.6
//! normal_load = 68.67           # N; the weight of the hanging mass if left out
//! normal_stiffness = 2.37e7     # N/m
//! normal_law = "hertz"          # without it the load of the friction stays constant
//! ```

use super::error::ParameterError;
use super::slots::Slot;
use super::text::{line, write_quantity};
use super::{Contact, Model, ModelError};
use crate::document::Table;
use crate::effects::{AppliedEffect, Changes};
use crate::system::{Beam, HangingString, Pin, PinRig, StructureChanges, StructureError};
use crate::vocabulary::{self as v, Quantity};

/// A beam with a pin at its free end, and the mass on a string that presses the pin on its support: a [`PinRig`] but for
/// the stiffness of its contact, which the model's contact has.
///
/// Of the [`Beam`] the offset is the tangential lever of the contact.
#[derive(Debug, Clone, PartialEq)]
pub struct PinnedBeam {
    /// The beam, with its masses, excitation, sensors and damping.
    pub beam: Beam,
    /// The pin.
    pub pin: Pin,
    /// String and hanging mass.
    pub string: HangingString,
    /// Stiffness (N/m) along and across of the springs by which the modes know of a contact that is not the model's own, but
    /// forces from outside; they are taken away again. `None` of a model with a contact, whose springs are its own.
    pub outside: Option<[f64; 2]>,
}

pub(super) const PIN_KEYS: [&str; 6] = [
    v::MASS.name,
    v::INERTIA.name,
    v::TANGENTIAL_LEVER.name,
    v::NORMAL_LEVER.name,
    v::TANGENTIAL_STIFFNESS.name,
    v::NORMAL_STIFFNESS.name,
];
pub(super) const STRING_KEYS: [&str; 4] =
    [v::STRING_STIFFNESS.name, v::STRING_LENGTH.name, v::MASS.name, v::INERTIA.name];

/// Reads the tables of the rig, to the beam that is read already.
pub(super) fn parse(root: &Table<'_>, beam: Beam) -> Result<PinnedBeam, ModelError> {
    let table = |name: &str, keys: &[&str]| {
        let table = root.table(name)?.ok_or_else(|| root.missing(name))?;
        table.allow(keys).map(|()| table)
    };
    let or_zero = |table: &Table<'_>, quantity: &Quantity| {
        Ok::<_, ModelError>(table.number(quantity.name)?.map_or(0.0, |number| number.value))
    };
    let pin = table("pin", &PIN_KEYS)?;
    let string = table("string", &STRING_KEYS)?;
    let springs = [&v::TANGENTIAL_STIFFNESS, &v::NORMAL_STIFFNESS];
    let given = springs.iter().any(|spring| pin.keys().iter().any(|key| key.value == spring.name));
    let outside = given.then(|| Ok::<_, ModelError>([pin.quantity(springs[0])?, pin.quantity(springs[1])?]));
    Ok(PinnedBeam {
        beam: Beam { offset: pin.quantity(&v::TANGENTIAL_LEVER)?, ..beam },
        pin: Pin {
            mass: pin.quantity(&v::MASS)?,
            inertia: or_zero(&pin, &v::INERTIA)?,
            normal_lever: pin.quantity(&v::NORMAL_LEVER)?,
        },
        string: HangingString {
            stiffness: string.quantity(&v::STRING_STIFFNESS)?,
            length: string.quantity(&v::STRING_LENGTH)?,
            mass: string.quantity(&v::MASS)?,
            inertia: or_zero(&string, &v::INERTIA)?,
        },
        outside: outside.transpose()?,
    })
}

impl PinnedBeam {
    /// Weight of the hanging mass (N).
    pub fn weight(&self) -> f64 {
        self.string.weight()
    }

    /// The rig with the springs of `contact`, or of [`PinnedBeam::outside`], in its base linear system, and with `changes`:
    /// masses on the beam, and its clamp.
    ///
    /// # Errors
    /// [`StructureError::NotOnTheBeam`] for a mass that is not at a position.
    pub fn rig(
        &self,
        contact: Option<&Contact>,
        changes: &StructureChanges,
    ) -> Result<PinRig, StructureError> {
        let springs = contact.map(|contact| [contact.tangential_stiffness, contact.normal_stiffness]);
        Ok(PinRig {
            beam: self.beam.changed(changes)?,
            pin: self.pin,
            string: self.string,
            stuck_stiffness: springs.or(self.outside).unwrap_or_default(),
        })
    }

    pub(super) fn write(&self, text: &mut String) {
        line(text, format_args!("\n[pin]"));
        write_quantity(text, &v::MASS, self.pin.mass);
        write_quantity(text, &v::INERTIA, self.pin.inertia);
        write_quantity(text, &v::TANGENTIAL_LEVER, self.beam.offset);
        write_quantity(text, &v::NORMAL_LEVER, self.pin.normal_lever);
        if let Some([along, across]) = self.outside {
            write_quantity(text, &v::TANGENTIAL_STIFFNESS, along);
            write_quantity(text, &v::NORMAL_STIFFNESS, across);
        }
        line(text, format_args!("\n[string]"));
        write_quantity(text, &v::STRING_STIFFNESS, self.string.stiffness);
        write_quantity(text, &v::STRING_LENGTH, self.string.length);
        write_quantity(text, &v::MASS, self.string.mass);
        write_quantity(text, &v::INERTIA, self.string.inertia);
    }

    /// The parameters of pin and string, of which the beam's offset is one.
    pub(super) fn slots<'a>(
        pin: &'a mut Pin,
        string: &'a mut HangingString,
        outside: &'a mut Option<[f64; 2]>,
        offset: &'a mut f64,
        slots: &mut Vec<Slot<'a>>,
    ) {
        let mut add = |table: &str, quantity: &'static Quantity, slot| {
            slots.push((format!("{table}.{}", quantity.name), quantity, slot));
        };
        add("pin", &v::MASS, &mut pin.mass);
        add("pin", &v::INERTIA, &mut pin.inertia);
        add("pin", &v::TANGENTIAL_LEVER, offset);
        add("pin", &v::NORMAL_LEVER, &mut pin.normal_lever);
        if let Some([along, across]) = outside {
            add("pin", &v::TANGENTIAL_STIFFNESS, along);
            add("pin", &v::NORMAL_STIFFNESS, across);
        }
        add("string", &v::STRING_STIFFNESS, &mut string.stiffness);
        add("string", &v::STRING_LENGTH, &mut string.length);
        add("string", &v::MASS, &mut string.mass);
        add("string", &v::INERTIA, &mut string.inertia);
    }

    /// What a rig's contact must have, and what its beam cannot.
    pub(super) fn check(&self, model: &Model) -> Result<(), ParameterError> {
        match (&model.contact, self.outside) {
            (None, None) => {
                let message = "a model of kind \"pin_rig\" needs [contact]";
                return Err(ParameterError::new("contact", message).with_help(
                    "its pin rests on a support; where that is another program's, [pin] has tangential_stiffness and \
                     normal_stiffness",
                ));
            }
            (Some(_), Some(_)) => {
                let message = "the contact has the stiffness of both directions";
                return Err(ParameterError::new("pin.tangential_stiffness", message).with_help(
                    "take both out of [pin]: they stand for a contact that is another program's",
                ));
            }
            _ => {}
        }
        let Beam { rotational_stiffness, static_correction, contact_points, .. } = &self.beam;
        if *rotational_stiffness != 0.0 || *static_correction || !contact_points.is_empty() {
            let message = "rotational spring, static correction and contact points are of kind \"beam\"";
            return Err(ParameterError::new("beam", message));
        }
        let varies = |applied: &AppliedEffect| {
            let mut changes = Changes::default();
            applied.apply(&mut changes);
            changes.joint.load_gain.is_some()
        };
        let varying = model.effects.iter().position(varies);
        if let (Some(place), Some(_)) = (varying, model.contact.and_then(|contact| contact.normal)) {
            let message = "the load follows the normal force already: the contact has a `normal_law`";
            return Err(ParameterError::new(format!("effect.{}.id", place + 1), message)
                .with_help("take out the effect or `normal_law`"));
        }
        Ok(())
    }
}
