//! The result of comparing models with measurements, as data for tables, JSON and reports.

use crate::measure::Record;

/// One or more models (or the same before and after a refit) against one dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// What was compared, for a heading.
    pub title: String,
    /// The measurements, in SI.
    pub records: Vec<Record>,
    /// The models in the order they were tried: baseline first.
    pub stages: Vec<Stage>,
}

/// One model's predictions of all records.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Short name: `baseline`, `refitted`, `Valanis, published`.
    pub name: String,
    /// Parameters of the model, fitted ones marked.
    pub parameters: Vec<Parameter>,
    /// Root-mean-square over all channels of all records, each normalised by its own standard
    /// deviation in its record (1).
    pub error: f64,
    /// One entry per record, in the order of [`Comparison::records`].
    pub records: Vec<RecordResult>,
    /// Model evaluations spent on the fit; 0 where nothing was fitted.
    pub evaluations: usize,
}

/// A parameter of a stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Path in the model file: `contact.friction_coefficient`.
    pub path: String,
    /// SI unit.
    pub unit: &'static str,
    /// Value used.
    pub value: f64,
    /// Value before the fit, where it was fitted.
    pub fitted_from: Option<f64>,
}

/// One record as a stage predicts it.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordResult {
    /// Root-mean-square over this record's compared channels, normalised as [`Stage::error`].
    pub error: f64,
    /// The compared channels.
    pub channels: Vec<ChannelResult>,
    /// Why this record has no prediction (solver failed to converge ...); then `channels` is empty.
    pub failure: Option<String>,
}

/// One channel as a stage predicts it.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelResult {
    /// Channel name, as in the record, e.g. `force`, `frequency`.
    pub name: String,
    /// SI unit (Hz for a frequency).
    pub unit: &'static str,
    /// Root-mean-square error over the channel's standard deviation (1).
    pub error: f64,
    /// Root-mean-square error in `unit`.
    pub rms: f64,
    /// Prediction at the record's samples, in `unit`.
    pub predicted: Vec<f64>,
}
