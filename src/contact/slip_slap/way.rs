//! The way of a step, and the instant at which the bodies part or meet.

use super::SlipSlap;
use super::normal::{NormalDirection, crossing};
use crate::contact::Inputs;

/// Motion at the end of a step: `[tangential ξ, normal η]`, η positive where it opens the contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlipSlapInputs {
    /// ξ and η (m).
    pub displacement: [f64; 2],
    /// ξ̇ and η̇ (m/s).
    pub velocity: [f64; 2],
}

/// Numbers that say where a way ends: ξ, η and their rates.
pub(super) const MOTION: usize = 4;

/// What derivatives are taken by: the motion at the end of the way, then that at its start.
const ENDS: usize = 2 * MOTION;

/// A way along which displacements and rates run linearly.
pub(super) struct Way {
    /// Motion at its end.
    pub to: [f64; MOTION],
    /// N_c at its end (N), by η (N/m) and η̇ (N s/m).
    pub normal: [f64; 3],
    /// Where the bodies part or meet, if they do.
    pub event: Option<Piece>,
    /// Its end.
    pub end: Piece,
}

/// What the law of friction sees at a place of the way, and its derivatives: displacement, velocity and load, each by the
/// motion at the end of the way and at its start.
pub(super) struct Piece {
    pub inputs: Inputs,
    pub by: [[f64; ENDS]; 3],
}

impl Way {
    /// From `state`, which begins with the motion.
    pub fn new(contact: &SlipSlap, state: &[f64], inputs: SlipSlapInputs) -> Self {
        let direction = &contact.normal;
        let from = [state[0], state[1], state[2], state[3]];
        let SlipSlapInputs { displacement, velocity } = inputs;
        let to = [displacement[0], displacement[1], velocity[0], velocity[1]];
        let normal = direction.force_and_slopes(to[1], to[3]);
        let before = direction.force(from[1], from[3]);
        let event = match (before > 0.0, normal[0] > 0.0) {
            (closed, after) if closed == after => None,
            (parts, _) => {
                let piece = Piece::event(direction, from, to, parts);
                let inputs = Inputs { normal_load: contact.acting(0.0), ..piece.inputs };
                Some(Piece { inputs, ..piece })
            }
        };
        let mut by = [[0.0; ENDS]; 3];
        by[0][0] = 1.0;
        by[1][2] = 1.0;
        by[2][1] = contact.load_gain * normal[1];
        by[2][3] = contact.load_gain * normal[2];
        let inputs = Inputs { displacement: to[0], velocity: to[2], normal_load: contact.acting(normal[0]) };
        Self { to, normal, event, end: Piece { inputs, by } }
    }
}

impl Piece {
    /// Where the bodies part, or meet: N_c vanishes with the spring's approach or with the damping's factor. They touch
    /// while both are above zero, so that the first to vanish parts them and the last to appear lets them meet.
    fn event(direction: &NormalDirection, from: [f64; MOTION], to: [f64; MOTION], parts: bool) -> Self {
        let by_spring = (1, crossing(from[1], to[1], direction.static_approach()));
        let by_damping = (3, crossing(from[3], to[3], 1.0 / direction.impact_damping()));
        // Of what does not cross the limit, the place is zero.
        let first = match (by_spring.1 > 0.0, by_damping.1 > 0.0) {
            (true, true) => (by_damping.1 < by_spring.1) == parts,
            (_, damping) => damping,
        };
        let (cause, place) = if first { by_damping } else { by_spring };
        let span = to[cause] - from[cause];
        let at = |motion: usize| from[motion] + place * (to[motion] - from[motion]);
        let by = |motion: usize| {
            let mut row = [0.0; ENDS];
            row[motion] = place;
            row[MOTION + motion] = 1.0 - place;
            if span != 0.0 {
                let speed = (to[motion] - from[motion]) / span;
                row[cause] -= place * speed;
                row[MOTION + cause] -= (1.0 - place) * speed;
            }
            row
        };
        let inputs = Inputs { displacement: at(0), velocity: at(2), normal_load: 0.0 };
        Self { inputs, by: [by(0), by(2), [0.0; ENDS]] }
    }
}
