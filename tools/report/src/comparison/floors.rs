//! The error that noise alone would cause.

use stickslip::diagnose::{Comparison, Noise, NoiseSource};

use crate::comparison::summary::{self, Summary};
use crate::format;

/// The noise of channel `name` of record `record`, in its unit.
pub fn deviation(noise: &[Noise], record: usize, name: &str) -> Option<f64> {
    noise.iter().find(|one| one.record == record && one.channel == name).and_then(|one| one.deviation)
}

/// The noise over the channel's standard deviation: the error of a perfect model.
pub fn fraction(comparison: &Comparison, noise: &[Noise], record: usize, name: &str) -> Option<f64> {
    let spread = crate::explorer::deviation(&summary::channel(&comparison.records[record], name)?.values);
    deviation(noise, record, name).map(|noise| noise / spread).filter(|fraction| fraction.is_finite())
}

/// The normalised error of a perfect model in one record; `None` where the noise of a channel is unknown.
pub fn of_record(comparison: &Comparison, noise: &[Noise], record: usize) -> Option<f64> {
    let channels = summary::compared_channels(comparison, record);
    let squares: Option<Vec<f64>> =
        channels.iter().map(|(name, _)| Some(fraction(comparison, noise, record, name)?.powi(2))).collect();
    squares.filter(|all| !all.is_empty()).map(|all| (all.iter().sum::<f64>() / all.len() as f64).sqrt())
}

/// The normalised error of a perfect model over all compared channels; `None` where the noise of one is unknown.
pub fn total(comparison: &Comparison, noise: &[Noise]) -> Option<f64> {
    let (mut squares, mut count) = (0.0, 0_usize);
    for record in 0..comparison.records.len() {
        for (name, _) in summary::compared_channels(comparison, record) {
            squares += fraction(comparison, noise, record, &name)?.powi(2);
            count += 1;
        }
    }
    (count > 0).then(|| (squares / count as f64).sqrt())
}

/// Beyond noise by less than this, in fractions of it: what remains of the model's own error is a fifth of the noise.
const SLACK: f64 = 0.02;
/// Normalised errors up to this are rounding: the data are a model's own.
const ROUNDING: f64 = 1e-9;
/// Less than this fraction of the noise: the noise is smaller than it is said to be.
const LESS: f64 = 0.7;

/// What an error that remains is beside that of noise alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Against {
    /// Less than noise leaves.
    Less,
    /// As noise leaves it.
    Noise,
    /// More than noise leaves.
    More,
}

/// What an error of `times` that of noise alone is, of which noise explains the `largest`.
fn against(times: f64, largest: f64) -> Against {
    match times {
        times if times > largest => Against::More,
        times if times < LESS => Against::Less,
        _ => Against::Noise,
    }
}

/// What an error that `remains` in the records of `which` is beside the `floor` that noise leaves there.
pub fn of_remains(
    comparison: &Comparison,
    noise: &[Noise],
    which: impl Fn(usize) -> bool,
    [remains, floor]: [f64; 2],
) -> Against {
    against(remains / floor, largest(comparison, noise, which).unwrap_or(f64::INFINITY))
}

/// The largest error over that of noise alone that noise explains in the records of `which`; `None` where it is unknown.
fn largest(comparison: &Comparison, noise: &[Noise], which: impl Fn(usize) -> bool) -> Option<f64> {
    let (mut values, mut doubt) = (0_usize, 0.0_f64);
    for record in (0..comparison.records.len()).filter(|record| which(*record)) {
        for (name, _) in summary::compared_channels(comparison, record) {
            let known = noise.iter().find(|one| one.record == record && one.channel == name)?;
            values += summary::channel(&comparison.records[record], &name)?.values.len();
            doubt = doubt.max(known.log_error);
        }
    }
    // Two standard deviations of what the noise is known by, and of what a mean square of so many values scatters.
    Some(1.0 + SLACK + 2.0 * doubt + 2.0 / (2.0 * values as f64).sqrt())
}

/// The error that remains in the last stage over that of noise alone, and the largest ratio that noise explains.
struct Ratio {
    value: f64,
    noise: f64,
    largest: f64,
}

/// Over the records that every stage predicts; `None` where the noise is unknown.
fn ratio(comparison: &Comparison, summary: &Summary, noise: &[Noise]) -> Option<Ratio> {
    let known = |record: usize| !summary.skipped.iter().any(|(skipped, _)| *skipped == record);
    let (mut squares, mut channels) = (0.0, 0_usize);
    for record in (0..comparison.records.len()).filter(|record| known(*record)) {
        for (name, _) in summary::compared_channels(comparison, record) {
            squares += fraction(comparison, noise, record, &name)?.powi(2);
            channels += 1;
        }
    }
    let largest = largest(comparison, noise, known)?;
    let noise = (squares / channels as f64).sqrt();
    let value = summary.normalised.last()? / noise;
    value.is_finite().then_some(Ratio { value, noise, largest })
}

/// `verdict` after what was found before any fit, and followed by what the noise says of it.
pub fn with_noise(verdict: &str, comparison: &Comparison, summary: &Summary, noise: &[Noise]) -> String {
    super::findings::before_all(&comparison.findings) + &beside_noise(verdict, comparison, summary, noise)
}

fn beside_noise(verdict: &str, comparison: &Comparison, summary: &Summary, noise: &[Noise]) -> String {
    let Some(remains) = summary.normalised.last().filter(|error| **error > ROUNDING) else {
        return verdict.to_owned();
    };
    let Some(ratio) = ratio(comparison, summary, noise) else {
        return format!(
            "{verdict} How much of it is noise is unknown: state `noise` in dataset.toml, or measure it again."
        );
    };
    let times = format::significant(ratio.value, 3);
    let sentence = match against(ratio.value, ratio.largest) {
        Against::More => "the model lacks something that these data show; `stickslip diagnose` looks for it",
        Against::Less => {
            "less than the noise: it is smaller than it is said to be, or the fit follows it; check `noise` in dataset.toml"
        }
        Against::Noise => "no more than noise: these data show nothing that the model lacks",
    };
    format!(
        "{verdict} What remains ({}) is {times} times the noise ({}, {}): {sentence}.",
        format::error(*remains),
        format::error(ratio.noise),
        sources(noise)
    )
}

/// The same as JSON.
pub fn to_json(comparison: &Comparison, summary: &Summary, noise: &[Noise]) -> serde_json::Value {
    let verdict = |ratio: &Ratio| match against(ratio.value, ratio.largest) {
        Against::More => "more-than-noise",
        Against::Less => "less-than-noise",
        Against::Noise => "noise",
    };
    match ratio(comparison, summary, noise) {
        Some(ratio) => {
            serde_json::json!({ "ratio": ratio.value, "largest": ratio.largest, "verdict": verdict(&ratio) })
        }
        None => serde_json::json!({ "ratio": null, "largest": null, "verdict": "unknown" }),
    }
}

/// How the noise is known, as a sentence about all of it.
pub fn sources(noise: &[Noise]) -> String {
    let words = |source| match source {
        NoiseSource::Stated => "stated in the dataset",
        NoiseSource::Periods => "from repeated periods",
        NoiseSource::Repeats => "from repeated records",
        NoiseSource::Carried => "taken from other records",
        NoiseSource::Unknown => "unknown",
    };
    let mut found: Vec<&str> = Vec::new();
    for one in noise {
        let words = words(one.source);
        if !found.contains(&words) {
            found.push(words);
        }
    }
    if found.is_empty() { "unknown".to_owned() } else { found.join(", ") }
}
