//! A limit that depends on the direction of slip.

use super::{
    ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, both_signs, experiments,
};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "asymmetry",
    title: "Asymmetric limit",
    summary: "The limit depends on the direction: limit · (1 ± a)",
    explanation: "Causes are machining marks, inclined surfaces, or a band that tightens in one direction. One plateau \
          of the loop is farther from zero than the other, and even harmonics appear in the response.",
    confirmation: "Turn the part round, or drive it backwards: the larger plateau changes sides. With a zero error of \
          the load cell it does not.",
    confused_with: &[Confusion {
        with: &super::sensor_offset::EFFECT,
        why: "with both, one plateau of the loop is farther from zero than the other",
        experiment: "start a record from rest at a low level, where nothing slips: a zero error shows at once, an \
              asymmetric limit does not; or turn the part round, and the asymmetry changes sides",
    }],
    next_experiment: experiments::OTHER_LEVELS,
    parameters: &[EffectParameter {
        quantity: &v::ASYMMETRY,
        neutral: Some(0.0),
        range: |_| both_signs(0.9, 0.1),
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.asymmetry = values[0],
    signature: |seen| {
        seen.loop_asymmetry.filter(|difference| difference.abs() > 0.02).map(|difference| {
            let even =
                seen.even_harmonics.filter(|fraction| *fraction > 0.6).map_or(String::new(), |fraction| {
                    format!(", and even harmonics hold {:.0} % of the residual's power", 100.0 * fraction)
                });
            format!(
                "the loop's upper and lower plateaus differ by {:.0} % of their height{even}",
                100.0 * difference.abs()
            )
        })
    },
};
