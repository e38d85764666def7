//! The period of a record's driving motion.

use realfft::RealFftPlanner;

/// Mean square of `x(t + L) − x(t)` over twice the variance, below which the motion repeats.
const REPEATS: f64 = 1e-3;

/// The period of `values` in samples, not always whole; `None` when the record does not repeat over at least
/// the last half of a second period.
pub(crate) fn period(values: &[f64]) -> Option<f64> {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count.max(1) as f64;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count.max(1) as f64;
    if count < 16 || variance <= 0.0 || !variance.is_finite() {
        return None;
    }
    let longest = count * 2 / 3;
    let squares = squares(values, mean)?;
    let misfit = |lag: usize| -> f64 { squares[lag] / (count - lag) as f64 / (2.0 * variance) };
    // The first valley that is deep enough, once the motion has moved away from itself.
    let mut lag = 1;
    let mut left = false;
    let mut here = misfit(1);
    while lag < longest {
        let next = misfit(lag + 1);
        left |= here > 0.2;
        // Near a valley the misfit is a parabola, whose bottom may lie between two lags.
        let before = misfit(lag - 1);
        if left && here <= before && here <= next && here < 50.0 * REPEATS {
            let (slope, curvature) = (before - next, before - 2.0 * here + next);
            let (offset, bottom) = match curvature {
                c if c > 0.0 => (0.5 * slope / c, here - slope * slope / (8.0 * c)),
                _ => (0.0, here),
            };
            if bottom < REPEATS {
                return Some(lag as f64 + offset.clamp(-0.5, 0.5));
            }
        }
        lag += 1;
        here = next;
    }
    None
}

/// `Σ (x(t + L) − x(t))²` for every lag L: the squares at both ends less twice the autocorrelation, which two
/// transforms give for all lags at once.
fn squares(values: &[f64], mean: f64) -> Option<Vec<f64>> {
    let count = values.len();
    let length = (2 * count).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut series = vec![0.0; length];
    for (place, value) in series.iter_mut().zip(values) {
        *place = value - mean;
    }
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut series, &mut spectrum).ok()?;
    for line in &mut spectrum {
        *line = (line.norm_sqr() / length as f64).into();
    }
    inverse.process(&mut spectrum, &mut series).ok()?;
    let square = |index: usize| (values[index] - mean).powi(2);
    let mut ends = 2.0 * (0..count).map(square).sum::<f64>();
    let sums = (0..count).map(|lag| {
        let sum = ends - 2.0 * series[lag];
        ends -= square(lag) + square(count - 1 - lag);
        sum.max(0.0)
    });
    Some(sums.collect())
}

#[cfg(test)]
mod tests {
    use super::{period, squares};
    use std::f64::consts::TAU;

    #[test]
    fn a_period_is_found_between_samples() {
        for exact in [40.0, 57.3, 399.6, 400.0] {
            let values: Vec<f64> = (0..1200)
                .map(|i| {
                    let t = TAU * i as f64 / exact;
                    t.sin() + 0.4 * (3.0 * t).cos()
                })
                .collect();
            let found = period(&values).unwrap();
            assert!((found - exact).abs() < 0.05, "{exact}: {found}");
        }
    }

    #[test]
    fn squares_of_differences_are_those_of_their_definition() {
        let values: Vec<f64> = (0..301).map(|i| 3.0 + (0.1 * f64::from(i)).sin() + (i % 7) as f64).collect();
        let found = squares(&values, values.iter().sum::<f64>() / 301.0).unwrap();
        for lag in [0, 1, 2, 50, 199, 300] {
            let sum: f64 = values[lag..].iter().zip(&values).map(|(later, x)| (later - x).powi(2)).sum();
            assert!((found[lag] - sum).abs() < 1e-9 * 301.0, "{lag}: {} {sum}", found[lag]);
        }
    }

    /// Small cycles on a slow large motion: the misfit rises and falls without ever coming near zero.
    #[test]
    fn the_flank_of_a_valley_is_no_period() {
        for small in [0.1, 0.2, 0.3] {
            for cycles in [9.0, 13.5, 21.0] {
                let values: Vec<f64> = (0..1200)
                    .map(|i| {
                        let t = TAU * f64::from(i) / 1200.0;
                        (1.3 * t).sin() + small * (cycles * t).sin()
                    })
                    .collect();
                assert_eq!(period(&values), None, "{small} {cycles}");
            }
        }
    }

    #[test]
    fn what_does_not_repeat_has_no_period() {
        let ramp: Vec<f64> =
            (0..1200).map(|i| (i as f64 / 400.0).min(2.0) * (TAU * i as f64 / 400.0).sin()).collect();
        assert_eq!(period(&ramp), None);
        assert_eq!(period(&[1.0; 100]), None);
    }
}
