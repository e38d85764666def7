//! Viscous damping in the contact.

use super::{
    ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, both_signs, experiments,
};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "contact_damping",
    title: "Contact damping",
    summary: "A damper beside the contact: c·u̇",
    explanation: "Oil, grease, a polymer layer or wear debris in the gap resists in proportion to the speed. The loop \
          grows rounder and higher as the frequency rises at one amplitude; the loop of a dry contact does not \
          depend on the frequency.",
    confirmation: "Repeat one amplitude at two or three frequencies: the difference of the forces at zero displacement \
          grows in proportion to the frequency.",
    confused_with: &[
        Confusion {
            with: &super::sensor_delay::EFFECT,
            why: "a delayed channel turns a line into an ellipse, as a damper does",
            experiment: "repeat one level at two frequencies far apart: the error that a delay causes grows with the \
                  stiffness, that of a damper does not; or swap the sensors, and the delay stays with the channel",
        },
        Confusion {
            with: &super::quadratic_damping::EFFECT,
            why: "both resist the motion, and at one level both can take the same energy",
            experiment: "repeat one frequency at two levels: a damper's force grows with the speed, drag with its square",
        },
        Confusion {
            with: &super::velocity_weakening::EFFECT,
            why: "with both the height of the loop depends on the speed",
            experiment: "repeat one amplitude at speeds over two decades and plot the height of the loop against the \
                  logarithm of the speed: with weakening the curve becomes level, with a damper it does not",
        },
    ],
    next_experiment: experiments::OTHER_FREQUENCIES,
    parameters: &[EffectParameter {
        quantity: &v::CONTACT_DAMPING,
        neutral: Some(0.0),
        range: |scales| both_signs(30.0 * scales.limit / scales.velocity, 0.003),
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::Nothing,
    in_tables: InTables::DampingAlone,
    apply: |values, _, changes| changes.joint.damping = values[0],
    signature: |seen| {
        seen.residual_by_velocity.filter(|correlation| correlation.abs() > 0.2).map(|correlation| {
            format!("the residual force is proportional to the velocity (correlation {correlation:.2})")
        })
    },
};
