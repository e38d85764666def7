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

/// Probability that a normal variable lies below `x` (Abramowitz and Stegun 26.2.17, to 10⁻⁷).
pub(crate) fn normal(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let factors = [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_530];
    let tail = factors.iter().fold(0.0, |sum, factor| (sum + factor) * t);
    let upper = tail * (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    if x > 0.0 { 1.0 - upper } else { upper }
}

#[cfg(test)]
mod tests {
    use super::{normal, student_quantile};

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

    #[test]
    fn the_normal_distribution_is_that_of_the_tables() {
        for (x, expected) in [(0.0, 0.5), (1.0, 0.841_344_746), (1.96, 0.975_002_105), (-3.0, 0.001_349_898)]
        {
            assert!((normal(x) - expected).abs() < 1e-7, "{x}");
            assert!((normal(x) + normal(-x) - 1.0).abs() < 1e-6);
        }
    }
}
