//! A slow sine sweep, cut into stretches of some cycles.

use std::f64::consts::TAU;
use std::ops::Range;

use realfft::num_complex::Complex;

/// Cycles that a sweep has at least, and that a stretch has at least.
const CYCLES: (usize, usize) = (24, 4);
/// Stretches of a record at most.
const STRETCHES: usize = 150;
/// Samples of a cycle at least.
const SAMPLES: usize = 6;
/// Ratio of the highest to the lowest frequency from which on a record is a sweep.
const SWEPT: f64 = 1.15;
/// Fraction of the stretches that may run against the direction of the sweep.
const AGAINST: f64 = 0.05;
/// Fraction of the drive's mean square that is no sine at most.
const IMPURE: f64 = 0.05;

/// Some cycles of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Mean frequency (Hz).
    pub frequency: f64,
    samples: Range<usize>,
    /// Phase of the drive at each sample, from one upward crossing of zero to the next (rad).
    phase: Vec<f64>,
}

/// The stretches of a sweep; `None` where `drive` over `time` is no sine whose frequency rises or falls slowly.
pub fn stretches(time: &[f64], drive: &[f64]) -> Option<Vec<Stretch>> {
    let crossings = crossings(time, drive);
    let cycles = crossings.len().checked_sub(1).filter(|cycles| *cycles >= CYCLES.0)?;
    let length = CYCLES.1.max(cycles.div_ceil(STRETCHES));
    let found: Vec<Stretch> =
        (0..cycles / length).map(|part| stretch(time, &crossings[part * length..][..=length])).collect();
    let rises = found.last()?.frequency > found[0].frequency;
    let against = found.windows(2).filter(|pair| (pair[1].frequency > pair[0].frequency) != rises).count();
    let (first, last) = (found[0].frequency, found.last()?.frequency);
    let swept = (first / last).max(last / first) >= SWEPT && against as f64 <= AGAINST * found.len() as f64;
    let sampled = found.iter().all(|one| one.samples.len() >= SAMPLES * length);
    (swept && sampled && found.iter().all(|one| one.is_sine(drive))).then_some(found)
}

/// Times at which `drive` passes zero upwards, with the sample after each.
fn crossings(time: &[f64], drive: &[f64]) -> Vec<(f64, usize)> {
    let upward = |i: &usize| drive[i - 1] < 0.0 && drive[*i] >= 0.0;
    let length = time.len().min(drive.len());
    let passed = |i: usize| {
        let fraction = drive[i - 1] / (drive[i - 1] - drive[i]);
        (time[i - 1] + fraction * (time[i] - time[i - 1]), i)
    };
    (1..length).filter(upward).map(passed).collect()
}

fn stretch(time: &[f64], crossings: &[(f64, usize)]) -> Stretch {
    let cycles = crossings.len() - 1;
    let (begin, end) = (crossings[0], crossings[cycles]);
    let mut phase = Vec::with_capacity(end.1 - begin.1);
    for (cycle, pair) in crossings.windows(2).enumerate() {
        let period = pair[1].0 - pair[0].0;
        let at = |sample: usize| TAU * (cycle as f64 + (time[sample] - pair[0].0) / period);
        phase.extend((pair[0].1..pair[1].1).map(at));
    }
    Stretch { frequency: cycles as f64 / (end.0 - begin.0), samples: begin.1..end.1, phase }
}

impl Stretch {
    /// The first harmonic of a column: `v = Re(c e^{iφ})` with the phase φ of the drive.
    pub fn first(&self, values: &[f64]) -> Complex<f64> {
        let Some(values) = values.get(self.samples.clone()) else { return Complex::new(f64::NAN, 0.0) };
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let turned =
            values.iter().zip(&self.phase).map(|(value, phase)| Complex::from_polar(value - mean, -phase));
        turned.sum::<Complex<f64>>() * (2.0 / count)
    }

    fn is_sine(&self, drive: &[f64]) -> bool {
        let values = &drive[self.samples.clone()];
        let first = self.first(drive);
        let rest = values
            .iter()
            .zip(&self.phase)
            .map(|(value, phase)| (value - (first * Complex::from_polar(1.0, *phase)).re).powi(2));
        rest.sum::<f64>() <= IMPURE * values.iter().map(|value| value * value).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(rate: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 1e-3).collect();
        let phase = |t: f64| TAU * (5.0 * t + 0.5 * rate * t * t);
        let drive = time.iter().map(|t| 3.0 * phase(*t).sin()).collect();
        // Twice the amplitude, 0.4 rad behind, and an offset.
        let answer = time.iter().map(|t| 1.0 + 6.0 * (phase(*t) - 0.4).sin()).collect();
        (time, drive, answer)
    }

    #[test]
    fn a_known_ratio_and_phase_come_back_at_every_frequency_up_and_down() {
        for rate in [1.0, -0.15] {
            let (time, drive, answer) = sweep(rate);
            let found = stretches(&time, &drive).unwrap();
            for one in &found {
                let ratio = one.first(&answer) / one.first(&drive);
                assert!((ratio.norm() - 2.0).abs() < 0.02 && (ratio.arg() + 0.4).abs() < 0.01, "{ratio}");
            }
            let (first, last) = (found[0].frequency, found.last().unwrap().frequency);
            assert!((first - 5.0).abs() < 0.6 && (last - (5.0 + 20.0 * rate)).abs() < 0.6, "{first} {last}");
        }
    }

    #[test]
    fn a_steady_sine_and_noise_are_no_sweeps() {
        let (time, drive, _) = sweep(0.0);
        assert_eq!(stretches(&time, &drive), None);
        let mut random = fastrand::Rng::with_seed(3);
        let noise: Vec<f64> = time.iter().map(|_| random.f64() - 0.5).collect();
        assert_eq!(stretches(&time, &noise), None);
    }
}
