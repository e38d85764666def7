//! The error that noise alone would cause.

use stickslip::diagnose::{Comparison, Noise, NoiseSource};

use crate::summary;

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
