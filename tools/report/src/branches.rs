//! What curves of periodic responses have in common when they are drawn.

use stickslip::harmonic::Point;

use crate::document::{Line, Stroke};

/// Nodes that are drawn; the files hold all.
const NODES: usize = 8;

/// The nodes with the largest amplitudes, in their own order.
pub fn most_moving<'p>(count: usize, points: impl Iterator<Item = &'p Point>) -> Vec<usize> {
    let mut largest = vec![0.0_f64; count];
    for point in points {
        largest.iter_mut().zip(&point.amplitude).for_each(|(most, amplitude)| *most = most.max(*amplitude));
    }
    let mut nodes: Vec<usize> = (0..count).collect();
    nodes.sort_by(|a, b| largest[*b].total_cmp(&largest[*a]));
    nodes.truncate(NODES);
    nodes.sort_unstable();
    nodes
}

/// Of many points at most `most`, evenly picked, and the last.
pub fn rows<T>(points: &[T], most: usize) -> impl Iterator<Item = &T> {
    let every = points.len().div_ceil(most).max(1);
    let picked = points.iter().step_by(every);
    let last = points.last().filter(|_| !(points.len() - 1).is_multiple_of(every));
    picked.chain(last)
}

/// The curve through `points`, each `(x, y, unstable)`: a full line where it is stable, a dashed one where it is not.
pub fn stable_and_unstable(name: &str, colour: &str, points: &[(f64, f64, bool)]) -> Vec<Line> {
    let mut lines = Vec::new();
    for unstable in [false, true] {
        let (mut x, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut push = |(across, up, _): (f64, f64, bool)| {
            x.push(across);
            y.push(up);
        };
        let mut last = None;
        // Pieces between neighbours; both kinds of line share the points where one becomes the other.
        for (index, pair) in points.windows(2).enumerate() {
            if pair.iter().any(|point| point.2) != unstable {
                continue;
            }
            if last != index.checked_sub(1) || index == 0 {
                if last.is_some() {
                    push((f64::NAN, f64::NAN, unstable));
                }
                push(pair[0]);
            }
            push(pair[1]);
            last = Some(index);
        }
        if !x.is_empty() {
            let stroke = if unstable {
                Stroke { note: "unstable", ..Stroke::dashed(colour) }
            } else {
                Stroke::solid(colour)
            };
            lines.push(Line { name: name.to_owned(), x, y, stroke });
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stable_and_unstable_branches_meet_and_cover_the_curve_once() {
        let stable = [true, true, false, false, true, true, true, false];
        let points: Vec<_> = stable.iter().enumerate().map(|(i, &s)| (i as f64, i as f64, !s)).collect();
        let lines = stable_and_unstable("curve", "#000000", &points);
        assert_eq!(lines.len(), 2);
        let length = |line: &Line| -> f64 {
            line.x.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.is_finite()).sum()
        };
        assert_eq!((length(&lines[0]), length(&lines[1])), (3.0, 4.0));
        assert_eq!((lines[0].stroke.dash, lines[1].stroke.dash), ("solid", "dash"));
        assert_eq!(lines[0].x.iter().filter(|x| x.is_nan()).count(), 1);
    }
}
