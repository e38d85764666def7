//! What a residual looks like: records and their predictions come in, shapes and hints go out. Both are told, neither
//! decides anything.
//!
//! `abscissae` are what a residual may depend on, `shape` is its mean over one of these with the fraction of its variance
//! that this predicts; `hum` looks for lines of its spectrum, `held` for samples that a sensor made up, `drift` for what
//! changes along a record or from record to record.

mod abscissae;
mod drift;
mod held;
mod hum;
mod shape;

pub(crate) use abscissae::reversals;
pub use abscissae::{causes, drive};
pub use hum::Line;
pub use shape::Shape;

use super::compare::{RecordResult, Stage};
use crate::data::{Channel, Record};

/// What the residuals of a dataset look like.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Appearance {
    /// Channel by channel, that which predicts most first.
    pub shapes: Vec<Shape>,
    /// What this may come from.
    pub hints: Vec<Hint>,
}

/// Something that a residual shows, with numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum Hint {
    /// A line of the spectrum that is no harmonic of the excitation.
    Hum(Line),
    /// Samples held at an extreme of the channel.
    Clipping {
        /// Name of the channel, and its unit.
        channel: (String, &'static str),
        /// Where it is held.
        levels: Vec<f64>,
        /// Fraction of the samples.
        fraction: f64,
    },
    /// Samples held in the middle of motion.
    DropOuts {
        /// Name of the channel.
        channel: String,
        /// How often.
        count: usize,
        /// Samples in all.
        samples: usize,
        /// Whether all of them read zero.
        zero: bool,
    },
    /// Measured over predicted changes from the first half of the records to the second.
    Drift {
        /// Name of the channel.
        channel: String,
        /// By how much, as a fraction.
        change: f64,
    },
    /// Measured over predicted changes from record to record, in their order.
    DriftOverRecords {
        /// Name of the channel.
        channel: String,
        /// By how much from the first to the last, as a fraction.
        change: f64,
    },
    /// Nothing predicts as much as what was before: the way since a reversal, or where that was.
    Memory {
        /// Name of the channel.
        channel: String,
        /// What predicts most.
        against: &'static str,
        /// Fraction of the variance that it predicts.
        fraction: f64,
    },
}

impl Hint {
    /// As in JSON.
    pub fn id(&self) -> &'static str {
        match self {
            Self::Hum(_) => "hum",
            Self::Clipping { .. } => "clipping",
            Self::DropOuts { .. } => "drop-outs",
            Self::Drift { .. } | Self::DriftOverRecords { .. } => "drift",
            Self::Memory { .. } => "memory",
        }
    }

    /// Whether the measurement itself is at fault, whatever the model.
    pub fn is_of_the_measurement(&self) -> bool {
        matches!(self, Self::Hum(_) | Self::Clipping { .. } | Self::DropOuts { .. })
    }
}

/// A compared channel of a record.
struct Compared<'r> {
    name: &'r str,
    record: &'r Record,
    measured: &'r [f64],
    predicted: &'r [f64],
    /// Measured minus predicted: what the model lacks.
    lacks: Vec<f64>,
}

/// What the residuals of `stage`, which predicts `records`, look like.
///
/// ```
/// use stickslip::data::{Channel, Record, Regime};
/// use stickslip::fit::compare::{ChannelResult, RecordResult, Stage};
/// use stickslip::fit::residual::{Hint, appearance};
/// // A force that is measured with a hum of 50 Hz beside it, 2 N large, in two records of a second.
/// let noise = |i: usize| 0.1 * ((i * i * 7919 + i * 104_729) % 1000) as f64 / 500.0 - 0.1;
/// let hum: Vec<f64> = (0..1000).map(|i| 2.0 * (0.1 * std::f64::consts::PI * i as f64).sin() + noise(i)).collect();
/// let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
/// let channels =
///     vec![channel("time", "s", (0..1000).map(|i| 1e-3 * f64::from(i)).collect()), channel("force", "N", hum)];
/// let record = Record { name: "pull".into(), regime: Regime::UnknownInitialState, use_for: None, channels };
/// let force =
///     ChannelResult { name: "force".into(), unit: "N", error: 1.0, rms: 1.4, predicted: vec![0.0; 1000] };
/// let result = RecordResult { error: 1.0, channels: vec![force], failure: None };
/// let stage = Stage {
///     name: "as given".into(), parameters: vec![], error: 1.0, records: vec![result; 2], evaluations: 0, notes: vec![]
/// };
/// let found = appearance(&[record.clone(), record], &stage);
/// let Hint::Hum(line) = &found.hints[0] else { panic!() };
/// assert!((line.frequency - 50.0).abs() < 0.1 && (line.amplitude - 2.0).abs() < 0.02);
/// ```
pub fn appearance(records: &[Record], stage: &Stage) -> Appearance {
    let mut found = Appearance::default();
    for (name, unit) in names(stage) {
        let all = compared(records, stage, &name);
        if all.is_empty() {
            continue;
        }
        let mut shapes = shape::of(&all, unit);
        shapes.sort_by(|a, b| b.fraction.total_cmp(&a.fraction));
        found.hints.extend(hum::of(&all, unit).into_iter().map(Hint::Hum));
        found.hints.extend(held::of(&all, unit));
        found.hints.extend(drift::of(&all));
        found.hints.extend(memory(&shapes));
        found.shapes.extend(shapes);
    }
    found
}

/// Lines of a measured channel that its excitation does not make, as if nothing predicted it.
pub(crate) fn lines(record: &Record, channel: &Channel) -> Vec<Line> {
    let (name, measured) = (channel.name.as_str(), channel.values.as_slice());
    let one = Compared { name, record, measured, predicted: &[], lacks: measured.to_vec() };
    hum::of(&[one], channel.unit)
}

/// Compared channels that are samples in time, with their units.
fn names(stage: &Stage) -> Vec<(String, &'static str)> {
    let mut names: Vec<(String, &'static str)> = Vec::new();
    for channel in stage.records.iter().flat_map(|record| &record.channels) {
        if names.iter().all(|(known, _)| *known != channel.name) {
            names.push((channel.name.clone(), channel.unit));
        }
    }
    names
}

fn compared<'r>(records: &'r [Record], stage: &'r Stage, name: &'r str) -> Vec<Compared<'r>> {
    let of = |(record, result): (&'r Record, &'r RecordResult)| {
        let measured = &record.channel(name)?.values;
        let predicted = &result.channels.iter().find(|channel| channel.name == name)?.predicted;
        let lacks: Vec<f64> = measured.iter().zip(predicted).map(|(m, p)| m - p).collect();
        let whole = record.time().is_some_and(|time| time.len() == lacks.len());
        (whole && lacks.iter().all(|x| x.is_finite())).then_some(Compared {
            name,
            record,
            measured,
            predicted,
            lacks,
        })
    };
    records.iter().zip(&stage.records).filter_map(of).collect()
}

/// Whether what was before predicts most of all.
fn memory(shapes: &[Shape]) -> Option<Hint> {
    let first = shapes.first().filter(|shape| shape.fraction > 0.0 && shape.remembers())?;
    Some(Hint::Memory { channel: first.channel.clone(), against: first.against, fraction: first.fraction })
}

#[cfg(test)]
mod tests;
