//! A channel with a wrong scale.

use super::{ALL_KINDS, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, experiments, magnitudes};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "sensor_gain",
    title: "Sensor gain",
    summary: "A channel shows too much or too little: gain · y",
    explanation: "A wrong calibration factor, a loose accelerometer, a charge amplifier on the wrong range. One \
          channel is wrong by one factor at every level and frequency, while the others agree.",
    confirmation: "Calibrate, or swap two sensors: the factor stays with the channel.",
    confused_with: &[],
    next_experiment: experiments::SWAP_SENSORS,
    parameters: &[EffectParameter {
        quantity: &v::GAIN,
        neutral: Some(1.0),
        range: |_| magnitudes(0.2, 5.0, &[1.1, 0.9]),
    }],
    part: Part::Sensor,
    place: PlaceKind::Channel,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Columns(
        &["displacement", "velocity", "acceleration"],
        "frequencies, damping ratios and phases have no scale: they are counted against a clock, or are ratios",
    ),
    apply: |values, channel, changes| changes.sensor(channel).gain = values[0],
    signature: |seen| {
        seen.residual_by_value.filter(|correlation| correlation.abs() > 0.3).map(|correlation| {
            format!(
                "the residual is a constant fraction of the channel itself (correlation {correlation:.2})"
            )
        })
    },
};
