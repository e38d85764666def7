//! A periodic displacement: its values and its turning points.

use std::f64::consts::TAU;

/// Value and derivative by the phase of `a0 + Σ c_h cos hθ + s_h sin hθ`.
pub(super) fn evaluate(coefficients: &[f64], phase: f64) -> (f64, f64) {
    let (sin, cos) = phase.sin_cos();
    let (mut c, mut s) = (1.0, 0.0);
    let (mut value, mut slope) = (coefficients[0], 0.0);
    for (h, pair) in coefficients[1..].chunks_exact(2).enumerate() {
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
        value += pair[0] * c + pair[1] * s;
        slope += (h + 1) as f64 * (pair[1] * c - pair[0] * s);
    }
    (value, slope)
}

/// The phase between `low` and `high` where `f` changes its sign: regula falsi, Illinois variant.
pub(super) fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut f_low, mut f_high) = (f(low), f(high));
    if f_low == 0.0 {
        return low;
    }
    for _ in 0..100 {
        if f_high == 0.0 || (high - low).abs() <= 4.0 * f64::EPSILON * high.abs() {
            break;
        }
        let mut middle = (low * f_high - high * f_low) / (f_high - f_low);
        if !(middle > low.min(high) && middle < low.max(high)) {
            middle = 0.5 * (low + high);
        }
        let f_middle = f(middle);
        if f_middle * f_high < 0.0 {
            (low, f_low) = (high, f_high);
        } else {
            f_low *= 0.5;
        }
        (high, f_high) = (middle, f_middle);
    }
    high
}

/// Turning points in [0, 2π), ascending. Two closer than an eighth of the shortest harmonic are not seen:
/// what happens between them is as small.
pub(super) fn turning_points(coefficients: &[f64]) -> Vec<f64> {
    let harmonics = coefficients.len() / 2;
    let samples = 8 * harmonics + 32;
    let slope = |phase| evaluate(coefficients, phase).1;
    // An odd offset keeps symmetric motions' turning points off the samples.
    let at = |k: usize| (k as f64 + 0.381_966) * TAU / samples as f64;
    let mut found = Vec::new();
    let mut before = slope(at(0));
    for k in 1..=samples {
        let here = slope(at(k));
        if before * here < 0.0 || (here == 0.0 && before != 0.0) {
            found.push(root(slope, at(k - 1), at(k)).rem_euclid(TAU));
        }
        before = here;
    }
    found.sort_by(f64::total_cmp);
    found
}
