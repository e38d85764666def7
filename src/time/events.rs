//! Where a step must end: reversals of the contact displacement and changes of the slip state.

use super::propagator::NODES;
use crate::contact::SlipState;

/// A velocity below this part of the largest in the step is a reversal reached. What the displacement
/// overshoots is of the square of it.
const REVERSAL_PRECISION: f64 = 1e-4;

/// A change of slip state is located to this part of the step: the force is in error in proportion.
const CORNER_PRECISION: f64 = 1e-7;

/// Where, shortly behind the start of the step, the slip state that it starts with is looked up: far
/// enough to be past an event that ended the step before.
pub(crate) const JUST_BEHIND_START: f64 = 1e-3;

/// Parts of a quarter of the step searched for changes of slip state under a varying normal load:
/// unlike under a constant one, a contact may then slip for a moment, or stop, while it goes one way.
pub(crate) const PROBES: usize = 8;

/// How far back, as a fraction of the step, such a search looks to tell stick from slip: a contact
/// that slipped since the start of the step and then stopped shows it only in what it did last.
pub(crate) const LOOK_BACK: f64 = 1e-5;

/// What the nodes say about reversals of the contact displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Reversal {
    /// The displacement runs one way throughout.
    None,
    /// The first reversal, as a fraction of the step.
    At(f64),
    /// Displacement and velocity disagree between two nodes: there and back again, unresolved.
    Hidden,
}

/// First reversal within the step. `velocity` (m/s) and `displacement` (m) at the five nodes;
/// velocities below `floor` (m/s) throughout, and movements below `rounding` (m), count as rest.
pub(crate) fn reversal(velocity: &[f64; 5], displacement: &[f64; 5], floor: f64, rounding: f64) -> Reversal {
    let largest = velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest <= floor {
        return Reversal::None;
    }
    let moving = |v: f64| v.abs() > REVERSAL_PRECISION * largest;
    let Some(first) = velocity.iter().position(|&v| moving(v)) else { return Reversal::None };
    let mut last = first;
    for node in first + 1..NODES.len() {
        if moving(velocity[node]) && (velocity[node] > 0.0) != (velocity[last] > 0.0) {
            return Reversal::At(root(velocity, last, node));
        }
        let travel = displacement[node] - displacement[node - 1];
        if travel.abs() > rounding && (travel > 0.0) != (velocity[last] > 0.0) {
            return Reversal::Hidden;
        }
        if moving(velocity[node]) {
            last = node;
        }
    }
    Reversal::None
}

/// Rates (1/s) at the five nodes of the quartic through values there, of a step (s).
pub(crate) fn rates(values: &[f64; 5], step: f64) -> [f64; 5] {
    const WEIGHTS: [[f64; 5]; 5] = [
        [-25.0, 48.0, -36.0, 16.0, -3.0],
        [-3.0, -10.0, 18.0, -6.0, 1.0],
        [1.0, -8.0, 0.0, 8.0, -1.0],
        [-1.0, 6.0, -18.0, 10.0, 3.0],
        [3.0, -16.0, 36.0, -48.0, 25.0],
    ];
    WEIGHTS.map(|weights| weights.iter().zip(values).map(|(w, x)| w * x).sum::<f64>() / (3.0 * step))
}

/// Root of the quartic through the five velocities between two nodes where they differ in sign.
fn root(velocity: &[f64; 5], from: usize, to: usize) -> f64 {
    let (mut a, mut b) = (NODES[from], NODES[to]);
    let (mut fa, mut fb) = (velocity[from], velocity[to]);
    // Illinois: the end that stays twice is halved, so that both ends close in.
    let mut side = 0;
    for _ in 0..60 {
        let x = (a * fb - b * fa) / (fb - fa);
        let fx = quartic(velocity, x);
        if fx == 0.0 || (b - a) < 1e-9 * b {
            return x;
        }
        if (fx > 0.0) == (fb > 0.0) {
            (b, fb) = (x, fx);
            if side == 1 {
                fa *= 0.5;
            }
            side = 1;
        } else {
            (a, fa) = (x, fx);
            if side == -1 {
                fb *= 0.5;
            }
            side = -1;
        }
    }
    0.5 * (a + b)
}

/// The quartic through the five values at the nodes, by Newton's divided differences.
fn quartic(values: &[f64; 5], x: f64) -> f64 {
    let mut c = *values;
    for level in 1..5 {
        for i in (level..5).rev() {
            c[i] = (c[i] - c[i - 1]) / (NODES[i] - NODES[i - level]);
        }
    }
    (0..4).rev().fold(c[4], |sum, i| sum * (x - NODES[i]) + c[i])
}

/// First change of the slip state within the step, as a fraction of it: just behind the instant.
/// `slip` at the five nodes, the first just behind the start; `probe` looks the state up between
/// node `i` and node `i + 1`, which it does at the ends of `parts` parts (1 where the nodes do).
pub(crate) fn corner(
    slip: &[SlipState; 5],
    parts: usize,
    mut probe: impl FnMut(usize, f64) -> Option<SlipState>,
) -> Option<f64> {
    let mut before = JUST_BEHIND_START;
    for node in 0..4 {
        for part in 1..=parts {
            let mut after = NODES[node] + 0.25 * part as f64 / parts as f64;
            let state = if parts == 1 { slip[node + 1] } else { probe(node, after)? };
            if state == slip[0] {
                before = after;
                continue;
            }
            while after - before > 0.1 * CORNER_PRECISION * after {
                let middle = 0.5 * (before + after);
                if probe(node, middle)? == slip[0] {
                    before = middle;
                } else {
                    after = middle;
                }
            }
            return (after < 1.0 - CORNER_PRECISION).then_some(after);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reversal_is_found_where_a_quartic_velocity_vanishes() {
        let velocity = |x: f64| (0.37 - x) * (1.0 + x * x);
        let displacement = |x: f64| 0.37 * x - 0.5 * x * x + 0.37 * x.powi(3) / 3.0 - 0.25 * x.powi(4);
        let (v, u) = (NODES.map(velocity), NODES.map(displacement));
        match reversal(&v, &u, 0.0, 1e-12) {
            Reversal::At(x) => assert!((x - 0.37).abs() < 1e-9, "{x}"),
            other => panic!("{other:?}"),
        }
        assert_eq!(reversal(&v, &u, 10.0, 1e-12), Reversal::None);
    }

    #[test]
    fn rates_are_those_of_a_quartic() {
        let step = 0.02;
        let found = rates(&NODES.map(|x| 1.0 - 2.0 * x + 3.0 * x * x - x.powi(3) + 0.5 * x.powi(4)), step);
        for (x, rate) in NODES.into_iter().zip(found) {
            let expected = (-2.0 + 6.0 * x - 3.0 * x * x + 2.0 * x.powi(3)) / step;
            assert!((rate - expected).abs() < 1e-10, "{x}: {rate} {expected}");
        }
    }

    #[test]
    fn there_and_back_between_two_nodes_is_noticed() {
        let velocity = [1.0, 1.0, 1.0, 1.0, 1.0];
        let displacement = [0.0, 0.25, 0.2, 0.45, 0.7];
        assert_eq!(reversal(&velocity, &displacement, 0.0, 1e-12), Reversal::Hidden);
    }

    #[test]
    fn a_corner_is_located_behind_the_instant() {
        use SlipState::{Slip, Stick};
        let at = 0.613;
        let probe = |_: usize, x: f64| Some(if x < at { Stick } else { Slip });
        let found = corner(&[Stick, Stick, Stick, Slip, Slip], 1, probe).unwrap();
        assert!(found >= at && found - at < CORNER_PRECISION, "{found}");
        assert_eq!(corner(&[Slip; 5], 1, probe), None);
        let moment = |_: usize, x: f64| Some(if x > 0.6 && x < 0.64 { Slip } else { Stick });
        let found = corner(&[Stick; 5], PROBES, moment).unwrap();
        assert!(found > 0.6 && found - 0.6 < CORNER_PRECISION, "{found}");
    }
}
