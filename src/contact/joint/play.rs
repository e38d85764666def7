//! Where a step ends behind the play, with the limit as far as wear and speed leave it.

use super::end::End;
use super::{BASE, Joint, SIDE, SLIP};
use crate::contact::Inputs;

/// More rounds than any motion needs; the bound only stops a NaN.
const ROUNDS: usize = 60;

impl Joint {
    /// Where the step from `state` to `inputs` ends.
    #[inline]
    pub(super) fn end(&self, state: &[f64], inputs: Inputs) -> End {
        let speed = self.speed_factor(inputs.velocity);
        let unworn = inputs.normal_load * speed.0;
        if self.changes.half_gap == 0.0 && self.changes.wear == 0.0 {
            let (displacement, slip) = (inputs.displacement, state[SLIP]);
            return End { displacement, load: unworn, slip, side: 0.0, follows: true, rests: false, speed };
        }
        let load = unworn * self.wear_factor(state[SLIP]).0;
        let mut end = self.behind_play(state, inputs.displacement, load, speed);
        if self.changes.wear != 0.0 && inputs.normal_load > 0.0 {
            // The limit at the end of the step follows from the distance slipped in it, and the other way.
            for _ in 0..ROUNDS {
                let before = end.slip;
                let path = self.base.path(&state[BASE..], end.displacement, end.load);
                let (factor, by_slip) = self.wear_factor(end.slip);
                let error = end.slip - state[SLIP] - path.length;
                let slip = end.slip - error / (1.0 - path.by_load * unworn * by_slip);
                let load = if slip == before { unworn * factor } else { unworn * self.wear_factor(slip).0 };
                end = End { slip, ..self.behind_play(state, inputs.displacement, load, speed) };
                if (slip - before).abs() <= 1e-14 * slip.abs() {
                    break;
                }
            }
        }
        end
    }

    /// Where the end of the law behind the play goes under the load `load` (N).
    fn behind_play(&self, state: &[f64], displacement: f64, load: f64, speed: (f64, f64)) -> End {
        let (gap, slip) = (self.changes.half_gap, state[SLIP]);
        let end = |displacement, side| {
            let follows = side != 0.0;
            End { displacement, load, slip, side, follows, rests: false, speed }
        };
        if gap == 0.0 {
            return End { follows: true, ..end(displacement, 0.0) };
        }
        let (w, load_before) = self.base.before(&state[BASE..]);
        let (low, high) = (displacement - gap, displacement + gap);
        let alone = !self.has_spring();
        if alone && load <= 0.0 {
            // Apart: the play lies evenly on both sides.
            return End { follows: true, ..end(displacement, 0.0) };
        }
        if state[SIDE] == 0.0 && low <= w && w <= high && load_before > 0.0 && (alone || load == load_before)
        {
            return End { rests: true, ..end(w, 0.0) };
        }
        // Force and slope behind the play.
        let force = |w: f64| {
            let ((base, base_slope), (spring, slope)) =
                (self.base.force(&state[BASE..], w, load), self.spring(w));
            (base + spring, base_slope + slope)
        };
        let upper_first = state[SIDE] > 0.0 || (state[SIDE] == 0.0 && w < low);
        if upper_first && force(low).0 >= 0.0 {
            return end(low, 1.0);
        }
        if force(high).0 <= 0.0 {
            return end(high, -1.0);
        }
        if !upper_first && force(low).0 >= 0.0 {
            return end(low, 1.0);
        }
        end(root(force, w, (low, high)), 0.0)
    }
}

/// The zero of an increasing `force`, which is below zero at the lower end and above at the upper: Newton's
/// steps from `start`, halving where they leave the bracket.
pub(super) fn root(force: impl Fn(f64) -> (f64, f64), start: f64, (mut low, mut high): (f64, f64)) -> f64 {
    let mut at = start.max(low).min(high);
    for _ in 0..ROUNDS {
        let (value, slope) = force(at);
        if value == 0.0 {
            break;
        }
        if value < 0.0 {
            low = at
        } else {
            high = at
        }
        let newton = at - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == at || high - low <= f64::EPSILON * at.abs() {
            break;
        }
        at = next;
    }
    at
}
