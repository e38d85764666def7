//! The normal direction of a contact in a model file: `normal_law` and the keys that go with it.
//!
//! ```toml
//! [contact]
//! law = "jenkins"
//! tangential_stiffness = 3.95e6    # N/m
//! friction_coefficient = 0.6
//! normal_load = 68.67              # N, carried at rest
//! normal_law = "hertz"             # linear, cubic or hertz
//! normal_stiffness = 2.37e7        # N/m, slope at rest
//! normal_exponent = 1.5            # hertz alone, 1.5 if left out
//! normal_cubic_stiffness = 1e18    # N/m^3, cubic alone
//! impact_damping = 30.0            # s/m, 0 if left out
//! ```

use std::sync::Arc;

use super::error::ParameterError;
use super::slots::Slot;
use super::text::{line, write_quantity};
use super::{Contact, Model, ModelError, Structure};
use crate::contact::{LawError, NormalDirection, NormalLaw, SlipSlap};
use crate::document::{Table, suggestion};
use crate::vocabulary::{self as v, Quantity};

/// What makes a contact one in two directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// The elastic law; its stiffness is [`normal_stiffness`](super::Contact::normal_stiffness).
    pub law: NormalLaw,
    /// λ (s/m).
    pub impact_damping: f64,
}

/// The key that names the law.
const LAW: &str = "normal_law";
const LAWS: [&str; 3] = ["linear", "cubic", "hertz"];
/// All keys, those of every law last.
pub(super) const KEYS: [&str; 4] =
    [LAW, v::NORMAL_CUBIC_STIFFNESS.name, v::NORMAL_EXPONENT.name, v::IMPACT_DAMPING.name];
/// Exponent of Hertz' law in a file that does not give it: two curved bodies.
const EXPONENT: f64 = 1.5;

/// Reads the keys of `[contact]`.
pub(super) fn parse(table: &Table<'_>) -> Result<Option<Normal>, ModelError> {
    let name = table.string(LAW)?;
    if let Some(name) = name.as_ref().filter(|name| !LAWS.contains(&name.value)) {
        let message = format!("unknown {LAW} \"{}\"", name.value);
        return Err(name.error(message).with_help(suggestion(name.value, &LAWS, "laws")));
    }
    let given = name.as_ref().map(|name| name.value);
    for (quantity, law) in [(&v::NORMAL_CUBIC_STIFFNESS, "cubic"), (&v::NORMAL_EXPONENT, "hertz")] {
        if given != Some(law) {
            refuse(table, quantity, given, &format!("{LAW} = \"{law}\""))?;
        }
    }
    let Some(name) = name else {
        refuse(table, &v::IMPACT_DAMPING, None, &format!("a contact with {LAW}"))?;
        return Ok(None);
    };
    let number = |quantity: &Quantity, default| {
        Ok::<_, ModelError>(table.number(quantity.name)?.map_or(default, |number| number.value))
    };
    let law = match name.value {
        "linear" => NormalLaw::Linear,
        "cubic" => NormalLaw::Cubic { cubic_stiffness: table.quantity(&v::NORMAL_CUBIC_STIFFNESS)? },
        _ => NormalLaw::Hertz { exponent: number(&v::NORMAL_EXPONENT, EXPONENT)? },
    };
    // Without it there is no law to speak of.
    table.quantity(&v::NORMAL_STIFFNESS)?;
    Ok(Some(Normal { law, impact_damping: number(&v::IMPACT_DAMPING, 0.0)? }))
}

/// Refuses a key that belongs to `owner` alone.
fn refuse(table: &Table<'_>, quantity: &Quantity, law: Option<&str>, owner: &str) -> Result<(), ModelError> {
    let keys = table.keys();
    let Some(key) = keys.iter().find(|key| key.value == quantity.name) else { return Ok(()) };
    let message = match law {
        Some(law) => format!("`{}` does not belong to {LAW} = \"{law}\"", key.value),
        None => format!("`{}` does not belong to a contact without {LAW}", key.value),
    };
    Err(key.error(message).with_help(format!("it belongs to {owner}")))
}

impl Normal {
    pub(super) fn write(&self, text: &mut String) {
        let (name, own) = match self.law {
            NormalLaw::Linear => ("linear", None),
            NormalLaw::Cubic { cubic_stiffness } => {
                ("cubic", Some((&v::NORMAL_CUBIC_STIFFNESS, cubic_stiffness)))
            }
            NormalLaw::Hertz { exponent } => ("hertz", Some((&v::NORMAL_EXPONENT, exponent))),
        };
        line(text, format_args!("{LAW} = \"{name}\""));
        if let Some((quantity, value)) = own {
            write_quantity(text, quantity, value);
        }
        write_quantity(text, &v::IMPACT_DAMPING, self.impact_damping);
    }

    /// Adds its parameters.
    pub(super) fn slots<'a>(&'a mut self, slots: &mut Vec<Slot<'a>>) {
        let mut add = |quantity: &'static Quantity, slot| {
            slots.push((format!("contact.{}", quantity.name), quantity, slot));
        };
        match &mut self.law {
            NormalLaw::Linear => {}
            NormalLaw::Cubic { cubic_stiffness } => add(&v::NORMAL_CUBIC_STIFFNESS, cubic_stiffness),
            NormalLaw::Hertz { exponent } => add(&v::NORMAL_EXPONENT, exponent),
        }
        add(&v::IMPACT_DAMPING, &mut self.impact_damping);
    }
}

impl Model {
    /// The same model under the normal load `preload` (N) at rest: a mass in proportion hangs on a pin rig, and Hertz' law, whose
    /// constant stays, has another slope there. The other normal laws keep theirs.
    ///
    /// ```
    /// use stickslip::model::Model;
    /// let model = Model::parse(include_str!("../../examples/slip-slap/model.toml"))?;
    /// let heavier = model.under_preload(8.0 * 68.67);
    /// assert!((heavier.get("string.mass").unwrap() - 56.0).abs() < 1e-12);
    /// assert!((heavier.get("contact.normal_stiffness").unwrap() - 2.0 * 2.37e7).abs() < 1.0);
    /// # Ok::<(), stickslip::model::ModelError>(())
    /// ```
    pub fn under_preload(&self, preload: f64) -> Self {
        let mut model = self.clone();
        let Some(contact) = &mut model.contact else { return model };
        let part = preload / contact.normal_load;
        contact.normal_load = preload;
        if let Some(Normal { law: NormalLaw::Hertz { exponent }, .. }) = contact.normal {
            contact.normal_stiffness *= part.powf(1.0 - 1.0 / exponent);
        }
        if let Structure::PinRig(pinned) = &mut model.structure {
            pinned.string.mass *= part;
        }
        model
    }

    /// The normal direction of a contact in two directions, with what the effects `normal_hardening` and `impact_damping`
    /// add; `None` without `normal_law`, but of a pin rig, where it is a spring then.
    ///
    /// # Errors
    /// A number outside its bounds; hardening on Hertz' law, which hardens by itself.
    pub fn normal_direction(&self) -> Result<Option<NormalDirection>, LawError> {
        // The pin of a rig rests on a spring if on nothing else.
        let spring = matches!(self.structure, Structure::PinRig(_))
            .then_some(Normal { law: NormalLaw::Linear, impact_damping: 0.0 });
        let of = |contact: Contact| Some((contact, contact.normal.or(spring)?));
        let Some((contact, normal)) = self.contact.and_then(of) else {
            return Ok(None);
        };
        let joint = self.changes().joint;
        let added = joint.normal_cubic_stiffness;
        let law = match normal.law {
            NormalLaw::Cubic { cubic_stiffness } => {
                NormalLaw::Cubic { cubic_stiffness: cubic_stiffness + added }
            }
            law if added == 0.0 => law,
            NormalLaw::Linear => NormalLaw::Cubic { cubic_stiffness: added },
            NormalLaw::Hertz { .. } => return Err(LawError::Hardening),
        };
        let damping = normal.impact_damping + joint.impact_damping;
        NormalDirection::new(law, contact.normal_load, contact.normal_stiffness, damping).map(Some)
    }

    /// The rules of the normal direction.
    pub(super) fn check_normal(&self) -> Result<(), ParameterError> {
        match self.normal_direction() {
            Ok(_) => Ok(()),
            Err(LawError::OutOfBounds { parameter, value, bounds, .. }) => {
                let message = format!("`{parameter}` must be {bounds}, not {value}");
                Err(ParameterError::new(format!("contact.{parameter}"), message))
            }
            Err(other) => Err(ParameterError::new("effect", other.to_string())),
        }
    }

    /// The contact in two directions, if the model has one: its law of friction under the normal force of
    /// [`Model::normal_direction`], effects included. Without `normal_law` the friction of a pin rig is under a constant
    /// load, or under the fraction of its change that the effect `normal_load_variation` says.
    ///
    /// # Errors
    /// A parameter outside its bounds, or a change that a law does not take.
    ///
    /// ```
    /// use stickslip::model::Model;
    /// let model = Model::parse(
    ///     r#"
    ///     schema = "stickslip.model/1"
    ///     kind = "contact"
    ///
    ///     [contact]
    ///     law = "jenkins"
    ///     tangential_stiffness = 3.95e6
    ///     friction_coefficient = 0.6
    ///     normal_load = 68.67
    ///     normal_law = "hertz"
    ///     normal_stiffness = 2.37e7
    ///     impact_damping = 30.0
    ///     "#,
    /// )?;
    /// let contact = model.slip_slap()?.unwrap();
    /// assert!((contact.normal().static_approach() - 1.5 * 68.67 / 2.37e7).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn slip_slap(&self) -> Result<Option<SlipSlap>, LawError> {
        let (Some(normal), Some(law)) = (self.normal_direction()?, self.law_of_any_values()?) else {
            return Ok(None);
        };
        let contact = SlipSlap::new(Arc::from(law.boxed()), normal);
        Ok(Some(match self.contact.and_then(|contact| contact.normal) {
            Some(_) => contact,
            None => contact.with_load_gain(self.changes().joint.load_gain.unwrap_or(0.0)),
        }))
    }
}
