//! Where the force of a joint jumps.

use super::play::root;
use super::{BASE, Joint, SIDE};
use crate::contact::{Inputs, Jump};

impl Joint {
    /// See [`crate::contact::ContactLaw::jump`]. Where the play closes the damper takes hold at once; one that feeds
    /// energy in lets go where the play opens.
    pub(super) fn jump_on_the_way(&self, state: &[f64], inputs: Inputs) -> Option<Jump> {
        let (gap, damping) = (self.changes.half_gap, self.changes.damping);
        if gap == 0.0 || damping == 0.0 {
            return None;
        }
        let end = self.end(state, inputs);
        let (held, other) = if damping > 0.0 { (end.side, state[SIDE]) } else { (state[SIDE], end.side) };
        if held == 0.0 || held == other {
            return None;
        }
        // The play is just closed where springs and friction behind it have no force.
        let w = self.base.before(&state[BASE..]).0;
        let force = |w: f64| {
            let ((base, base_slope), (spring, slope)) =
                (self.base.force(&state[BASE..], w, end.load), self.spring(w));
            (base + spring, base_slope + slope)
        };
        let between = (w.min(end.displacement), w.max(end.displacement));
        Some(Jump { displacement: root(force, w, between) + held * gap, damping })
    }
}
