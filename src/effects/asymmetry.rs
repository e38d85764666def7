//! A limit that depends on the direction of slip.

use super::{ALL_KINDS, Effect, EffectParameter, Needs, PlaceKind, both_signs};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "asymmetry",
    title: "Asymmetric limit",
    summary: "The limit depends on the direction: limit · (1 ± a)",
    explanation: "Machining marks, inclined surfaces, a band that winds itself tight in one direction. One plateau of \
          the loop lies higher than the other is low, and even harmonics appear in the response.",
    confirmation: "Turn the part round, or drive it backwards: the high plateau changes sides. A shifted zero of the \
          load cell does not.",
    parameters: &[EffectParameter { quantity: &v::ASYMMETRY, range: |_| both_signs(0.9, 0.1) }],
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    apply: |values, _, changes| changes.joint.asymmetry = values[0],
    signature: |seen| {
        seen.loop_asymmetry.filter(|difference| difference.abs() > 0.02).map(|difference| {
            let even = seen.even_harmonics.filter(|share| *share > 0.6).map_or(String::new(), |share| {
                format!(", and even harmonics hold {:.0} % of the residual's power", 100.0 * share)
            });
            format!(
                "the loop's upper and lower plateaus differ by {:.0} % of their height{even}",
                100.0 * difference.abs()
            )
        })
    },
};
