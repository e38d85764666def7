//! Play in series with the contact.

use super::{ALL_KINDS, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, experiments, from_zero};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "backlash",
    title: "Backlash",
    summary: "Play of half-width g in series: no force until the slack is taken up after each reversal",
    explanation: "A hole larger than its bolt, a worn pin or a loose key lets the parts move freely before the contact \
          is loaded. After each reversal the force drops to zero, stays there while the slack of twice the \
          half gap is crossed, and then rises again.",
    confirmation: "Move the joint by hand or at the lowest level: within the play there is no force at all. Shim the \
          gap and repeat.",
    confused_with: &[],
    next_experiment: experiments::OTHER_LEVELS,
    parameters: &[EffectParameter {
        quantity: &v::HALF_GAP,
        neutral: Some(0.0),
        // On a structure the largest displacement may be far beyond what the contact needs to yield.
        range: |scales| {
            let yielding = 0.3 * scales.limit / (scales.stiffness * scales.displacement);
            from_zero(0.95 * scales.displacement, &[0.05, 0.2, 0.5, yielding.min(0.9)])
        },
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.half_gap = values[0],
    signature: |seen| {
        seen.plateau_fraction.filter(|fraction| *fraction > 0.02).map(|fraction| {
            format!(
                "after each reversal the force stays near zero over {:.0} % of the stroke",
                100.0 * fraction
            )
        })
    },
};
