//! The catalogue of physical effects that a model may lack: one file each, with the law, the parameters with
//! units and bounds, the signature in the data, and the words for an engineer.
//!
//! An effect changes one of three things, gathered in [`Changes`]: the contact
//! ([`JointChanges`](crate::contact::JointChanges)), the structure
//! ([`StructureChanges`](crate::system::StructureChanges)), or what the sensors show ([`SensorFault`]). The changes
//! are made part of the system's description, so that no solver knows an effect: whatever several effects come to
//! together works in time integration, harmonic balance and FMUs alike.
//!
//! A new effect is a file with an [`Effect`], and its line in [`CATALOGUE`]. Whoever needs to know something of an
//! effect asks for a property of it, never for its id: if no property answers, [`Effect`] lacks one.
//!
//! ```
//! use stickslip::effects;
//! let backlash = effects::find("backlash").unwrap();
//! assert_eq!(backlash.parameters[0].quantity.name, "half_gap");
//! ```

mod applied;
mod changes;
mod effect;
mod experiments;
mod features;
mod location;
mod range;
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
mod sensor_clock_drift;
mod sensor_delay;
mod sensor_gain;
mod sensor_offset;
mod stiffening;
mod support_compliance;
mod velocity_weakening;
mod wear;

pub use applied::AppliedEffect;
pub use changes::{Changes, SensorFault};
pub use effect::{ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind};
pub use features::Features;
pub use location::{Location, LocationError};
pub use range::Range;
use range::{both_signs, from_zero, magnitudes};
pub use scales::Scales;

/// Every effect, in the order of the documentation.
pub static CATALOGUE: [&Effect; 20] = [
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
    &sensor_clock_drift::EFFECT,
];

/// Effects that look like `effect`, each with what the two have in common and what distinguishes them.
///
/// ```
/// use stickslip::effects::{find, look_alikes};
/// let similar: Vec<&str> = look_alikes(find("asymmetry").unwrap()).map(|(effect, _)| effect.id).collect();
/// assert!(similar.contains(&"sensor_offset"));
/// ```
pub fn look_alikes(effect: &Effect) -> impl Iterator<Item = (&'static Effect, &'static Confusion)> {
    CATALOGUE.into_iter().filter_map(|other| Some((other, effect.confusion(other)?)))
}

/// The effect called `id`, if there is one.
///
/// ```
/// assert_eq!(stickslip::effects::find("wear").unwrap().title, "Wear");
/// assert!(stickslip::effects::find("magic").is_none());
/// ```
pub fn find(id: &str) -> Option<&'static Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.id == id)
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
    fn an_effect_vanishes_at_its_neutral_value_which_no_start_is() {
        for effect in CATALOGUE {
            for parameter in effect.parameters {
                let starts = (parameter.range)(&Scales::default()).starts;
                assert!(parameter.neutral.is_none_or(|neutral| !starts.contains(&neutral)), "{}", effect.id);
            }
            assert_eq!(effect.parameters[0].neutral, Some(effect.neutral()), "{}", effect.id);
        }
    }

    #[test]
    fn each_pair_of_look_alikes_stands_in_one_file() {
        for effect in CATALOGUE {
            for pair in effect.confused_with {
                assert!(pair.with.confused_with.iter().all(|back| back.with != effect), "{}", effect.id);
                assert_eq!(effect.confused_with.iter().filter(|two| two.with == pair.with).count(), 1);
            }
        }
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
