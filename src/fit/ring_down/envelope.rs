//! The strongest vibration of a channel, and where it begins to decay freely.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

/// A line that is not this far above the median line is noise.
const ABOVE_NOISE: f64 = 8.0;
/// Cycles over which the amplitude is seen, and the fraction of the largest that still counts as the largest.
const CYCLES: f64 = 4.0;
const LARGEST: f64 = 0.97;
/// Half cycles over which a rate is seen.
const RATE_OVER: usize = 8;

/// The strongest line of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub cycles_per_sample: f64,
    /// Over the median line.
    pub above_noise: f64,
}

/// The strongest line of `values`, where one stands out.
pub(super) fn strongest(values: &[f64]) -> Option<Line> {
    let count = values.len();
    if count < 64 || values.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count as f64;
    let mut input: Vec<f64> = values.iter().map(|x| x - mean).collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(count);
    let mut spectrum = transform.make_output_vec();
    transform.process(&mut input, &mut spectrum).ok()?;
    let sizes: Vec<f64> = spectrum.iter().map(|line| line.norm()).collect();
    // The first lines are drift.
    let (place, largest) = sizes
        .iter()
        .enumerate()
        .skip(4)
        .max_by(|a, b| a.1.total_cmp(b.1))
        .map(|(place, size)| (place, *size))?;
    let mut sorted = sizes[1..].to_vec();
    sorted.sort_by(f64::total_cmp);
    let above_noise = largest / sorted[sorted.len() / 2].max(f64::MIN_POSITIVE);
    // The line of a decay is wide: its middle, by the power around the peak.
    let around = place.saturating_sub(3).max(1)..=(place + 3).min(sizes.len() - 1);
    let power: f64 = around.clone().map(|line| sizes[line].powi(2)).sum();
    let middle = around.map(|line| line as f64 * sizes[line].powi(2)).sum::<f64>() / power;
    (above_noise > ABOVE_NOISE).then(|| Line { cycles_per_sample: middle / count as f64, above_noise })
}

/// Amplitudes at `cycles_per_sample` over a few cycles from each half cycle on, and the samples between two of them.
pub(super) fn amplitudes(values: &[f64], cycles_per_sample: f64) -> (Vec<f64>, f64) {
    let (length, stride) = (CYCLES / cycles_per_sample, 0.5 / cycles_per_sample);
    let count = ((values.len() as f64 - length) / stride).max(0.0) as usize;
    let speed = TAU * cycles_per_sample;
    let one = |place: usize| {
        let first = (place as f64 * stride) as usize;
        let samples = length as usize;
        let (mut cosine, mut sine, mut sum) = (0.0, 0.0, 0.0);
        for (k, value) in values[first..first + samples].iter().enumerate() {
            let weight = 1.0 - (TAU * (k as f64 + 0.5) / samples as f64).cos();
            let phase = speed * k as f64;
            cosine += weight * value * phase.cos();
            sine += weight * value * phase.sin();
            sum += weight;
        }
        2.0 * f64::hypot(cosine, sine) / sum
    };
    ((0..count).map(one).collect(), stride)
}

/// The sample from which on a vibration with these amplitudes decays freely: past its largest.
pub(super) fn beginning(amplitudes: &[f64], stride: f64) -> f64 {
    let largest = amplitudes.iter().fold(0.0_f64, |most, x| most.max(*x));
    let Some(last) = amplitudes.iter().rposition(|x| *x >= LARGEST * largest) else { return 0.0 };
    // A decay from the first sample on has fallen so far after as many half cycles as its rate says.
    let ahead = amplitudes.get(last + RATE_OVER).copied().unwrap_or(largest);
    let fall = (amplitudes[last] / ahead).ln() / RATE_OVER as f64;
    if last as f64 * fall <= 2.0 * (1.0 / LARGEST).ln() + 2.0 * fall {
        return 0.0;
    }
    // The last window that shows the largest amplitude may end with the excitation.
    (last as f64 + 2.0 * CYCLES) * stride
}
