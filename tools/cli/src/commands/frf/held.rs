//! Resonances of a held response: where the least force holds it.

use stickslip::harmonic::{Assembly, Control, Curve, Peak, Point, periodic_response};

use super::Request;
use super::request::Hold;

/// Golden sections of the interval around a minimum: the frequency is then as exact as a minimum can be in
/// double precision, about 1e-8 of itself.
const SECTIONS: usize = 38;

/// The peaks of response over force along `curve`, in the place of those of the amplitude, which is held.
pub fn resonances(
    assembly: &Assembly,
    request: &Request,
    hold: Hold,
    control: &Control,
    curve: &Curve,
) -> Vec<Peak> {
    let least = |points: &&[Point]| points[1].level < points[0].level && points[1].level <= points[2].level;
    let peak = |points: &[Point]| {
        let at = located(assembly, request, control, points).unwrap_or_else(|| points[1].clone());
        Peak {
            node: hold.node,
            angular_frequency: at.angular_frequency,
            amplitude: at.amplitude[hold.node],
            level: at.level,
        }
    };
    curve.points.windows(3).filter(least).map(peak).collect()
}

/// The point of least force near the middle one of three; `None` where none is found there.
fn located(assembly: &Assembly, request: &Request, control: &Control, points: &[Point]) -> Option<Point> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let at = |frequency: f64, near: &Point| {
        periodic_response(assembly, frequency, control, &request.settings, Some(near)).ok()
    };
    let (mut low, mut high) = (points[0].angular_frequency, points[2].angular_frequency);
    let mut left = at(high - golden * (high - low), &points[1])?;
    let mut right = at(low + golden * (high - low), &points[1])?;
    for _ in 0..SECTIONS {
        if left.level < right.level {
            high = right.angular_frequency;
            right = left;
            left = at(high - golden * (high - low), &right)?;
        } else {
            low = left.angular_frequency;
            left = right;
            right = at(low + golden * (high - low), &left)?;
        }
    }
    let best = if left.level < right.level { left } else { right };
    // Another branch may lie closer to the start: what the curve has is then the answer.
    (best.level <= points[1].level * (1.0 + 1e-9)).then_some(best)
}
