//! A limit that falls with the sliding speed (Stribeck 1902).

use super::{
    ALL_KINDS, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, Range, experiments, magnitudes,
};
use crate::vocabulary::{self as v, Scale};

pub(super) static EFFECT: Effect = Effect {
    id: "velocity_weakening",
    title: "Velocity weakening",
    summary: "The limit falls with speed: limit · (1 + δ exp(−|u̇|/v_s))",
    explanation: "Stribeck's effect: at rest the surfaces bond and the limit is higher than in motion. It shows as \
          peaks of the force near the reversals and as lower plateaus in faster records. It makes joints \
          squeal: friction that falls with the speed adds energy to the structure.",
    confirmation: "Slide at constant speeds over two decades at one load and plot friction against speed; or compare a \
          slow with a fast loop of one amplitude.",
    confused_with: &[],
    next_experiment: experiments::OTHER_FREQUENCIES,
    parameters: &[
        EffectParameter {
            quantity: &v::WEAKENING,
            neutral: Some(0.0),
            range: |_| Range { lower: -0.9, upper: 3.0, scale: Scale::Linear, starts: vec![0.3, 0.3, -0.2] },
        },
        EffectParameter {
            quantity: &v::WEAKENING_VELOCITY,
            neutral: None,
            range: |scales| {
                magnitudes(
                    1e-4 * scales.velocity,
                    3.0 * scales.velocity,
                    &[0.3 * scales.velocity, 1.0 * scales.velocity, 0.09 * scales.velocity],
                )
            },
        },
    ],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.weakening = Some((values[0], values[1])),
    signature: |seen| {
        seen.height_by_speed.filter(|change| change.abs() > 0.02).map(|change| {
            format!(
                "the loop's height changes by {:.0} % from the slowest to the fastest motion",
                100.0 * change
            )
        })
    },
};
