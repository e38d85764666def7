//! A cubic spring in the contact.

use super::{ALL_KINDS, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, both_signs, experiments};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "stiffening",
    title: "Stiffening contact",
    summary: "A cubic spring beside the contact: k3 u³",
    explanation: "Surfaces that conform, a rubber layer or a membrane stiffen as they deform. The ends of the loop \
          point up (or down, for softening), and more with larger amplitude; the middle does not change.",
    confirmation: "Compare the slope near the ends of the stroke at two amplitudes: it grows with the square of the \
          amplitude.",
    confused_with: &[],
    next_experiment: experiments::HALF_AND_TWICE,
    parameters: &[EffectParameter {
        quantity: &v::CUBIC_STIFFNESS,
        neutral: Some(0.0),
        range: |scales| {
            let stiffness = scales.limit / scales.displacement + 0.1 * scales.stiffness;
            let mut range = both_signs(100.0 * stiffness / scales.displacement.powi(2), 0.003);
            // A strong spring moves a structure's resonance so far that no weak one shows the way.
            range.starts.push(10.0 * range.starts[0]);
            range
        },
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.cubic_stiffness = values[0],
    signature: |seen| {
        seen.residual_by_cube.filter(|correlation| correlation.abs() > 0.2).map(|correlation| {
            format!("the residual force follows the cube of the displacement (correlation {correlation:.2})")
        })
    },
};
