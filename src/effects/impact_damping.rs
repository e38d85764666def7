//! Damping of impacts (Hunt & Crossley 1975).

use super::{Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, both_signs, experiments};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "impact_damping",
    title: "Impact damping",
    summary: "Hunt and Crossley's factor 1 + λ δ̇ on the normal load",
    explanation: "Closing surfaces push harder than parting ones at the same distance: energy is lost in every impact. \
          Load against normal displacement makes a loop that closes at zero load, as a damper's would not.",
    confirmation: "Tap the contact closed at several speeds: the coefficient of restitution falls in proportion to the \
          speed.",
    confused_with: &[],
    next_experiment: experiments::TWO_NORMAL_SPEEDS,
    parameters: &[EffectParameter {
        quantity: &v::IMPACT_DAMPING,
        neutral: Some(0.0),
        range: |scales| both_signs(30.0 / scales.normal_velocity, 0.005),
    }],
    part: Part::NormalDirection,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Contact, Kind::PinRig],
    needs: Needs::NormalMotion,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.impact_damping = values[0],
    signature: |seen| {
        seen.normal_residual_by_velocity.filter(|correlation| correlation.abs() > 0.2).map(|correlation| {
            format!(
                "the residual of the normal load follows the normal velocity (correlation {correlation:.2})"
            )
        })
    },
};
