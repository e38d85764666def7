//! A clamp that gives way.

use super::{Effect, EffectParameter, Kind, Needs, PlaceKind, magnitudes};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "support_compliance",
    title: "Compliant clamp",
    summary: "The clamp is a rotational spring instead of rigid",
    explanation: "Bolts, a thin foot or a fixture on the shaker table give way. The lowest resonances are too low at \
          every level, the first the most, and the mode shapes turn at the clamp.",
    confirmation: "Measure the rotation at the clamp, or tighten it and see the frequencies climb.",
    parameters: &[EffectParameter {
        quantity: &v::CLAMP_STIFFNESS,
        range: |scales| {
            magnitudes(
                0.1 * scales.rotational_stiffness,
                1e4 * scales.rotational_stiffness,
                &[10.0 * scales.rotational_stiffness, 100.0 * scales.rotational_stiffness],
            )
        },
    }],
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Beam],
    needs: Needs::Nothing,
    apply: |values, _, changes| changes.structure.clamp_stiffness = Some(values[0]),
    signature: |seen| {
        seen.frequency_error.filter(|error| *error < -0.001).map(|error| {
            format!("at every level the resonances lie {:.1} % below the model's", -100.0 * error)
        })
    },
};
