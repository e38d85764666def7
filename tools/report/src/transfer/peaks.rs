//! Resonances of a measured or predicted response, and their damping.

/// A peak's height over that of the points that its fit takes at least, squared: those of a resonance between about
/// twice its half-power points.
const BAND: f64 = 3.0;
/// Relative misfit of one linear resonance above which a peak is bent.
const BENT: f64 = 0.1;

/// A resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Natural frequency of the fit, or the frequency of the largest point (Hz).
    pub frequency: f64,
    /// Largest response, as measured.
    pub size: f64,
    /// Damping ratio of the linear resonance that fits best; `None` where too little of the peak is there.
    pub damping: Option<f64>,
    /// What must be known of the damping; empty of a linear resonance.
    pub remark: &'static str,
}

/// The peaks of a response whose `order`-th derivative of the displacement is `size`, over increasing `frequency` (Hz).
///
/// A peak is where the displacement falls to 1/√2 of it, half of the power, on one side at least before it rises above it
/// again, and to the end of the range on the other: ripples do not. Its damping is that of the one linear resonance
/// `1/|X|² = b ((ω² − x₀)² + a)` through the points above 1/√3 of it.
pub fn peaks(frequency: &[f64], size: &[f64], order: i32) -> Vec<Peak> {
    let displacement: Vec<f64> = frequency.iter().zip(size).map(|(f, size)| size / f.powi(order)).collect();
    let count = displacement.len();
    let inner = 1..count.saturating_sub(1);
    inner
        .filter_map(|top| Some((top, flanks(&displacement, top)?)))
        .map(|(top, (low, high))| {
            let fitted =
                (low.zip(high)).and_then(|(low, high)| fit(frequency, &displacement, top, low..=high));
            let (frequency, size) = (frequency[top], size[top]);
            match fitted {
                Some((ratio, damping, misfit)) => Peak {
                    frequency: ratio * frequency,
                    size,
                    damping: Some(damping),
                    remark: if misfit > BENT { "bent: no linear resonance, an equivalent value" } else { "" },
                },
                None => Peak {
                    frequency,
                    size,
                    damping: None,
                    remark: match (low, high) {
                        (Some(_), Some(_)) => "too few points",
                        _ => "cut off by the range",
                    },
                },
            }
        })
        .collect()
}

/// The first points below half of the power on either side of `top`, `None` where the range ends before; `None` altogether
/// where no peak is there.
fn flanks(values: &[f64], top: usize) -> Option<(Option<usize>, Option<usize>)> {
    let height = values[top];
    let down = |mut side: Box<dyn Iterator<Item = usize> + '_>, strict: bool| -> Option<Option<usize>> {
        // Of equal points the first is the peak.
        let reached = side.find(|&i| {
            let higher = if strict { values[i] >= height } else { values[i] > height };
            higher || values[i] <= height / 2f64.sqrt() || !values[i].is_finite()
        });
        match reached {
            Some(i) if values[i] <= height / 2f64.sqrt() => Some(Some(i)),
            Some(_) => None,
            None => Some(None),
        }
    };
    let low = down(Box::new((0..top).rev()), true)?;
    let high = down(Box::new(top + 1..values.len()), false)?;
    (low.is_some() || high.is_some()).then_some((low, high))
}

/// Natural frequency over that of the `top` point, damping ratio, and relative misfit of the linear resonance that follows the
/// points of `range` near the top.
fn fit(
    frequency: &[f64],
    displacement: &[f64],
    top: usize,
    range: std::ops::RangeInclusive<usize>,
) -> Option<(f64, f64, f64)> {
    let points: Vec<(f64, f64)> = range
        .map(|i| {
            ((frequency[i] / frequency[top]).powi(2) - 1.0, (displacement[top] / displacement[i]).powi(2))
        })
        .filter(|(_, inverse)| *inverse <= BAND)
        .collect();
    let around = points.iter().any(|(x, _)| *x < 0.0) && points.iter().any(|(x, _)| *x > 0.0);
    let [c0, c1, c2] = parabola(&points).filter(|_| around)?;
    let (shift, floor) = (-0.5 * c1 / c2, c0 - 0.25 * c1 * c1 / c2);
    let middle = 1.0 + shift;
    let inside = points.iter().any(|(x, _)| *x <= shift) && points.iter().any(|(x, _)| *x >= shift);
    if !(c2 > 0.0 && floor > 0.0 && middle > 0.0 && inside) {
        return None;
    }
    // 1/|X|² ∝ (ω² − ω₀²)² + 4 D² ω₀² ω², of which x₀ = ω₀² (1 − 2 D²) is the lowest point.
    let narrowed = 1.0 / (1.0 + floor / (c2 * middle * middle)).sqrt();
    let damping = (0.5 * (1.0 - narrowed)).sqrt();
    let off = points.iter().map(|(x, inverse)| ((c0 + x * (c1 + x * c2)) / inverse - 1.0).powi(2));
    let misfit = (off.sum::<f64>() / points.len() as f64).sqrt();
    Some(((middle / narrowed).sqrt(), damping, misfit))
}

/// The parabola through `points` (x, y) that errs least relative to y; `None` below three points.
fn parabola(points: &[(f64, f64)]) -> Option<[f64; 3]> {
    // Orthogonal polynomials on the points, so that a narrow band is no trouble.
    let weight = |y: f64| 1.0 / (y * y);
    let total: f64 = points.iter().map(|(_, y)| weight(*y)).sum();
    let mean = |value: &dyn Fn(f64, f64) -> f64| {
        points.iter().map(|(x, y)| weight(*y) * value(*x, *y)).sum::<f64>() / total
    };
    let centre = mean(&|x, _| x);
    let spread = mean(&|x, _| (x - centre).powi(2));
    let skew = mean(&|x, _| (x - centre).powi(3)) / spread;
    let second = |x: f64| (x - centre).powi(2) - skew * (x - centre) - spread;
    let square = mean(&|x, _| second(x).powi(2));
    if points.len() < 3 || square.is_nan() || square <= 1e-12 * spread * spread {
        return None;
    }
    let level = mean(&|_, y| y);
    let slope = mean(&|x, y| y * (x - centre)) / spread;
    let curvature = mean(&|x, y| y * second(x)) / square;
    // Back to powers of x.
    let first = slope - curvature * skew;
    let zeroth = level - curvature * spread;
    Some([zeroth - first * centre + curvature * centre * centre, first - 2.0 * curvature * centre, curvature])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitude of the acceleration of a linear oscillator at `natural` (Hz) with damping ratio `damping`.
    fn oscillator(frequency: f64, natural: f64, damping: f64) -> f64 {
        let ratio = frequency / natural;
        ratio * ratio / ((1.0 - ratio * ratio).powi(2) + (2.0 * damping * ratio).powi(2)).sqrt()
    }

    fn grid(low: f64, high: f64, count: usize) -> Vec<f64> {
        (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
    }

    #[test]
    fn the_damping_of_a_linear_oscillator_comes_back_from_few_points() {
        for (damping, count) in [(0.005, 120), (0.02, 40), (0.1, 15)] {
            let frequency = grid(35.0, 65.0, count);
            let size: Vec<f64> = frequency.iter().map(|f| oscillator(*f, 50.3, damping)).collect();
            let found = peaks(&frequency, &size, 2);
            assert_eq!(found.len(), 1, "{found:?}");
            let peak = found[0];
            assert!((peak.frequency / 50.3 - 1.0).abs() < 1e-9, "{peak:?}");
            assert!(
                (peak.damping.unwrap() / damping - 1.0).abs() < 1e-6 && peak.remark.is_empty(),
                "{peak:?}"
            );
        }
    }

    #[test]
    fn ripples_are_no_peaks_and_two_modes_are_two() {
        let frequency = grid(20.0, 120.0, 400);
        let mut random = fastrand::Rng::with_seed(7);
        let size: Vec<f64> = frequency
            .iter()
            .map(|f| (oscillator(*f, 40.0, 0.02) + oscillator(*f, 90.0, 0.02)) * (0.9 + 0.2 * random.f64()))
            .collect();
        let found = peaks(&frequency, &size, 2);
        let places: Vec<f64> = found.iter().map(|peak| peak.frequency.round()).collect();
        assert_eq!(places, [40.0, 90.0], "{found:?}");
        for peak in found {
            assert!((peak.damping.unwrap() / 0.02 - 1.0).abs() < 0.15, "{peak:?}");
        }
    }

    #[test]
    fn a_peak_that_the_range_cuts_has_no_damping_and_an_end_is_none() {
        let of = |low: f64, high: f64| {
            let frequency = grid(low, high, 60);
            let size: Vec<f64> = frequency.iter().map(|f| oscillator(*f, 50.0, 0.05)).collect();
            peaks(&frequency, &size, 2)
        };
        let cut = of(30.0, 51.0);
        assert!(cut.len() == 1 && cut[0].damping.is_none() && cut[0].remark.contains("range"), "{cut:?}");
        assert!(of(30.0, 47.0).is_empty() && of(55.0, 80.0).is_empty());
    }

    #[test]
    fn a_peak_that_jumps_is_bent() {
        let frequency = grid(40.0, 60.0, 60);
        // Rises slowly, and falls off at once.
        let size: Vec<f64> =
            frequency.iter().map(|f| if *f < 52.0 { 1.0 / (53.0 - f) } else { 0.15 }).collect();
        let found = peaks(&frequency, &size, 0);
        assert!(found.len() == 1 && (!found[0].remark.is_empty()), "{found:?}");
    }
}
