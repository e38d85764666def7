//! A sampled signal between its samples, where these determine it.

use std::f64::consts::PI;

use realfft::RealFftPlanner;

/// Samples on either side that a value between two samples is made of.
const REACH: i64 = 12;
/// Blackman and Harris' window of four terms, by its parts of cosines of multiples of the distance.
const WINDOW: [f64; 4] = [0.358_75, 0.488_29, 0.141_28, 0.011_68];
/// Part of the band up to half the sampling rate that lies near its end.
const NEAR_END: f64 = 0.2;
/// Largest fraction of the power of the differences from sample to sample that may lie there: a jump has that part of it.
const OPEN_END: f64 = 0.05;

/// Values of the signal on a grid `finer` times as fine, from its first sample to its last: by sines over their argument
/// under Blackman and Harris' window, to 1e-5 of tones up to 0.3 of the sampling rate. `None` where the samples do not
/// determine it: what jumps has as much at half the sampling rate as below it.
pub(crate) fn band_limited(values: &[f64], finer: usize) -> Option<Vec<f64>> {
    let count = values.len();
    if count < 2 * REACH as usize || !is_band_limited(values)? {
        return None;
    }
    // Beyond its ends the signal goes on as its reflection through them.
    let last = count as i64 - 1;
    let at = |index: i64| match index {
        before if before < 0 => 2.0 * values[0] - values[-before as usize],
        after if after > last => 2.0 * values[last as usize] - values[(2 * last - after) as usize],
        inside => values[inside as usize],
    };
    let weights: Vec<Vec<f64>> = (1..finer).map(|part| weights(part as f64 / finer as f64)).collect();
    let mut fine = Vec::with_capacity((count - 1) * finer + 1);
    for sample in 0..last {
        fine.push(at(sample));
        for weights in &weights {
            let around = (1 - REACH..=REACH).map(|ahead| at(sample + ahead));
            fine.push(around.zip(weights).map(|(value, weight)| value * weight).sum());
        }
    }
    fine.push(at(last));
    Some(fine)
}

/// Weights of the samples around for a value at the fraction `s` of the way from one to the next.
fn weights(s: f64) -> Vec<f64> {
    let weight = |ahead: i64| {
        let distance = PI * (ahead as f64 - s);
        let window = |(order, part): (usize, &f64)| part * (order as f64 * distance / REACH as f64).cos();
        distance.sin() / distance * WINDOW.iter().enumerate().map(window).sum::<f64>()
    };
    let mut weights: Vec<f64> = (1 - REACH..=REACH).map(weight).collect();
    // A constant stays one.
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

/// Whether little of how the signal changes lies near half the sampling rate; `None` where nothing changes.
fn is_band_limited(values: &[f64]) -> Option<bool> {
    let mut differences: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(differences.len());
    let mut spectrum = transform.make_output_vec();
    transform.process(&mut differences, &mut spectrum).ok()?;
    let power: Vec<f64> = spectrum.iter().map(|line| line.norm_sqr()).collect();
    let near_end = ((1.0 - NEAR_END) * power.len() as f64) as usize;
    let (end, all) = (power[near_end..].iter().sum::<f64>(), power.iter().sum::<f64>());
    (all > 0.0 && all.is_finite()).then_some(end <= OPEN_END * all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_well_inside_the_band_is_followed_between_its_samples() {
        for speed in [0.05, 0.7, 1.4, 2.0] {
            let wave = |place: f64| (speed * place + 0.3).sin() + 0.5;
            let values: Vec<f64> = (0..400).map(|k| wave(f64::from(k))).collect();
            let fine = band_limited(&values, 4).unwrap();
            assert_eq!(fine.len(), 399 * 4 + 1);
            let worst = (100..1500).map(|k| (fine[k] - wave(k as f64 / 4.0)).abs()).fold(0.0, f64::max);
            assert!(worst < 2e-5, "{speed}: {worst:e}");
        }
    }

    #[test]
    fn what_jumps_is_not_determined_and_a_line_stays_one() {
        let step: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 1.0 }).collect();
        assert_eq!(band_limited(&step, 4), None);
        assert_eq!(band_limited(&[1.0; 200], 4), None);
        let ramp: Vec<f64> = (0..200).map(f64::from).collect();
        let fine = band_limited(&ramp, 4).unwrap();
        assert!(fine.iter().enumerate().all(|(k, value)| (value - k as f64 / 4.0).abs() < 1e-9));
    }
}
