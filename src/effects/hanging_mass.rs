//! A mass that hangs at the contact and vibrates (string and weights).

use super::{Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, experiments, magnitudes};
use crate::system::HangingMass;
use crate::vocabulary as v;

/// Frequencies to start from on either side of the drive's, each `STEP` times the one before. What a resonator does is
/// narrow: a fit finds its frequency only from nearby.
const FREQUENCIES: i32 = 12;
const STEP: f64 = 1.1;

/// Over that of the drive, the nearest first.
fn frequencies() -> impl Iterator<Item = f64> {
    let both = |k: i32| [STEP.powi(k), STEP.powi(-k)];
    std::iter::once(1.0).chain((1..=FREQUENCIES).flat_map(both))
}

pub(super) static EFFECT: Effect = Effect {
    id: "hanging_mass",
    title: "Hanging mass",
    summary: "A resonator hung at the contact: a mass on a string or a soft mount",
    explanation: "The weights that press the contact together hang on a string and move with it. Near the natural \
          frequency of these weights the response has a second, narrow resonance; far above it the weights hardly \
          move.",
    confirmation: "Change the length of the string: the narrow resonance moves with it.",
    confused_with: &[],
    next_experiment: experiments::SECOND_MODE,
    parameters: &[
        EffectParameter {
            quantity: &v::MASS,
            neutral: Some(0.0),
            range: |scales| {
                let mass = scales.structure_mass;
                magnitudes(1e-4 * mass, 10.0 * mass, &frequencies().map(|_| 0.01 * mass).collect::<Vec<_>>())
            },
        },
        EffectParameter {
            quantity: &v::HANGING_FREQUENCY,
            neutral: None,
            range: |scales| {
                let starts: Vec<f64> = frequencies().map(|ratio| ratio * scales.frequency).collect();
                magnitudes(0.05 * scales.frequency, 20.0 * scales.frequency, &starts)
            },
        },
    ],
    part: Part::HungAtContact,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Oscillator, Kind::Beam, Kind::PinRig],
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| {
        changes.structure.hanging_masses.push(HangingMass { mass: values[0], frequency: values[1] });
    },
    signature: |seen| {
        seen.frequency_error.filter(|error| error.abs() > 0.001).map(|error| {
            format!("the resonances lie {:.1} % away from the model's at every level", 100.0 * error)
        })
    },
};
