//! Stretching of the structure at large amplitude (Duffing's term).

use super::{Effect, EffectParameter, Kind, Needs, PlaceKind, both_signs};
use crate::vocabulary as v;

pub(super) const EFFECT: Effect = Effect {
    id: "geometric_stiffening",
    title: "Geometric stiffening",
    summary: "Cubic stretching of the structure: k3 x³ (first mass to the ground, or the mid-plane of the beam)",
    explanation: "A slender part that bends must also stretch when its ends cannot come closer. The stiffness then \
          grows with the square of the amplitude: resonances climb with the level whatever the friction does, \
          and odd harmonics appear.",
    confirmation: "Measure the resonance at three levels with the contact locked or removed: the frequency still climbs \
          with the square of the amplitude.",
    parameters: &[EffectParameter {
        quantity: &v::CUBIC_STIFFNESS,
        range: |scales| {
            both_signs(100.0 * scales.structure_force / scales.structure_displacement.powi(3), 0.002)
        },
    }],
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Oscillator, Kind::Beam],
    needs: Needs::Nothing,
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
