//! A mass that hangs at the contact and vibrates (string and weights).

use super::{Effect, EffectParameter, InResonances, Kind, Needs, Part, PlaceKind, experiments, magnitudes};
use crate::system::HangingMass;
use crate::vocabulary as v;

/// Fractions of the structure's mass to start from, each with every frequency.
const FRACTIONS: [f64; 4] = [0.01, 0.03, 0.08, 1.0];
/// Frequencies to start from, each `STEP` times the one before. What a resonator does is narrow: a fit finds its
/// frequency only from nearby.
const FREQUENCIES: usize = 25;
const STEP: f64 = 1.1;

fn fraction(start: usize) -> f64 {
    FRACTIONS[start / FREQUENCIES]
}

/// Over that of the drive.
fn frequency(start: usize) -> f64 {
    STEP.powi((start % FREQUENCIES) as i32 - FREQUENCIES as i32 / 2)
}

fn starts(of: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..FRACTIONS.len() * FREQUENCIES).map(of).collect()
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
                magnitudes(
                    1e-4 * scales.structure_mass,
                    10.0 * scales.structure_mass,
                    &starts(|start| fraction(start) * scales.structure_mass),
                )
            },
        },
        EffectParameter {
            quantity: &v::HANGING_FREQUENCY,
            neutral: None,
            range: |scales| {
                let starts = starts(|start| frequency(start) * scales.frequency);
                magnitudes(0.05 * scales.frequency, 20.0 * scales.frequency, &starts)
            },
        },
    ],
    part: Part::HungAtContact,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Oscillator, Kind::Beam],
    needs: Needs::Nothing,
    in_resonances: InResonances::Shown,
    apply: |values, _, changes| {
        changes.structure.hanging_masses.push(HangingMass { mass: values[0], frequency: values[1] });
    },
    signature: |seen| {
        seen.frequency_error.filter(|error| error.abs() > 0.001).map(|error| {
            format!("the resonances lie {:.1} % away from the model's at every level", 100.0 * error)
        })
    },
};
