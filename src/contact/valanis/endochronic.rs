//! One monotonic stretch of the Valanis law, free of units.
//!
//! Between two reversals at constant normal load the law's distance from saturation, relative to the
//! limit, `g = 1 − s y/L` (in `[0, 2]` within the limit; the equation holds for any `g ≥ 0`), obeys `b g + ln g = b g₀ + ln g₀ − δ`, with the reach `δ ≥ 0`
//! proportional to the distance travelled and `b ≥ 0` a constant of the law. (Gaul & Lenz 1997
//! integrated; `b g` is Wright's omega function of the right-hand side plus `ln b`.)

/// End of a monotonic stretch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    /// `ln(g₀/g)`.
    pub log_ratio: f64,
    /// `g₀ − g`, accurate however short the stretch.
    pub drop: f64,
    /// `g`.
    pub gap: f64,
    /// `g/g₀`, also where both vanish.
    pub ratio: f64,
}

/// Follows the law over the reach `delta` from the gap `gap`.
pub(super) fn advance(gap: f64, delta: f64, b: f64) -> Stretch {
    let (log_ratio, loss) = log_ratio(delta, b * gap);
    Stretch { log_ratio, drop: -gap * loss, gap: gap * (1.0 + loss), ratio: 1.0 + loss }
}

/// The `fraction` of the reach `delta` into `stretch`, which starts from `gap`: `g` there, and the
/// ratio of the gap at the end to it.
#[inline]
pub(super) fn within(gap: f64, delta: f64, b: f64, stretch: &Stretch, fraction: f64) -> (f64, f64) {
    // Interpolation is good to twelve digits then.
    if delta < 0.2 && gap > 0.0 {
        let inner = interpolated(gap, delta, b, stretch.gap, fraction);
        return (inner, stretch.gap / inner);
    }
    let (part, c) = (fraction * delta, b * gap);
    let (log_ratio, loss) = if c == 0.0 || delta - c > EXPONENTIAL_VANISHES {
        log_ratio(part, c)
    } else {
        // Hermite's cubic through both ends of the stretch, where q and dq/dδ = 1/(1 + b g) are known.
        let (first, last) = (delta / (1.0 + c), delta / (1.0 + b * stretch.gap));
        let (square, rest) = (fraction * fraction, 1.0 - fraction);
        let guess = square * (3.0 - 2.0 * fraction) * stretch.log_ratio
            + fraction * rest * (rest * first - fraction * last);
        refine(guess.max(0.0), part, c)
    };
    // The quotient of two small ratios would have no digits; where the reach overflows nothing is left.
    let left = if delta.is_finite() { (log_ratio - stretch.log_ratio).exp() } else { 0.0 };
    (gap * (1.0 + loss), left)
}

/// Hermite's polynomial of the seventh degree for `g` over a stretch, from three derivatives at either
/// end: `g' = −g w`, `g″ = g w³`, `g‴ = −g w⁵ (1 − 2 b g)` with `w = 1/(1 + b g)`.
fn interpolated(gap: f64, delta: f64, b: f64, end_gap: f64, fraction: f64) -> f64 {
    let from = |g: f64, near: f64, towards: f64| {
        let w = 1.0 / (1.0 + b * g);
        let x = near * delta * w * towards;
        // Basis polynomials of value, slope, curvature and third derivative, relative to (1 − near)⁴.
        let slope = 1.0 + near * (4.0 + 10.0 * near);
        let value = slope + 20.0 * near * near * near;
        let curvature = (1.0 + 4.0 * near) / 2.0;
        let third = (1.0 - 2.0 * b * g) / 6.0;
        let far = (1.0 - near) * (1.0 - near);
        g * far * far * (value - x * (slope - x * w * (curvature - x * w * third)))
    };
    from(gap, fraction, 1.0) + from(end_gap, 1.0 - fraction, -1.0)
}

/// Beyond this e^−q is zero, also in the equation of `log_ratio`.
const EXPONENTIAL_VANISHES: f64 = 750.0;

/// The root `q ≥ 0` of `F(q) = q + c (1 − e^−q) − δ`, `c ≥ 0`, which is increasing and concave.
///
/// Halley's steps, no more than twice Newton's, from a lower bound. Newton's alone would rise to the
/// root without passing it; from beyond the root either falls back below it or closer, so that the
/// start cannot fail. Nothing overflows: only `e^−q` is ever formed. Returns `q` and `e^−q − 1`.
fn log_ratio(delta: f64, c: f64) -> (f64, f64) {
    if c == 0.0 || delta == 0.0 {
        return (delta, (-delta).exp_m1());
    }
    if delta - c > EXPONENTIAL_VANISHES {
        return (delta - c, -1.0);
    }
    refine(lower_bound(delta, c), delta, c)
}

/// Root of `log_ratio`'s equation from the guess `q`, which may lie on either side of it.
fn refine(mut q: f64, delta: f64, c: f64) -> (f64, f64) {
    // Two or three rounds are usual; the bound only stops a NaN.
    for _ in 0..50 {
        let loss = (-q).exp_m1();
        let value = q - c * loss - delta;
        // F' = 1 + fall and F″ = −fall.
        let fall = c * (1.0 + loss);
        let newton = -value / (1.0 + fall);
        let step = newton / (1.0 - 0.5 * newton * fall / (1.0 + fall)).max(0.5);
        q += step;
        // Convergence is cubic: a step this small leaves an error below the last digit.
        if step.abs() <= 1e-5 * q {
            // The exponential follows so small a step by three terms of its series.
            let change = step * (-1.0 + step * (0.5 - step / 6.0));
            return (q, loss + (1.0 + loss) * change);
        }
    }
    (q, (-q).exp_m1())
}

/// A number not above the root of `log_ratio`, and close to it at either end.
fn lower_bound(delta: f64, c: f64) -> f64 {
    // From 1 − e^−q ≤ min(1, q).
    let crude = (delta - c).max(delta / (1.0 + c));
    if c < 2.0 {
        return crude;
    }
    // A large c puts a corner into F at δ ≈ c. With any upper bound Q of the root,
    // 1 − e^−q = (δ − q)/c ≥ (δ − Q)/c; and q ≤ max(δ − c, 0) + ln(1 + c) since q e^q ≤ c at δ = c.
    let upper = delta.min((delta - c).max(0.0) + c.ln_1p());
    crude.max(-(-(delta - upper) / c).ln_1p())
}

/// `∫ (1 − g)²/g dg` over the stretch: the dissipated energy, free of units and never negative.
pub(super) fn dissipation(gap: f64, stretch: &Stretch) -> f64 {
    // Gauss–Legendre nodes and weights on [−1, 1], six points.
    const RULE: [(f64, f64); 3] = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_36),
    ];
    let &Stretch { log_ratio, drop, .. } = stretch;
    // The closed form loses its digits, and its sign, by cancellation where the stretch is short. Below
    // this bound the pole at g = 0 is so far from the stretch that the rule is exact to round-off.
    if log_ratio > 0.25 {
        return log_ratio - drop * (2.0 - gap + 0.5 * drop);
    }
    let middle = gap - 0.5 * drop;
    let density = |g: f64| (1.0 - g) * (1.0 - g) / g;
    let mut sum = 0.0;
    for (node, weight) in RULE {
        let offset = 0.5 * drop * node;
        sum += weight * (density(middle - offset) + density(middle + offset));
    }
    if drop > 0.0 { 0.5 * drop * sum } else { log_ratio }
}

#[cfg(test)]
mod tests {
    use super::{advance, dissipation, log_ratio, within};

    #[test]
    fn log_ratio_solves_its_equation_over_all_scales() {
        for exponent_c in -12..=12 {
            for exponent_delta in -12..=12 {
                for factor in [1.0, 2.3, 7.1] {
                    let c = factor * 10f64.powi(exponent_c);
                    let delta = 10f64.powi(exponent_delta);
                    let (q, loss) = log_ratio(delta, c);
                    assert!((loss / (-q).exp_m1() - 1.0).abs() < 1e-14);
                    let back = q - c * loss;
                    assert!((back / delta - 1.0).abs() < 1e-13, "c {c:e} δ {delta:e} q {q:e} back {back:e}");
                }
            }
        }
    }

    #[test]
    fn log_ratio_survives_the_corner_and_infinite_reach() {
        for c in [1e3, 1e6, 1e9] {
            for shift in [-20.0, -1.0, 0.0, 1.0, 10.0, 20.0] {
                let (q, _) = log_ratio(c + shift, c);
                assert!(((q - c * (-q).exp_m1() - c) - shift).abs() < 4e-16 * c, "c {c:e} shift {shift}");
            }
        }
        assert_eq!(log_ratio(f64::INFINITY, 3.0), (f64::INFINITY, -1.0));
        assert_eq!(log_ratio(1e300, 3.0), (1e300, -1.0));
        assert!(log_ratio(f64::NAN, 3.0).0.is_nan());
    }

    #[test]
    fn dissipation_is_the_same_by_quadrature_and_closed_form() {
        // Either side of the switch between the two formulas, for gaps about and far from g = 1.
        for gap in [0.05, 0.9, 1.0, 1.1, 1.13, 2.0] {
            for b in [0.0, 0.4, 30.0] {
                let long = advance(gap, 0.3 + b * gap * 0.25, b);
                let (mut sum, mut at) = (0.0, gap);
                for _ in 0..50 {
                    let part = advance(at, (0.3 + b * gap * 0.25) / 50.0, b);
                    sum += dissipation(at, &part);
                    at = part.gap;
                }
                let whole = dissipation(gap, &long);
                assert!((sum / whole - 1.0).abs() < 1e-11, "gap {gap} b {b}: {sum:e} {whole:e}");
            }
        }
    }

    #[test]
    fn a_gap_within_a_stretch_is_the_end_of_its_part() {
        for gap in [0.0, 1e-9, 0.03, 0.3, 1.7, 40.0] {
            for b in [0.0, 0.4, 3.0, 30.0, 1e6] {
                for delta in [0.0, 1e-9, 0.02, 0.199, 0.2, 1.0, 30.0, 1e3, 1e7, f64::INFINITY] {
                    let whole = advance(gap, delta, b);
                    for fraction in [0.25, 0.75] {
                        let (found, left) = within(gap, delta, b, &whole, fraction);
                        let part = advance(gap, fraction * delta, b);
                        let expected =
                            if delta < 1e100 { (part.log_ratio - whole.log_ratio).exp() } else { 0.0 };
                        let context = format!("gap {gap:e} b {b} δ {delta:e} fraction {fraction}");
                        assert!((found - part.gap).abs() <= 1e-12 * gap, "{context}: {found:e} {part:?}");
                        assert!((left - expected).abs() <= 1e-11 * expected, "{context}: {left} {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn saturation_is_left_nowhere() {
        let end = advance(0.0, 5.0, 0.4);
        assert_eq!((end.gap, end.drop), (0.0, 0.0));
        assert!((end.ratio - (-5f64).exp()).abs() < 1e-16);
        assert_eq!(dissipation(0.0, &end), 5.0);
        assert_eq!(dissipation(0.0, &advance(0.0, 0.1, 0.4)), 0.1);
    }
}
