//! Student's distribution.

/// The value that Student's t with `freedom ≥ 1` degrees of freedom stays below with `probability`
/// (between 0 and 1, both excluded; NaN otherwise).
///
/// The distribution function for whole degrees of freedom is the finite sum of Abramowitz & Stegun
/// 26.7.3 and 26.7.4, inverted by bisection. Beyond 2000 degrees it no longer changes within 0.1 %.
///
/// ```
/// use stickslip::fit::student_quantile;
/// assert!((student_quantile(0.975, 10) - 2.228139).abs() < 1e-6);
/// ```
pub fn student_quantile(probability: f64, freedom: usize) -> f64 {
    if !(probability > 0.0 && probability < 1.0) || freedom == 0 {
        return f64::NAN;
    }
    let freedom = freedom.min(2000);
    let central = (2.0 * probability - 1.0).abs();
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if student_central_probability(middle, freedom) < central {
            low = middle;
        } else {
            high = middle;
        }
    }
    (2.0 * probability - 1.0).signum() * (0.5 * (low + high)).tan() * (freedom as f64).sqrt()
}

/// Probability of `|t| < √ν tan θ`.
fn student_central_probability(angle: f64, freedom: usize) -> f64 {
    let (sin, cos) = angle.sin_cos();
    let odd = freedom % 2 == 1;
    let (mut term, mut sum) = if odd { (cos, if freedom > 1 { cos } else { 0.0 }) } else { (1.0, 1.0) };
    let mut k = if odd { 3 } else { 2 };
    while k + 2 <= freedom {
        term *= cos * cos * (k - 1) as f64 / k as f64;
        sum += term;
        k += 2;
    }
    if odd { (angle + sin * sum) * std::f64::consts::FRAC_2_PI } else { sin * sum }
}

/// Probability that a normal variable known to lie between `bounds` lies between `ends` (Abramowitz and Stegun 26.2.17).
/// Far from the middle, too, where the probabilities of both are too small for a number; NaN between equal bounds.
pub(crate) fn normal_within(ends: (f64, f64), bounds: (f64, f64)) -> f64 {
    // All in units of the largest density there is between the bounds.
    let nearest = 0.0_f64.clamp(bounds.0, bounds.1);
    let beyond = |x: f64| upper_tail(x) * (0.5 * (nearest * nearest - x * x)).exp();
    let between = |(a, b): (f64, f64)| match (a >= 0.0, b <= 0.0) {
        (true, _) => beyond(a) - beyond(b),
        (_, true) => beyond(-b) - beyond(-a),
        _ => 1.0 - beyond(-a) - beyond(b),
    };
    let clamp = |x: f64| x.clamp(bounds.0, bounds.1);
    between((clamp(ends.0), clamp(ends.1))) / between(bounds)
}

/// Probability beyond `x ≥ 0` over `exp(−x²/2)`.
fn upper_tail(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x);
    let factors = [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_530];
    factors.iter().fold(0.0, |sum, factor| (sum + factor) * t) / std::f64::consts::TAU.sqrt()
}

#[cfg(test)]
mod tests {
    use super::{normal_within, student_quantile};

    #[test]
    fn student_quantile_matches_tables() {
        for (freedom, expected) in [
            (1, 12.706205),
            (2, 4.302653),
            (3, 3.182446),
            (4, 2.776445),
            (7, 2.364624),
            (30, 2.042272),
            (2000, 1.961151),
        ] {
            let found = student_quantile(0.975, freedom);
            assert!((found - expected).abs() < 2e-6, "{freedom}: {found}");
            assert_eq!(student_quantile(0.025, freedom), -found);
        }
        assert!(student_quantile(1.0, 3).is_nan());
    }

    const EVERYWHERE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    #[test]
    fn the_normal_distribution_is_that_of_the_tables() {
        for (x, expected) in [(0.0, 0.5), (1.0, 0.841_344_746), (1.96, 0.975_002_105), (-3.0, 0.001_349_898)]
        {
            let below = normal_within((f64::NEG_INFINITY, x), EVERYWHERE);
            assert!((below - expected).abs() < 1e-7, "{x}");
            let above = normal_within((x, f64::INFINITY), EVERYWHERE);
            assert!((below + above - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn far_from_the_middle_a_normal_variable_lies_near_the_nearer_bound() {
        // Beyond x it falls like exp(−x d): the fraction within d of the bound is 1 − exp(−x d), about.
        for (x, d) in [(35.0, 0.02), (60.0, 0.01), (200.0, 0.01)] {
            let expected = 1.0 - f64::exp(-x * d);
            let within = normal_within((-x - d, x + d), (x, 1e3));
            assert!((within / expected - 1.0).abs() < 0.02, "{x}: {within} {expected}");
            let mirrored = normal_within((-x - d, x + d), (-1e3, -x));
            assert!((mirrored - within).abs() < 1e-12);
        }
        assert_eq!(normal_within((-1.0, 1.0), (2.0, 9.0)), 0.0);
    }
}
