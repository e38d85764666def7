//! Stretching of the structure at large amplitude (Duffing's term).

use super::{
    Confusion, Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, both_signs, experiments,
};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "geometric_stiffening",
    title: "Geometric stiffening",
    summary: "Cubic stretching of the structure: k3 x³ (first mass to the ground, or the mid-plane of the beam)",
    explanation: "A slender part that bends must also stretch when its ends cannot come closer. The stiffness then \
          grows with the square of the amplitude: resonance frequencies rise with the level, with or without \
          friction, and odd harmonics appear.",
    confirmation: "Measure the resonance at three levels with the contact locked or removed: the frequency still rises \
          with the square of the amplitude.",
    confused_with: &[Confusion {
        with: &super::stiffening::EFFECT,
        why: "both raise the resonance with the square of the amplitude",
        experiment: "measure a second mode, or lift the contact off: the stiffening of the structure stays",
    }],
    next_experiment: experiments::HALF_AND_TWICE,
    parameters: &[EffectParameter {
        quantity: &v::CUBIC_STIFFNESS,
        neutral: Some(0.0),
        range: |scales| {
            both_signs(100.0 * scales.structure_force / scales.structure_displacement.powi(3), 0.002)
        },
    }],
    part: Part::Structure,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Oscillator, Kind::Beam],
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.structure.cubic_stiffness = values[0],
    signature: |seen| {
        seen.frequency_by_level.filter(|change| *change > 0.002).map(|change| {
            format!(
                "the resonance climbs by {:.1} % with the level, which the model does not show",
                100.0 * change
            )
        })
    },
};
