//! The catalogue of physical effects that a model may lack: one file each, with the law, the parameters with
//! units and bounds, the signature in the data, and the words for an engineer.
//!
//! An effect changes one of three things, gathered in [`Changes`]: the law of the contact ([`JointChanges`](crate::contact::JointChanges)),
//! the structure ([`StructureChanges`](crate::system::StructureChanges)), or what the sensors show ([`SensorFault`]). The solvers know the
//! changes, never the effects: whatever several effects come to together works in time integration, harmonic
//! balance and FMUs alike.
//!
//! ```
//! use stickslip::effects;
//! let backlash = effects::find("backlash").unwrap();
//! assert_eq!(backlash.parameters[0].quantity.name, "half_gap");
//! ```

mod applied;
mod changes;
mod features;
mod location;
mod scales;

mod added_mass;
mod asymmetry;
mod backlash;
mod contact_damping;
mod geometric_stiffening;
mod hanging_mass;
mod impact_damping;
mod micro_slip;
mod normal_hardening;
mod normal_load_variation;
mod quadratic_damping;
mod residual_stiffness;
mod sensor_delay;
mod sensor_gain;
mod sensor_offset;
mod stiffening;
mod support_compliance;
mod velocity_weakening;
mod wear;

pub use applied::AppliedEffect;
pub use changes::{Changes, SensorFault};
pub use features::Features;
pub use location::{Location, LocationError};
pub use scales::Scales;

use crate::vocabulary::{Quantity, Scale};

/// An entry of the catalogue.
pub struct Effect {
    /// The name in files and on the command line: `backlash`.
    pub id: &'static str,
    /// The name for people: `Backlash`.
    pub title: &'static str,
    /// What it adds, in one line, with the formula.
    pub summary: &'static str,
    /// One paragraph for an engineer: what it is and where it comes from.
    pub explanation: &'static str,
    /// How to confirm it by inspection or by one more test.
    pub confirmation: &'static str,
    /// The parameters, in the order of [`AppliedEffect::values`].
    pub parameters: &'static [EffectParameter],
    /// Whether it sits somewhere, and what kind of place that is.
    pub place: PlaceKind,
    /// The kinds of model it can be added to.
    pub kinds: &'static [Kind],
    /// What a record must hold for the effect to show at all.
    pub needs: Needs,
    /// Adds the effect with `values` (one per parameter, SI) at a place to the changes.
    pub apply: fn(values: &[f64], location: Option<&Location>, changes: &mut Changes),
    /// What of it shows in the views of the residual, as a sentence; `None` when nothing does. It explains a
    /// verdict and never decides it.
    pub signature: fn(&Features) -> Option<String>,
}

/// A parameter of an effect.
pub struct EffectParameter {
    /// Name, unit, legal values.
    pub quantity: &'static Quantity,
    /// What a fit may try, on a problem of these magnitudes.
    pub range: fn(&Scales) -> Range,
}

/// Bounds and starting values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// Smallest value, legal itself.
    pub lower: f64,
    /// Largest value, legal itself.
    pub upper: f64,
    /// How a fit steps.
    pub scale: Scale,
    /// Values to start from, each in a fit of its own; both signs where both are possible. The parameters of
    /// an effect have equally many.
    pub starts: Vec<f64>,
}

/// What kind of place an effect sits at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaceKind {
    /// None, or the only one there is: the contact, the clamp.
    Nowhere,
    /// A mass of an oscillator or a position on a beam: `at = "m2"`, `at = "x=0.55"`.
    Structure,
    /// A measured channel: `channel = "displacement:m1"`.
    Channel,
}

/// `kind` of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A bare contact with prescribed motion.
    Contact,
    /// Masses and springs.
    Oscillator,
    /// The beam with a frictional support.
    Beam,
}

impl Kind {
    /// The name in model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Oscillator => "oscillator",
            Self::Beam => "beam",
        }
    }
}

/// All kinds.
pub const ALL_KINDS: &[Kind] = &[Kind::Contact, Kind::Oscillator, Kind::Beam];

/// What a record must hold for an effect to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Nothing beyond what its kind of model needs.
    Nothing,
    /// A measured normal load that varies.
    VaryingNormalLoad,
    /// A measured normal displacement and normal load, and a model with `contact.normal_stiffness`.
    NormalMotion,
    /// A start from rest: over a steady state the effect has no meaning.
    Transient,
}

/// Every effect, in the order of the documentation.
pub static CATALOGUE: [&Effect; 19] = [
    &micro_slip::EFFECT,
    &residual_stiffness::EFFECT,
    &normal_load_variation::EFFECT,
    &contact_damping::EFFECT,
    &velocity_weakening::EFFECT,
    &wear::EFFECT,
    &backlash::EFFECT,
    &stiffening::EFFECT,
    &asymmetry::EFFECT,
    &geometric_stiffening::EFFECT,
    &quadratic_damping::EFFECT,
    &added_mass::EFFECT,
    &support_compliance::EFFECT,
    &hanging_mass::EFFECT,
    &normal_hardening::EFFECT,
    &impact_damping::EFFECT,
    &sensor_delay::EFFECT,
    &sensor_gain::EFFECT,
    &sensor_offset::EFFECT,
];

/// The effect called `id`, if there is one.
pub fn find(id: &str) -> Option<&'static Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.id == id)
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl std::fmt::Debug for Effect {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Effect({})", self.id)
    }
}

/// A range from zero to `upper` with starts at shares of it.
fn from_zero(upper: f64, shares: &[f64]) -> Range {
    Range { lower: 0.0, upper, scale: Scale::Linear, starts: shares.iter().map(|s| s * upper).collect() }
}

/// A range `±size` with starts at `±share·size`.
fn both_signs(size: f64, share: f64) -> Range {
    Range { lower: -size, upper: size, scale: Scale::Linear, starts: vec![share * size, -share * size] }
}

/// A range of magnitudes from `lower` to `upper`, both above zero.
fn magnitudes(lower: f64, upper: f64, starts: &[f64]) -> Range {
    Range { lower, upper, scale: Scale::Logarithmic, starts: starts.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_found() {
        for (index, effect) in CATALOGUE.iter().enumerate() {
            assert_eq!(CATALOGUE.iter().position(|other| other == effect), Some(index));
            assert_eq!(find(effect.id), Some(*effect));
        }
        assert_eq!(find("magic"), None);
    }

    #[test]
    fn ranges_hold_their_starts_and_legal_values() {
        let scales = Scales::default();
        for effect in CATALOGUE {
            let ranges: Vec<Range> = effect.parameters.iter().map(|p| (p.range)(&scales)).collect();
            for (parameter, range) in effect.parameters.iter().zip(&ranges) {
                assert_eq!(range.starts.len(), ranges[0].starts.len(), "{}", effect.id);
                assert!(range.lower < range.upper, "{}", effect.id);
                for &value in range.starts.iter().chain([&range.lower, &range.upper]) {
                    assert!((range.lower..=range.upper).contains(&value), "{}: {value}", effect.id);
                    assert!(parameter.quantity.min.is_none_or(|min| value >= min), "{}", effect.id);
                    assert!(parameter.quantity.max.is_none_or(|max| value <= max), "{}", effect.id);
                }
            }
        }
    }

    #[test]
    fn every_effect_changes_something() {
        for effect in CATALOGUE {
            let values: Vec<f64> =
                effect.parameters.iter().map(|p| (p.range)(&Scales::default()).starts[0]).collect();
            let location = match effect.place {
                PlaceKind::Nowhere => None,
                PlaceKind::Structure => Some(Location::Mass("m1".to_owned())),
                PlaceKind::Channel => Some(Location::Channel("force".to_owned())),
            };
            let mut changes = Changes::default();
            (effect.apply)(&values, location.as_ref(), &mut changes);
            assert_ne!(changes, Changes::default(), "{}", effect.id);
        }
    }
}
