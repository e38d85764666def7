//! All turning points of a motion, none missed.
//!
//! An interval is left when bounds of the derivatives prove that it holds no zero of the slope, or at most
//! one, and halved otherwise. So the effort follows the motion: a dozen evaluations where one harmonic
//! prevails, more where many do. What may be missed is a pair of turning points that rounding cannot
//! tell apart.

use super::motion::{Motion, Turning};

/// Differences of displacement below this fraction of the amplitude are rounding.
const ROUNDING: f64 = 1e-14;
/// Narrowest interval (rad).
const NARROWEST: f64 = 1e-11;

/// Derivatives of the motion at a phase.
#[derive(Debug, Clone, Copy)]
struct Probe {
    phase: f64,
    slope: f64,
    curvature: f64,
    jerk: f64,
    /// The sign the slope counts as having; at a zero it is kept alike from both sides.
    rising: bool,
}

impl Probe {
    fn at(motion: &Motion, phase: f64) -> Self {
        let [slope, curvature, jerk] = motion.derivatives(phase);
        Self { phase, slope, curvature, jerk, rising: slope > 0.0 }
    }
}

/// Writes the turning points of one period of the motion (half a period where it is odd) in ascending
/// phase, an even number (an odd one): maxima and minima in turn. None where nothing moves.
pub(super) fn turning_points(motion: &Motion, out: &mut Vec<Turning>) {
    out.clear();
    if motion.at_rest() {
        return;
    }
    let first = Probe::at(motion, 0.0);
    let sign = if motion.is_odd() { -1.0 } else { 1.0 };
    let last = Probe {
        phase: motion.period(),
        slope: sign * first.slope,
        curvature: sign * first.curvature,
        jerk: sign * first.jerk,
        rising: first.rising != motion.is_odd(),
    };
    search(motion, first, last, out);
}

fn search(motion: &Motion, left: Probe, right: Probe, out: &mut Vec<Turning>) {
    let width = right.phase - left.phase;
    let (curvature_bound, jerk_bound) = local_bounds(motion, &left, &right);
    let changes = left.rising != right.rising;
    let slopes = left.slope.abs() + right.slope.abs();
    if !changes && slopes > width * curvature_bound {
        return;
    }
    let curvatures = left.curvature.abs() + right.curvature.abs();
    let monotonic = left.curvature * right.curvature > 0.0 && curvatures > width * jerk_bound;
    let hidden = 0.5 * width * (slopes + width * curvature_bound);
    if monotonic || hidden <= ROUNDING * motion.amplitude() || width <= NARROWEST {
        if changes {
            out.push(motion.turning_point((left.phase, left.slope), (right.phase, right.slope), left.rising));
        }
        return;
    }
    let middle = Probe::at(motion, left.phase + 0.5 * width);
    search(motion, left, middle, out);
    search(motion, middle, right, out);
}

/// Bounds of |u″| and |u‴| between two probes: what the probes have, and what the next derivative can add on the way.
/// Far below those of the whole period where many harmonics are small.
fn local_bounds(motion: &Motion, left: &Probe, right: &Probe) -> (f64, f64) {
    let (curvature, jerk, snap) = motion.bounds();
    let half = 0.5 * (right.phase - left.phase);
    let between = |left: f64, right: f64, next: f64| 0.5 * (left.abs() + right.abs()) + half * next;
    let jerk = between(left.jerk, right.jerk, snap).min(jerk);
    (between(left.curvature, right.curvature, jerk).min(curvature), jerk)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::harmonic::HarmonicSet;

    fn found(set: HarmonicSet, u: &[f64]) -> Vec<Turning> {
        let (mut motion, mut out) = (Motion::default(), Vec::new());
        assert!(motion.set(set, u));
        turning_points(&motion, &mut out);
        out
    }

    #[test]
    fn one_harmonic_turns_twice_at_its_phase() {
        for (c, s) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1e-9), (3e4, -4e4), (1e-200, 1e-200)] {
            let full = found(HarmonicSet::full(3), &[0.5, c, s, 0.0, 0.0, 0.0, 0.0]);
            let half = found(HarmonicSet::odd(3), &[c, s, 0.0, 0.0]);
            assert_eq!((full.len(), half.len()), (2, 1), "{c} {s}");
            for turning in full.iter().chain(&half) {
                let off = (turning.phase - f64::atan2(s, c)).rem_euclid(PI);
                assert!(off.min(PI - off) < 1e-14, "{c} {s}: {off:e}");
            }
            assert!((half[0].value.abs() / f64::hypot(c, s) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn rest_has_no_turning_points() {
        assert!(found(HarmonicSet::full(2), &[3.0, 0.0, 0.0, 0.0, 0.0]).is_empty());
        assert!(found(HarmonicSet::odd(1), &[0.0, 0.0]).is_empty());
    }

    #[test]
    fn a_small_high_harmonic_turns_the_motion_at_its_crests() {
        // u = cos θ + e cos 50θ has extra turning points about θ = 0 and π as soon as 50² e > 1.
        for (fraction, extra) in [(0.9, false), (1.1, true)] {
            let mut u = vec![0.0; 101];
            (u[1], u[99]) = (1.0, fraction / 2500.0);
            let count = found(HarmonicSet::full(50), &u).len();
            assert_eq!(count > 2, extra, "{fraction}: {count}");
        }
    }

    #[test]
    fn an_inflexion_with_horizontal_tangent_is_no_turning_point_or_a_pair() {
        // u' = −sin θ (1 − cos θ)² … : u = cos θ-like with a flat crest; exact double and triple zeros.
        // sin θ + ½ sin 2θ has a triple zero of the slope's numerator at π: u' = cos θ + cos 2θ.
        let flat = found(HarmonicSet::full(2), &[0.0, 0.0, 1.0, 0.0, 0.5]);
        let real: Vec<_> = flat.iter().filter(|t| t.value.abs() > 1e-9).collect();
        assert_eq!(real.len(), 2, "{flat:?}");
        assert_eq!(flat.len() % 2, 0);
        for (turning, phase) in real.iter().zip([PI / 3.0, TAU - PI / 3.0]) {
            assert!((turning.phase - phase).abs() < 1e-12);
        }
    }

    #[test]
    fn turning_points_are_those_of_a_fine_grid() {
        let mut numbers = fastrand::Rng::with_seed(7);
        let mut random = || numbers.f64() - 0.5;
        for _ in 0..20 {
            let u: Vec<f64> = (0..31).map(|_| random()).collect();
            let list = found(HarmonicSet::full(15), &u);
            let mut motion = Motion::default();
            motion.set(HarmonicSet::full(15), &u);
            let rises = |k: usize| motion.slope_and_curvature(TAU * k as f64 / 20_000.0).0 > 0.0;
            let changes = (0..20_000).filter(|k| rises(*k) != rises((k + 1) % 20_000)).count();
            assert_eq!(list.len(), changes);
            for pair in list.windows(2) {
                assert!(pair[0].phase < pair[1].phase);
            }
            for turning in &list {
                assert!(motion.slope_and_curvature(turning.phase).0.abs() < 1e-11);
            }
        }
    }
}
