//! A compliant clamp.

use super::{Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, experiments, magnitudes};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "support_compliance",
    title: "Compliant clamp",
    summary: "The clamp is a rotational spring instead of rigid",
    explanation: "Bolts, a thin foot or a fixture on the shaker table deform. The lowest resonance frequencies are too \
          low at every level, the first the most, and the mode shapes rotate at the clamp.",
    confirmation: "Measure the rotation at the clamp, or tighten the clamp: the frequencies must rise.",
    confused_with: &[],
    next_experiment: experiments::SECOND_MODE,
    parameters: &[EffectParameter {
        quantity: &v::CLAMP_STIFFNESS,
        neutral: Some(f64::INFINITY),
        range: |scales| {
            magnitudes(
                0.1 * scales.rotational_stiffness,
                1e4 * scales.rotational_stiffness,
                &[10.0 * scales.rotational_stiffness, 100.0 * scales.rotational_stiffness],
            )
        },
    }],
    part: Part::Structure,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Beam, Kind::PinRig],
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.structure.clamp_stiffness = Some(values[0]),
    signature: |seen| {
        seen.frequency_error.filter(|error| *error < -0.001).map(|error| {
            format!("at every level the resonances lie {:.1} % below the model's", -100.0 * error)
        })
    },
};
