//! How much of a contact slips, as a number between stick and slip.

use crate::contact::{ContactLaw, Inputs, SlipState};

/// How far beyond the displacement at which a slider of the whole stiffness would yield everything slips.
const FAR: f64 = 1e6;

/// Tangents (N/m) of a law in stick and in full slip.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlipFraction {
    stuck: f64,
    slipping: f64,
}

impl SlipFraction {
    /// Of `law`, under a normal load (N) that it usually bears.
    pub fn new(law: &dyn ContactLaw, normal_load: f64) -> Self {
        let normal_load = if normal_load > 0.0 { normal_load } else { 1.0 };
        let (mut memory, mut next) = (vec![0.0; law.state_len()], vec![0.0; law.state_len()]);
        law.set_state(0.0, normal_load, 0.0, &mut memory);
        let mut tangent = |displacement: f64| {
            let inputs = Inputs { displacement, velocity: 0.0, normal_load };
            law.step(&memory, inputs, &mut next).tangents.displacement
        };
        let stuck = tangent(0.0);
        Self { stuck, slipping: tangent(FAR * law.limit(normal_load) / stuck) }
    }

    #[inline]
    /// The share of the sliders that do not stick, by stiffness, where the law's tangent is `tangent` (N/m).
    pub fn of(&self, tangent: f64, state: SlipState) -> f64 {
        // One slider alone needs no division.
        if tangent == self.stuck && state != SlipState::Separated {
            return 0.0;
        }
        if tangent == self.slipping && self.slipping < self.stuck {
            return 1.0;
        }
        let share = (self.stuck - tangent) / (self.stuck - self.slipping);
        match state {
            SlipState::Separated => 1.0,
            // A law that cannot slip has no such difference.
            _ if share.is_finite() => share.clamp(0.0, 1.0),
            _ => 0.0,
        }
    }
}
