//! A channel with a delay.

use super::{ALL_KINDS, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, both_signs, experiments};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "sensor_delay",
    title: "Sensor delay",
    summary: "A channel shows the motion late: y(t − τ)",
    explanation: "Filters, a slow amplifier or channels that are not sampled together shift one signal against the \
          others. A delay makes straight lines into ellipses, whose area grows with the frequency, and looks \
          like damping, positive or negative.",
    confirmation: "Feed one signal to all channels, or swap two of them: the delay stays with the channel.",
    confused_with: &[],
    next_experiment: experiments::SWAP_SENSORS,
    parameters: &[EffectParameter {
        quantity: &v::DELAY,
        neutral: Some(0.0),
        range: |scales| both_signs((20.0 * scales.sample_step).min(0.1 / scales.frequency), 0.05),
    }],
    part: Part::Sensor,
    place: PlaceKind::Channel,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Columns(
        &["phase"],
        "a delay shows in phases: frequencies, damping ratios and amplitudes have no time in which a sensor could be late",
    ),
    apply: |values, channel, changes| changes.sensor(channel).delay = values[0],
    signature: |seen| {
        seen.residual_by_rate.filter(|correlation| correlation.abs() > 0.2).map(|correlation| {
            format!(
                "the residual follows the rate of change of the channel itself (correlation {correlation:.2})"
            )
        })
    },
};
