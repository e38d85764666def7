//! The displacement of a contact over a period, as a function of the phase.

use crate::numeric::HarmonicSet;

/// Harmonics below this fraction of the largest carry no weight.
const WEIGHTLESS: f64 = 1e-15;
/// Amplitudes (m) below this are rest: their products would leave the range of numbers.
const REST: f64 = 1e-250;
/// A Newton step (rad) below this is the last: convergence is quadratic.
const LAST_STEP: f64 = 1e-8;
const MAX_ITERATIONS: usize = 80;

/// A trigonometric polynomial, prepared for fast evaluation.
#[derive(Debug, Clone, Default)]
pub(super) struct Motion {
    bias: f64,
    odd: bool,
    /// Cosine and sine coefficients of harmonics 1, 2, … (1, 3, … of an odd set) that carry weight.
    pairs: Vec<[f64; 2]>,
    /// Sum of the amplitudes: a bound of the distance from the bias.
    amplitude: f64,
    /// Bounds of the second, third and fourth derivative.
    curvature_bound: f64,
    jerk_bound: f64,
    snap_bound: f64,
}

/// A turning point of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turning {
    /// Phase (rad).
    pub phase: f64,
    /// Displacement (m).
    pub value: f64,
}

impl Motion {
    /// Takes over the coefficients `u` on `set`; false if they are not finite, or too large to be squared.
    pub fn set(&mut self, set: HarmonicSet, u: &[f64]) -> bool {
        self.odd = set.is_odd();
        let (bias, pairs) = if self.odd { (0.0, u) } else { (u[0], &u[1..]) };
        self.bias = bias;
        self.pairs.clear();
        self.pairs.extend(pairs.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
        let size = |pair: &[f64; 2]| pair[0].abs() + pair[1].abs();
        let finite = bias.is_finite() && self.pairs.iter().all(|pair| size(pair) < 1e150);
        let largest = self.pairs.iter().map(size).fold(0.0, f64::max);
        let weight = (WEIGHTLESS * largest).max(REST);
        let kept = self.pairs.iter().rposition(|pair| size(pair) > weight).map_or(0, |last| last + 1);
        self.pairs.truncate(kept);
        let (mut order, stride) = self.orders();
        (self.amplitude, self.curvature_bound, self.jerk_bound, self.snap_bound) = (0.0, 0.0, 0.0, 0.0);
        for pair in &self.pairs {
            let amplitude = pair[0].hypot(pair[1]);
            self.amplitude += amplitude;
            self.curvature_bound += order * order * amplitude;
            self.jerk_bound += order * order * order * amplitude;
            self.snap_bound += order * order * order * order * amplitude;
            order += stride;
        }
        finite
    }

    /// Whether nothing moves.
    pub fn at_rest(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Mean displacement (m).
    pub fn bias(&self) -> f64 {
        self.bias
    }

    /// Phase (rad) after which the motion repeats: with the opposite sign if it is odd.
    pub fn period(&self) -> f64 {
        if self.odd { std::f64::consts::PI } else { std::f64::consts::TAU }
    }

    /// Whether `u(θ + π) = −u(θ)` by the set of harmonics.
    pub fn is_odd(&self) -> bool {
        self.odd
    }

    /// Bound of the distance from the bias (m).
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// Bounds of |u″|, |u‴| and |u⁗|.
    pub fn bounds(&self) -> (f64, f64, f64) {
        (self.curvature_bound, self.jerk_bound, self.snap_bound)
    }

    /// First harmonic and distance to the next.
    fn orders(&self) -> (f64, f64) {
        if self.odd { (1.0, 2.0) } else { (1.0, 1.0) }
    }

    /// Sums `term(order, [c, s], cos hθ, sin hθ)` for two quantities at once.
    #[inline(always)]
    fn sum(&self, phase: f64, mut term: impl FnMut(f64, &[f64; 2], f64, f64) -> (f64, f64)) -> (f64, f64) {
        let (mut sin, mut cos) = phase.sin_cos();
        let (turn_cos, turn_sin) =
            if self.odd { (cos * cos - sin * sin, 2.0 * sin * cos) } else { (cos, sin) };
        let (mut order, stride) = self.orders();
        let mut sum = (0.0, 0.0);
        for pair in &self.pairs {
            let add = term(order, pair, cos, sin);
            sum = (sum.0 + add.0, sum.1 + add.1);
            (cos, sin) = (cos * turn_cos - sin * turn_sin, sin * turn_cos + cos * turn_sin);
            order += stride;
        }
        sum
    }

    /// Displacement (m) and its derivative by the phase.
    pub fn value_and_slope(&self, phase: f64) -> (f64, f64) {
        let (value, slope) =
            self.sum(phase, |order, [c, s], cos, sin| (c * cos + s * sin, order * (s * cos - c * sin)));
        (self.bias + value, slope)
    }

    /// First and second derivative by the phase.
    pub fn slope_and_curvature(&self, phase: f64) -> (f64, f64) {
        self.sum(phase, |order, [c, s], cos, sin| {
            (order * (s * cos - c * sin), -order * order * (c * cos + s * sin))
        })
    }

    /// First, second and third derivative by the phase.
    pub fn derivatives(&self, phase: f64) -> [f64; 3] {
        let mut jerk = 0.0;
        let (slope, curvature) = self.sum(phase, |order, [c, s], cos, sin| {
            let slope = order * (s * cos - c * sin);
            jerk -= order * order * slope;
            (slope, -order * order * (c * cos + s * sin))
        });
        [slope, curvature, jerk]
    }

    /// The phase between the turning points `from` and `to`, which follow each other, where the
    /// displacement is `target` (m): an end where it lies outside.
    pub fn phase_of(&self, target: f64, from: &Turning, to: &Turning) -> f64 {
        let fraction = (target - from.value) / (to.value - from.value);
        // Also without motion, where the fraction is no number.
        if !(fraction > 0.0 && fraction < 1.0) {
            return if fraction >= 1.0 { to.phase } else { from.phase };
        }
        let rising = to.value > from.value;
        let (mut low, mut high) = (from.phase, to.phase);
        // Exact for a single harmonic.
        let mut phase = low + (high - low) * (1.0 - 2.0 * fraction).acos() * std::f64::consts::FRAC_1_PI;
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let (value, slope) = self.value_and_slope(phase);
            if (value < target) == rising {
                low = phase;
            } else {
                high = phase;
            }
            let newton = phase - (value - target) / slope;
            let next = safe(newton, low, high, (value - target).abs(), &mut last);
            let step = (next - phase).abs();
            phase = next;
            // Near a turning point the step must be small against the distance to it.
            if step <= LAST_STEP * (phase - from.phase).min(to.phase - phase) || step <= 1e-15 {
                break;
            }
        }
        phase
    }

    /// The zero of the slope between `low` and `high`, at which its signs differ.
    pub fn turning_point(&self, low: (f64, f64), high: (f64, f64), rising: bool) -> Turning {
        let (mut left, mut right) = (low.0, high.0);
        let weight = low.1.abs() + high.1.abs();
        let fraction = if weight > 0.0 { low.1.abs() / weight } else { 0.5 };
        let mut phase = left + fraction * (right - left);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let (slope, curvature) = self.slope_and_curvature(phase);
            if (slope > 0.0) == rising {
                left = phase;
            } else {
                right = phase;
            }
            let newton = phase - slope / curvature;
            let next = safe(newton, left, right, slope.abs(), &mut last);
            let step = (next - phase).abs();
            phase = next;
            if step <= LAST_STEP {
                break;
            }
        }
        Turning { phase, value: self.value_and_slope(phase).0 }
    }
}

/// Newton's step if it stays within the bracket and the defect has halved since the last one; else the middle.
fn safe(newton: f64, low: f64, high: f64, defect: f64, last: &mut f64) -> f64 {
    let falls = defect <= 0.5 * *last;
    *last = defect;
    if newton >= low && newton <= high && falls { newton } else { 0.5 * (low + high) }
}
