//! Slope left in macro-slip (e_t of Valanis' law; Gaul & Lenz 1997).

use super::{ALL_KINDS, Effect, EffectParameter, Needs, PlaceKind, from_zero};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "residual_stiffness",
    title: "Residual stiffness",
    summary: "A spring beside the contact: slope e_t u left in macro-slip",
    explanation: "When the whole interface slips the force may go on rising with displacement: the bodies are also \
          joined by a bolt, a seal, a bent tongue or by asperities that plough. In the loop the upper and \
          lower plateaus are parallel and inclined instead of level.",
    confirmation: "Slip well past the limit at a constant normal load: the slope of the plateau is the residual \
          stiffness, whatever the amplitude.",
    parameters: &[EffectParameter {
        quantity: &v::RESIDUAL_STIFFNESS,
        range: |scales| from_zero(0.9 * scales.stiffness, &[0.03, 0.3]),
    }],
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    apply: |values, _, changes| changes.joint.residual_stiffness = values[0],
    signature: |seen| {
        seen.slip_slope_share.filter(|share| *share > 0.01).map(|share| {
            format!(
                "the loop's plateaus are inclined: their slope is {:.1} % of that in stick",
                100.0 * share
            )
        })
    },
};
