//! Viscous damping in the contact.

use super::{ALL_KINDS, Effect, EffectParameter, Needs, PlaceKind, both_signs};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "contact_damping",
    title: "Contact damping",
    summary: "A damper beside the contact: c·u̇",
    explanation: "Oil, grease, a polymer layer or wear debris in the gap resists in proportion to the speed. The loop \
          grows rounder and higher as the frequency rises at one amplitude; a dry contact's loop does not know \
          the frequency.",
    confirmation: "Repeat one amplitude at two or three frequencies: the difference of the forces at zero displacement \
          grows in proportion to the frequency.",
    parameters: &[EffectParameter {
        quantity: &v::CONTACT_DAMPING,
        range: |scales| both_signs(30.0 * scales.limit / scales.velocity, 0.003),
    }],
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    apply: |values, _, changes| changes.joint.damping = values[0],
    signature: |seen| {
        seen.residual_by_velocity.filter(|correlation| correlation.abs() > 0.2).map(|correlation| {
            format!("the residual force is proportional to the velocity (correlation {correlation:.2})")
        })
    },
};
