//! A channel with a wrong zero.

use super::{ALL_KINDS, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, both_signs, experiments};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "sensor_offset",
    title: "Sensor offset",
    summary: "A channel shows a constant too much: y + b",
    explanation: "A zero that was not set, drift of an amplifier, a static preload that the model does not have. The \
          residual has a mean, and nothing else.",
    confirmation: "Read the channel with the machine at rest and unloaded.",
    confused_with: &[],
    next_experiment: experiments::SWAP_SENSORS,
    parameters: &[EffectParameter {
        quantity: &v::BIAS,
        neutral: Some(0.0),
        range: |scales| both_signs(3.0 * scales.channel, 0.02),
    }],
    part: Part::Sensor,
    place: PlaceKind::Channel,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Columns(
        &[],
        "a table holds frequencies, damping ratios and harmonics: a constant is in none of them",
    ),
    apply: |values, channel, changes| changes.sensor(channel).bias = values[0],
    signature: |seen| {
        seen.residual_mean
            .filter(|fraction| fraction.abs() > 0.2)
            .map(|fraction| format!("the residual has a mean of {:.0} % of its size", 100.0 * fraction))
    },
};
