//! Measured data: arrays in, arrays out. Names and units of columns, and the records they make up.

mod channel;
mod record;
mod unit;

pub use channel::{COLUMNS, ChannelName, ChannelNameError, Place};
pub use unit::{UnitError, unit_factor, unit_size};

/// How a record begins.
///
/// ```
/// use stickslip::data::{Record, Regime};
/// // The loop's start is unknown: a prediction fits it.
/// let record =
///     Record { name: "loop.csv".into(), regime: Regime::UnknownInitialState, use_for: None, channels: vec![] };
/// assert!(record.is_empty());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// At t = 0 nothing moves, and no contact has slipped before.
    FromRest,
    /// Whole periods of a steady state.
    Steady,
    /// The contact's state at t = 0 is unknown.
    UnknownInitialState,
    /// A table of frequency (and damping) against amplitude.
    Backbone,
    /// A table of amplitudes and phases of the steady response against frequency and excitation.
    SteppedSine,
}

impl Regime {
    /// Whether such a record is a table, without time stamps.
    ///
    /// ```
    /// use stickslip::data::Regime;
    /// assert!(Regime::Backbone.is_table() && !Regime::Steady.is_table());
    /// ```
    pub fn is_table(self) -> bool {
        matches!(self, Self::Backbone | Self::SteppedSine)
    }
}

/// What a record may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Parameters are fitted to it.
    Fit,
    /// Effects are selected by the error on it.
    Select,
    /// Read once, at the end, as a test.
    Confirm,
}

/// One column of a record, in SI.
///
/// ```
/// use stickslip::data::Channel;
/// let values = vec![0.0, 9.81];
/// let channel = Channel { name: "acceleration:x=0.55".into(), unit: "m/s^2", values, noise: Some(0.02) };
/// assert_eq!((channel.quantity(), channel.position()), ("acceleration", Some(0.55)));
/// ```
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
///
/// ```
/// use stickslip::data::{Channel, Record, Regime};
/// let channel = |name: &str, unit, values: &[f64]| {
///     Channel { name: name.into(), unit, values: values.to_vec(), noise: None }
/// };
/// let channels = vec![channel("time", "s", &[0.0, 0.1]), channel("force", "N", &[0.0, 5.0])];
/// let record = Record { name: "pull.csv".into(), regime: Regime::FromRest, use_for: None, channels };
/// assert_eq!(record.len(), 2);
/// assert_eq!(record.channel("force").unwrap().values, [0.0, 5.0]);
/// ```
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
///
/// ```
/// use stickslip::data::Dataset;
/// let dataset = Dataset { title: Some("Loops of 12 March".into()), records: vec![] };
/// assert!(dataset.records.is_empty());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// `title` of the dataset, if any.
    pub title: Option<String>,
    /// Its records, in the file's order.
    pub records: Vec<Record>,
}
