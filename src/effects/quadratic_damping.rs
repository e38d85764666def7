//! Drag of the surrounding medium.

use super::{Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, both_signs, experiments};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "quadratic_damping",
    title: "Quadratic damping",
    summary: "Drag on the structure: q |v| v",
    explanation: "Air or liquid that is pushed aside resists with the square of the speed. Its damping ratio grows in \
          proportion to the amplitude, where friction's falls.",
    confirmation: "Free decay at large amplitude, or two levels at one resonance: the damping ratio is proportional to \
          the amplitude. Change the medium (vacuum, a cover plate).",
    confused_with: &[],
    next_experiment: experiments::HALF_AND_TWICE,
    parameters: &[EffectParameter {
        quantity: &v::QUADRATIC_DAMPING,
        neutral: Some(0.0),
        range: |scales| both_signs(30.0 * scales.structure_force / scales.structure_velocity.powi(2), 0.005),
    }],
    part: Part::Structure,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Oscillator, Kind::Beam],
    needs: Needs::Nothing,
    in_tables: InTables::DampingAlone,
    apply: |values, _, changes| changes.structure.quadratic_damping = values[0],
    signature: |seen| {
        seen.damping_exponent.filter(|exponent| (0.5..1.5).contains(exponent)).map(|exponent| {
            format!(
                "the damping the model lacks grows with amplitude to the power {exponent:.1}; drag gives 1"
            )
        })
    },
};
