//! How many periods a steady record spans.

use realfft::RealFftPlanner;

/// A line counts when it stands this far above the median line …
const ABOVE_NOISE: f64 = 8.0;
/// … and reaches this share of the strongest.
const SHARE_OF_STRONGEST: f64 = 1e-3;

/// Number of whole periods in `samples` of a periodic signal that spans whole periods (the sample after
/// the last would repeat the first): the greatest common divisor of the spectral lines that stand out of
/// the noise. The bias does not count. `None` when nothing stands out.
///
/// Use the excitation: what drives the structure has few and clear lines. A fundamental that is absent
/// from it (only 2Ω and 4Ω) is not seen, and the period comes out as a fraction.
pub fn whole_periods(samples: &[f64]) -> Option<usize> {
    if samples.len() < 4 || samples.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(samples.len());
    let mut input = samples.to_vec();
    let mut spectrum = transform.make_output_vec();
    transform.process(&mut input, &mut spectrum).ok()?;
    let sizes: Vec<f64> = spectrum.iter().skip(1).map(|line| line.norm()).collect();
    let strongest = sizes.iter().copied().fold(0.0, f64::max);
    let mut sorted = sizes.clone();
    sorted.sort_by(f64::total_cmp);
    let floor = (ABOVE_NOISE * sorted[sorted.len() / 2]).max(SHARE_OF_STRONGEST * strongest);
    let lines = sizes.iter().enumerate().filter(|(_, size)| **size > floor).map(|(k, _)| k + 1);
    match lines.fold(0, greatest_common_divisor) {
        0 => None,
        periods => Some(periods),
    }
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
