//! A mass on the structure.

use super::{
    Confusion, Effect, EffectParameter, InTables, Kind, Location, Needs, Part, PlaceKind, both_signs,
    experiments,
};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "added_mass",
    title: "Added mass",
    summary: "A mass on the structure that the model lacks, or has too much",
    explanation: "A sensor, its cable, the stinger and head of a shaker, or a part left out of the model. Every \
          resonance in which the place moves is lower than the model's, by the same ratio at every level; it is higher \
          where the mass is below zero, because the model has too much.",
    confirmation: "Weigh what is attached; put a known mass at the place: the frequencies must shift as predicted.",
    confused_with: &[
        Confusion {
            with: &super::support_compliance::EFFECT,
            why: "both lower the first resonance by the same ratio at every level",
            experiment: "measure a second mode: an added mass matters where the mode moves, a soft clamp where it bends",
        },
        Confusion {
            with: &super::sensor_gain::EFFECT,
            why: "a larger mass moves less, and a sensor of too small a gain shows less",
            experiment: "fix a known mass beside the sensor: the frequencies must move as they should, whatever the sensor \
                  shows",
        },
    ],
    next_experiment: experiments::SECOND_MODE,
    parameters: &[EffectParameter {
        quantity: &v::ADDED_MASS,
        neutral: Some(0.0),
        range: |scales| both_signs(scales.structure_mass, 0.02),
    }],
    part: Part::Structure,
    place: PlaceKind::Structure,
    kinds: &[Kind::Oscillator, Kind::Beam, Kind::PinRig],
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, location, changes| {
        if let Some(place) = location.and_then(Location::place) {
            changes.structure.added_masses.push((place, values[0]));
        }
    },
    signature: |seen| {
        seen.frequency_error.filter(|error| error.abs() > 0.001).map(|error| {
            let side = if error < 0.0 { "below" } else { "above" };
            format!("at every level the resonances lie {:.1} % {side} the model's", 100.0 * error.abs())
        })
    },
};
