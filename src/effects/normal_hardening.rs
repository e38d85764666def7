//! Cubic stiffness in the normal direction.

use super::{Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, both_signs, experiments};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "normal_hardening",
    title: "Hardening in the normal direction",
    summary: "The normal load grows with k3 δ³ beyond the linear normal stiffness",
    explanation: "Rough or curved surfaces stiffen as they are pressed together: more asperities touch (Hertz, \
          Greenwood and Williamson). The measured load against normal displacement bends upwards in \
          compression.",
    confirmation: "Press the contact quasi-statically and plot load against approach.",
    confused_with: &[],
    next_experiment: experiments::TWO_NORMAL_SPEEDS,
    parameters: &[EffectParameter {
        quantity: &v::NORMAL_CUBIC_STIFFNESS,
        neutral: Some(0.0),
        range: |scales| both_signs(100.0 * scales.normal_load / scales.normal_displacement.powi(3), 0.002),
    }],
    part: Part::NormalDirection,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Contact, Kind::PinRig],
    needs: Needs::NormalMotion,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.normal_cubic_stiffness = values[0],
    signature: |seen| {
        seen.normal_residual_by_cube.filter(|correlation| correlation.abs() > 0.2).map(|correlation| {
            format!("the residual of the normal load follows the cube of the normal displacement (correlation {correlation:.2})")
        })
    },
};
