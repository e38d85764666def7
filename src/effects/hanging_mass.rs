//! A resonator hung at the contact (seed 2: string and weights).

use super::{Effect, EffectParameter, HangingMass, Kind, Needs, PlaceKind, magnitudes};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "hanging_mass",
    title: "Hanging mass",
    summary: "A resonator hung at the contact: a mass on a string or a soft mount",
    explanation: "The weights that press the contact together hang on a string and move with it. Near the natural \
          frequency of this pendulum or bounce the response has a second, narrow resonance, and above it the \
          mass stands still.",
    confirmation: "Change the length of the string: the narrow resonance moves with it.",
    parameters: &[
        EffectParameter {
            quantity: &v::MASS,
            range: |scales| {
                magnitudes(
                    1e-4 * scales.structure_mass,
                    10.0 * scales.structure_mass,
                    &[0.05 * scales.structure_mass, 0.05 * scales.structure_mass],
                )
            },
        },
        EffectParameter {
            quantity: &v::HANGING_FREQUENCY,
            range: |scales| {
                magnitudes(
                    0.05 * scales.frequency,
                    20.0 * scales.frequency,
                    &[0.7 * scales.frequency, 1.6 * scales.frequency],
                )
            },
        },
    ],
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Oscillator, Kind::Beam],
    needs: Needs::Nothing,
    apply: |values, _, changes| {
        changes.structure.hanging_masses.push(HangingMass { mass: values[0], frequency: values[1] });
    },
    signature: |seen| {
        seen.frequency_error
            .filter(|error| error.abs() > 0.001)
            .map(|error| format!("the resonances lie {:.1} % off the model's at every level", 100.0 * error))
    },
};
