//! Gradual slip below the limit (Iwan 1966: distributed yield instead of one slider).

use super::{
    ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, experiments, from_zero,
};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "micro_slip",
    title: "Micro-slip",
    summary: "Slip sets in gradually: the yield displacements of many sliders spread over (1 ± spread) times their \
          mean",
    explanation: "The pressure over a contact is not uniform, so its parts do not slip at one instant: the edge slips \
          first, the middle last. The force changes gradually from stick to slip, without a corner, and a little \
          energy is lost even at amplitudes far below the limit. A model with one slider shows neither.",
    confirmation: "Load the joint slowly to half of its friction limit and back: with micro-slip the small loop has an \
          area that grows with the third power of the amplitude; one slider gives a straight line.",
    confused_with: &[Confusion {
        with: &super::backlash::EFFECT,
        why: "both lower the mean stiffness of a small loop",
        experiment: "move the joint slowly around zero at the lowest level: within a play there is no force at all, with \
              gradual slip there is the full stiffness",
    }],
    next_experiment: experiments::OTHER_LEVELS,
    parameters: &[EffectParameter {
        quantity: &v::SPREAD,
        neutral: Some(0.0),
        range: |_| from_zero(1.0, &[0.5, 0.95]),
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.spread = values[0],
    signature: |seen| {
        let bend = seen.corner_fraction.filter(|fraction| *fraction > 0.15).map(|fraction| {
            format!(
                "the loop bends over gradually: its slope falls by {:.0} % before slip is complete",
                100.0 * fraction
            )
        });
        let fall = seen.frequency_by_level.filter(|change| *change < -0.002);
        bend.or_else(|| {
            fall.map(|change| {
                format!(
                    "the resonance falls by {:.1} % more with the level than the model's: some of the contact slips \
                     long before the limit",
                    -100.0 * change
                )
            })
        })
    },
};
