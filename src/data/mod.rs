//! Measured data: arrays in, arrays out. Names and units of columns, and the records they make up.

mod channel;
mod record;
mod unit;

pub use channel::{COLUMNS, ChannelName, ChannelNameError, Place};
pub use unit::{UnitError, unit_factor, unit_size};

/// How a record begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// Nothing moves and nothing is remembered at t = 0.
    FromRest,
    /// Whole periods of a steady state.
    Steady,
    /// The contact's state at t = 0 is unknown.
    UnknownInitialState,
    /// A table of frequency (and damping) against amplitude.
    Backbone,
}

/// What a record may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Parameters are fitted to it.
    Fit,
    /// Models are chosen by it.
    Select,
    /// Read once, at the end.
    Confirm,
}

/// One column of a record, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Column name without its unit, as [`ChannelName`] writes it: `force`, `acceleration:x=0.55`.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Values in that unit.
    pub values: Vec<f64>,
    /// Standard deviation of the noise in that unit, where the dataset states it.
    pub noise: Option<f64>,
}

/// One file of a dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// The file's name as the dataset writes it.
    pub name: String,
    /// How it begins.
    pub regime: Regime,
    /// What it may be used for, if the dataset says.
    pub use_for: Option<Use>,
    /// Its columns, all of the same length.
    pub channels: Vec<Channel>,
}

/// A dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// `title` of the dataset, if any.
    pub title: Option<String>,
    /// Its records, in the file's order.
    pub records: Vec<Record>,
}
