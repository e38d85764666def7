//! What the loops of both directions show: how much of the way slips, and how the normal direction hardens.

use std::f64::consts::TAU;

use crate::identify::ContactPeriod;
use crate::numeric::fourier::{time_derivative, value};

/// Samples of a period.
const SAMPLES: usize = 1024;
/// Where the contact moves slower than this part of its fastest motion, a slope says nothing.
const SLOW: f64 = 0.1;
/// The slope that so many do not exceed counts as that of a contact that sticks.
const STICKS: f64 = 0.95;
/// Parts of that slope below which the whole contact slips, and above which all of it sticks.
const SLIPS: f64 = 0.1;
const HOLDS: f64 = 0.9;

/// How the tangential force answers to the motion along a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopSlopes {
    /// Slope of S over ξ (N/m) where the contact sticks.
    pub stuck: f64,
    /// Parts of the way on which it sticks, slips partly (micro-slip) and as a whole (macro-slip).
    pub parts: [f64; 3],
}

/// Displacement, velocity (m/s), force and its rate (N/s) over a period.
fn moments(period: &ContactPeriod) -> Vec<[f64; 4]> {
    let rate = time_derivative(&period.force, 1, period.angular_frequency);
    let at = |k: usize| {
        let time = TAU * k as f64 / SAMPLES as f64 / period.angular_frequency;
        let [displacement, velocity, force] = period.at(time);
        let rate = value(&rate, period.angular_frequency * time);
        [displacement, velocity, force, rate]
    };
    (0..SAMPLES).map(at).collect()
}

/// The slopes of every loop; what sticks is the same in all of them.
pub(super) fn slopes(along: &[ContactPeriod]) -> Vec<LoopSlopes> {
    let moved: Vec<Vec<[f64; 2]>> = along.iter().map(moving).collect();
    let mut all: Vec<f64> = moved.iter().flatten().map(|[slope, _]| *slope).collect();
    all.sort_by(f64::total_cmp);
    let stuck = all.get((all.len().saturating_sub(1) as f64 * STICKS) as usize).copied().unwrap_or(f64::NAN);
    let one = |moved: &Vec<[f64; 2]>| {
        let mut parts = [0.0; 3];
        for [slope, way] in moved {
            let kind = if *slope > HOLDS * stuck { 0 } else { 1 + usize::from(*slope < SLIPS * stuck) };
            parts[kind] += way;
        }
        let whole: f64 = parts.iter().sum();
        LoopSlopes { stuck, parts: parts.map(|part| part / whole) }
    };
    moved.iter().map(one).collect()
}

/// Slope (N/m) and way (m) of every instant at which the contact moves.
fn moving(period: &ContactPeriod) -> Vec<[f64; 2]> {
    let moments = moments(period);
    let fastest = moments.iter().map(|[_, v, ..]| v.abs()).fold(0.0, f64::max);
    let moves = moments.iter().filter(|[_, v, ..]| v.abs() > SLOW * fastest);
    moves.map(|[_, v, _, rate]| [rate / v, v.abs()]).collect()
}

/// Slopes (N/m) of the normal force over the normal displacement, by least squares: where less presses than in the mean, and where
/// more does. The second is the larger where the contact hardens.
pub(super) fn normal_slopes(across: &ContactPeriod) -> [f64; 2] {
    let moments = moments(across);
    let mean = across.force[0];
    // N is what lacks of the preload: more presses where it is smaller.
    [true, false].map(|less| {
        let half: Vec<[f64; 2]> =
            moments.iter().filter(|m| (m[2] > mean) == less).map(|m| [m[0], m[2]]).collect();
        let count = half.len().max(1) as f64;
        let [u, f] = [0, 1].map(|k| half.iter().map(|one| one[k]).sum::<f64>() / count);
        let product: f64 = half.iter().map(|[x, y]| (x - u) * (y - f)).sum();
        product / half.iter().map(|[x, _]| (x - u).powi(2)).sum::<f64>()
    })
}
