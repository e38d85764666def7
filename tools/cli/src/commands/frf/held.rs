//! Resonances of a held response: where the least force holds it.

use stickslip::harmonic::{Assembly, Control, Curve, Peak, Point, periodic_response};

use stickslip_report::responses::PhaseResonance;

use super::Request;
use super::request::Hold;
use crate::progress;

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
            parameter: at.parameter,
        }
    };
    let mut peaks: Vec<Peak> = Vec::new();
    for found in curve.points.windows(3).filter(least).map(peak) {
        let known = |known: &Peak| {
            same(known.angular_frequency, found.angular_frequency) && same(known.level, found.level)
        };
        if !peaks.iter().any(known) {
            peaks.push(found);
        }
    }
    peaks
}

/// Whether two places found are one: a curve may pass it more than once.
fn same(one: f64, other: f64) -> bool {
    const APART: f64 = 1e-7;
    (one - other).abs() <= APART * one.abs().max(other.abs())
}

/// The point of least force near the middle one of three; `None` where none is found there.
fn located(assembly: &Assembly, request: &Request, control: &Control, points: &[Point]) -> Option<Point> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let at = |frequency: f64, near: &Point| {
        periodic_response(assembly, frequency, control, &request.alone(), Some(near)).ok()
    };
    let (mut low, mut high) = (points[0].angular_frequency, points[2].angular_frequency);
    let mut left = at(high - golden * (high - low), &points[1])?;
    let mut right = at(low + golden * (high - low), &points[1])?;
    for _ in 0..SECTIONS {
        if progress::interrupted() {
            return None;
        }
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

/// Where the displacement of the held node falls to a quarter period behind the force along `curve`.
pub fn phase_resonances(
    assembly: &Assembly,
    request: &Request,
    hold: Hold,
    control: &Control,
    curve: &Curve,
) -> Vec<PhaseResonance> {
    let crossing = |ends: &[Point]| {
        let (before, after) = (in_phase(&ends[0], hold.node)?, in_phase(&ends[1], hold.node)?);
        // Where the phase comes back, there is an antiresonance.
        if !(before > 0.0 && after <= 0.0) {
            return None;
        }
        let refined = quarter_behind(assembly, request, hold, control, [&ends[0], &ends[1]]);
        let fraction = before / (before - after);
        let between = |of: fn(&Point) -> f64| of(&ends[0]) + fraction * (of(&ends[1]) - of(&ends[0]));
        Some(PhaseResonance {
            node: hold.node,
            angular_frequency: refined
                .as_ref()
                .map_or_else(|| between(|point| point.angular_frequency), |point| point.angular_frequency),
            level: refined.as_ref().map_or_else(|| between(|point| point.level), |point| point.level),
            interpolated: refined.is_none(),
        })
    };
    let mut found: Vec<PhaseResonance> = Vec::new();
    for next in curve.points.windows(2).filter_map(crossing) {
        let known = |known: &PhaseResonance| {
            same(known.angular_frequency, next.angular_frequency) && same(known.level, next.level)
        };
        if !found.iter().any(known) {
            found.push(next);
        }
    }
    found
}

/// Cosine of the phase of a node's first harmonic against the force; `None` where the displacement is ahead.
fn in_phase(point: &Point, node: usize) -> Option<f64> {
    let (cosine, sine) = match point.nodes.get(node).map(Vec::as_slice) {
        Some(&[_, cosine, sine, ..]) if point.level >= 0.0 => (cosine, sine),
        Some(&[_, cosine, sine, ..]) => (-cosine, -sine),
        _ => return None,
    };
    (sine > 0.0).then(|| cosine / cosine.hypot(sine))
}

/// The phase resonance between two points, by false position with the weights of Anderson & Björck (1973);
/// `None` where another branch gets in between.
fn quarter_behind(
    assembly: &Assembly,
    request: &Request,
    hold: Hold,
    control: &Control,
    ends: [&Point; 2],
) -> Option<Point> {
    const EXACT: f64 = 1e-10;
    const STEPS: usize = 40;
    let value = |point: &Point| Some((point.angular_frequency, in_phase(point, hold.node)?));
    let (mut kept, mut last) = (value(ends[0])?, value(ends[1])?);
    let mut near = ends[1].clone();
    for _ in 0..STEPS {
        let frequency = last.0 - last.1 * (last.0 - kept.0) / (last.1 - kept.1);
        near = periodic_response(assembly, frequency, control, &request.alone(), Some(&near)).ok()?;
        let new = value(&near)?;
        if new.1.abs() < EXACT {
            return Some(near);
        }
        if new.1.signum() == last.1.signum() {
            let weight = 1.0 - new.1 / last.1;
            kept.1 *= if weight > 0.0 { weight } else { 0.5 };
        } else {
            kept = last;
        }
        last = new;
    }
    None
}
