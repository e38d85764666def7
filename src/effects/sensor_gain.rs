//! A channel with a wrong scale.

use super::{ALL_KINDS, Effect, EffectParameter, Needs, PlaceKind, magnitudes};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "sensor_gain",
    title: "Sensor gain",
    summary: "A channel shows too much or too little: gain · y",
    explanation: "A wrong calibration factor, a loose accelerometer, a charge amplifier on the wrong range. One \
          channel is wrong by one factor at every level and frequency, while the others agree.",
    confirmation: "Calibrate, or swap two sensors: the factor stays with the channel.",
    parameters: &[EffectParameter { quantity: &v::GAIN, range: |_| magnitudes(0.2, 5.0, &[1.1, 0.9]) }],
    place: PlaceKind::Channel,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    apply: |values, channel, changes| changes.sensor(channel).gain = values[0],
    signature: |seen| {
        seen.residual_by_value.filter(|correlation| correlation.abs() > 0.3).map(|correlation| {
            format!("the residual is a constant share of the channel itself (correlation {correlation:.2})")
        })
    },
};
