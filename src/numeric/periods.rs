//! How many periods a steady record spans.

use realfft::RealFftPlanner;

/// A line counts when it stands this far above the median line, and above the noise around it …
const ABOVE_NOISE: f64 = 8.0;
/// … and reaches this fraction of the strongest.
const FRACTION_OF_STRONGEST: f64 = 1e-3;
/// A harmonic of a known period counts when it stands this far above the median of the lines around it that are none:
/// of noise, one in 10⁸ does.
const HARMONIC_ABOVE_NOISE: f64 = 5.0;
/// So many lines around one: noise may have far more at low frequencies than elsewhere.
const AROUND: usize = 12;
/// The median line of noise over its lower quartile, which harmonics among the lines leave as it is.
const MEDIAN_OVER_QUARTILE: f64 = 1.55;
/// … and reaches this fraction of the strongest, below which lies rounding.
const HARMONIC_FRACTION: f64 = 1e-7;

/// Number of whole periods in `samples` of a periodic signal that spans whole periods (the sample after
/// the last would repeat the first): the greatest common divisor of the spectral lines that stand out of
/// the noise. The bias does not count. `None` when nothing stands out.
///
/// Use the excitation: what drives the structure has few and clear lines. A fundamental that is absent
/// from it (only 2Ω and 4Ω) is not seen, and the period comes out as a fraction.
pub fn whole_periods(samples: &[f64]) -> Option<usize> {
    let sizes = line_sizes(samples)?;
    let strongest = sizes[1..].iter().copied().fold(0.0, f64::max);
    let floor = (ABOVE_NOISE * median(&sizes[1..])).max(FRACTION_OF_STRONGEST * strongest);
    let stands_out = |line: &usize| {
        let above_noise = || {
            let around = lines_around(&sizes, *line, |other| other != *line);
            sizes[*line] > ABOVE_NOISE * MEDIAN_OVER_QUARTILE * quantile(&around, 4)
        };
        sizes[*line] > floor && above_noise()
    };
    match (1..sizes.len()).filter(stands_out).fold(0, greatest_common_divisor) {
        0 => None,
        periods => Some(periods),
    }
}

/// As [`whole_periods`], of several signals at once; those in which nothing stands out do not count.
pub fn common_periods<'s>(signals: impl IntoIterator<Item = &'s [f64]>) -> Option<usize> {
    match signals.into_iter().filter_map(whole_periods).fold(0, greatest_common_divisor) {
        0 => None,
        periods => Some(periods),
    }
}

/// The harmonics, ascending, that stand out of the noise in `samples` of `periods` whole periods; 0 is a bias.
pub fn excited_harmonics(samples: &[f64], periods: usize) -> Vec<usize> {
    let Some(sizes) = line_sizes(samples).filter(|_| periods > 0) else { return Vec::new() };
    let strongest = sizes[1..].iter().copied().fold(0.0, f64::max);
    let everywhere = median(&sizes[1..]);
    let stands_out = |line: usize| {
        let around = lines_around(&sizes, line, |other| !other.is_multiple_of(periods));
        let noise = if around.is_empty() { everywhere } else { median(&around) };
        sizes[line] > (HARMONIC_ABOVE_NOISE * noise).max(HARMONIC_FRACTION * strongest)
    };
    let harmonics = (0..sizes.len()).step_by(periods).enumerate();
    harmonics.filter(|(_, line)| stands_out(*line)).map(|(harmonic, _)| harmonic).collect()
}

/// The lines nearest to `line` of those that count.
fn lines_around(sizes: &[f64], line: usize, counts: impl Fn(usize) -> bool) -> Vec<f64> {
    let (first, last) = (line.saturating_sub(2 * AROUND).max(1), (line + 2 * AROUND).min(sizes.len() - 1));
    let mut around: Vec<usize> = (first..=last).filter(|other| counts(*other)).collect();
    around.sort_by_key(|other| other.abs_diff(line));
    around.iter().take(AROUND).map(|other| sizes[*other]).collect()
}

/// Sizes of the spectral lines, the bias (half as large as a line of its power) first.
fn line_sizes(samples: &[f64]) -> Option<Vec<f64>> {
    if samples.len() < 4 || samples.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(samples.len());
    let mut input = samples.to_vec();
    let mut spectrum = transform.make_output_vec();
    transform.process(&mut input, &mut spectrum).ok()?;
    let mut sizes: Vec<f64> = spectrum.iter().map(|line| line.norm()).collect();
    sizes[0] *= 0.5;
    Some(sizes)
}

fn median(values: &[f64]) -> f64 {
    quantile(values, 2)
}

/// The value that one in `fraction` lies below; 0 of none.
fn quantile(values: &[f64], fraction: usize) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(values.len() / fraction).copied().unwrap_or(0.0)
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
