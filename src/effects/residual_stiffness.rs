//! Stiffness in macro-slip (e_t of Valanis' law; Gaul & Lenz 1997).

use super::{
    ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, experiments, from_zero,
};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "residual_stiffness",
    title: "Residual stiffness",
    summary: "A spring beside the contact: the force keeps the slope e_t in macro-slip",
    explanation: "When the whole interface slips the force may go on rising with displacement: the bodies are also \
          joined by a bolt, a seal, a bent tongue or by asperities that plough. In the loop the upper and \
          lower plateaus are parallel and inclined instead of level.",
    confirmation: "Slip well past the limit at a constant normal load: the slope of the plateau is the residual \
          stiffness, whatever the amplitude.",
    confused_with: &[Confusion {
        with: &super::stiffening::EFFECT,
        why: "both make the force rise further in slip",
        experiment: "slip farther than in any record so far: a straight plateau means a spring, a bent one a stiffening \
              contact",
    }],
    next_experiment: experiments::OTHER_LEVELS,
    parameters: &[EffectParameter {
        quantity: &v::RESIDUAL_STIFFNESS,
        neutral: Some(0.0),
        range: |scales| from_zero(0.9 * scales.stiffness, &[0.03, 0.3]),
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.residual_stiffness = values[0],
    signature: |seen| {
        seen.slip_slope_fraction.filter(|fraction| *fraction > 0.01).map(|fraction| {
            format!(
                "the loop's plateaus are inclined: their slope is {:.1} % of that in stick",
                100.0 * fraction
            )
        })
    },
};
