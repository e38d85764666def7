//! An effect with its values, as part of a model.

use super::{Changes, Effect, Location, PlaceKind};
use crate::vocabulary::{self as v, Quantity};

/// `[[effect]]` of a model file.
///
/// ```
/// use stickslip::effects::{AppliedEffect, Changes, find};
/// let added = AppliedEffect { effect: find("backlash").unwrap(), location: None, values: vec![2e-4] };
/// let mut changes = Changes::default();
/// added.apply(&mut changes);
/// assert_eq!(changes.joint.half_gap, 2e-4);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedEffect {
    /// Which.
    pub effect: &'static Effect,
    /// Its place, if it has one.
    pub location: Option<Location>,
    /// One value per parameter of the effect, in its unit.
    pub values: Vec<f64>,
}

impl AppliedEffect {
    /// Name, unit and bounds of the parameter at `index`: a bias has the unit of its channel.
    pub fn quantity(&self, index: usize) -> &'static Quantity {
        let quantity = self.effect.parameters[index].quantity;
        if self.effect.place != PlaceKind::Channel || quantity.name != v::BIAS.name {
            return quantity;
        }
        let channel = self.location.as_ref().map(ToString::to_string).unwrap_or_default();
        match channel.split(':').next().unwrap_or_default() {
            "force" | "excitation" | "contact_force" | "normal_load" => &v::BIAS_FORCE,
            "displacement" | "normal_displacement" => &v::BIAS_DISPLACEMENT,
            "velocity" => &v::BIAS_VELOCITY,
            "acceleration" => &v::BIAS_ACCELERATION,
            _ => quantity,
        }
    }

    /// Adds what it changes to `changes`.
    pub fn apply(&self, changes: &mut Changes) {
        (self.effect.apply)(&self.values, self.location.as_ref(), changes);
    }
}
