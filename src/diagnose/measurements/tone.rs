//! A steady tone in what should be noise: a line of the spectrum that stands alone.
//!
//! Periods of a motion also differ by what repeats at another frequency: a second machine, a normal load that
//! nobody measured. That is no noise, and taken for noise it hides itself.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

/// Fraction of the variance above which one tone is no chance. Noise correlated over a fortieth of a record, as
/// slow as noise is here, reached one half in none of a hundred records.
const ALONE: f64 = 0.75;
/// Fewest cycles within the values: below, a tone and a drift are alike.
const CYCLES: f64 = 1.5;
/// Lines of the spectrum per cycle within the values.
const FINE: usize = 4;

/// Variance of `values` without a tone that makes nearly all of it; `None` where no tone does.
pub(in crate::diagnose) fn variance_beside(values: &[f64]) -> Option<f64> {
    let count = values.len();
    if count < 64 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count as f64;
    let whole: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let length = FINE * count.next_power_of_two();
    let forward = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let mut series = vec![0.0; length];
    for (place, value) in series.iter_mut().zip(values) {
        *place = value - mean;
    }
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut series, &mut spectrum).ok()?;
    let lowest = (CYCLES * length as f64 / count as f64).ceil() as usize;
    let (line, _) = spectrum
        .iter()
        .enumerate()
        .skip(lowest)
        .map(|(line, value)| (line, value.norm_sqr()))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    // Between the lines the best frequency lies nearest to the bottom of a parabola.
    let left = |place: f64| beside(values, mean, TAU * place / length as f64);
    let place = line as f64;
    let [before, here, after] = [place - 0.5, place, place + 0.5].map(left);
    let bend = before - 2.0 * here + after;
    let offset = if bend > 0.0 { (0.25 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    let rest = left(place + offset).min(here);
    (rest < (1.0 - ALONE) * whole).then(|| rest / (count - 4) as f64)
}

/// Sum of squares of `values` about `mean`, beside the sine and the cosine of `angle` per sample that fit best.
fn beside(values: &[f64], mean: f64, angle: f64) -> f64 {
    let (mut whole, mut products, mut squares) = (0.0, [0.0; 2], [0.0; 3]);
    for (index, value) in values.iter().enumerate() {
        let (sin, cos) = (angle * index as f64).sin_cos();
        let value = value - mean;
        whole += value * value;
        products[0] += value * sin;
        products[1] += value * cos;
        squares[0] += sin * sin;
        squares[1] += sin * cos;
        squares[2] += cos * cos;
    }
    let [a, b, c] = squares;
    let determinant = a * c - b * b;
    if determinant <= 1e-9 * a * c {
        return whole;
    }
    let [s, k] = products;
    whole - (c * s * s - 2.0 * b * s * k + a * k * k) / determinant
}

#[cfg(test)]
mod tests {
    use super::variance_beside;
    use std::f64::consts::TAU;

    /// Numbers of deviation one, each like the one before it by `correlation`.
    fn noise(count: usize, correlation: f64, seed: u64) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut uniform = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state as f64 / u64::MAX as f64
        };
        let mut last = 0.0;
        (0..count + 500)
            .map(|_| {
                let normal = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                last = correlation * last + (1.0 - correlation * correlation).sqrt() * normal;
                last
            })
            .skip(500)
            .collect()
    }

    #[test]
    fn beside_a_tone_the_noise_remains() {
        for (cycles, seed) in [(2.7, 1), (11.3, 2), (44.0, 3)] {
            let mut values = noise(800, 0.0, seed);
            for (index, value) in values.iter_mut().enumerate() {
                *value += 6.0 * (TAU * cycles * index as f64 / 800.0 + 0.4).sin();
            }
            let left = variance_beside(&values).unwrap();
            assert!((left - 1.0).abs() < 0.15, "{cycles}: {left}");
        }
    }

    #[test]
    fn noise_has_no_tone_however_coloured() {
        for correlation in [0.0, 0.9, 0.95] {
            for seed in 0..40 {
                assert_eq!(variance_beside(&noise(800, correlation, 7 + seed)), None, "{correlation} {seed}");
            }
        }
    }
}
