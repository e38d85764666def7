//! A limit that changes with the slip distance.

use super::{ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, both_signs};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "wear",
    title: "Wear",
    summary: "The limit changes with the distance slipped: limit · (1 + w s)",
    explanation: "Sliding polishes or roughens the surfaces, removes a coating, or makes debris. The limit drifts with \
          the distance travelled in slip, not with time: the loop's height changes from cycle to cycle, and \
          stays constant while the contact sticks.",
    confirmation: "Run many cycles at one amplitude and plot the loop's height against the distance slipped; then stop \
          for a while: wear stays, a temperature effect comes back.",
    confused_with: &[Confusion {
        with: &super::velocity_weakening::EFFECT,
        why: "with both the height of the loop changes from record to record",
        experiment: "repeat the first record at the end: wear stays, weakening comes and goes with the speed",
    }],
    next_experiment: "repeat the first record at the end of the test: what has worn stays worn",
    parameters: &[EffectParameter {
        quantity: &v::RATE,
        neutral: Some(0.0),
        range: |scales| both_signs(3.0 / scales.travel, 0.05),
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Transient,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.wear = values[0],
    signature: |seen| {
        seen.height_per_slip.filter(|rate| rate.abs() > 0.0).map(|rate| {
            format!(
                "the loop's height changes from cycle to cycle, by {:.1} % per millimetre of slip",
                0.1 * rate
            )
        })
    },
};
