//! A mass on the structure.

use super::{Effect, EffectParameter, Kind, Location, Needs, PlaceKind, magnitudes};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "added_mass",
    title: "Added mass",
    summary: "A mass on the structure that the model lacks",
    explanation: "A sensor, its cable, the stinger and head of a shaker, or a part left out of the model. Every \
          resonance in which the place moves is lower than the model's, by the same ratio at every level.",
    confirmation: "Weigh what is attached; put a known mass at the place and see the frequencies shift as predicted.",
    parameters: &[EffectParameter {
        quantity: &v::MASS,
        range: |scales| {
            magnitudes(1e-4 * scales.structure_mass, scales.structure_mass, &[0.02 * scales.structure_mass])
        },
    }],
    place: PlaceKind::Structure,
    kinds: &[Kind::Oscillator, Kind::Beam],
    needs: Needs::Nothing,
    apply: |values, location, changes| {
        if let Some(place) = location.and_then(Location::place) {
            changes.structure.added_masses.push((place, values[0]));
        }
    },
    signature: |seen| {
        seen.frequency_error.filter(|error| *error < -0.001).map(|error| {
            format!("at every level the resonances lie {:.1} % below the model's", -100.0 * error)
        })
    },
};
