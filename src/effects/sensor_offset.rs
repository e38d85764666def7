//! A channel with a wrong zero.

use super::{ALL_KINDS, Effect, EffectParameter, Needs, PlaceKind, both_signs};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "sensor_offset",
    title: "Sensor offset",
    summary: "A channel shows a constant too much: y + b",
    explanation: "A zero that was not set, drift of an amplifier, a static preload that the model does not have. The \
          residual has a mean, and nothing else.",
    confirmation: "Read the channel with the machine at rest and unloaded.",
    parameters: &[EffectParameter {
        quantity: &v::BIAS,
        range: |scales| both_signs(3.0 * scales.channel, 0.02),
    }],
    place: PlaceKind::Channel,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    apply: |values, channel, changes| changes.sensor(channel).bias = values[0],
    signature: |seen| {
        seen.residual_mean
            .filter(|share| share.abs() > 0.2)
            .map(|share| format!("the residual has a mean of {:.0} % of its size", 100.0 * share))
    },
};
