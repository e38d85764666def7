//! What is wrong with measurements before anything is fitted: a model and a dataset come in, findings go out.
//!
//! They are told and decide nothing. `samples`: single samples and runs of them; `time`: time stamps; `rest`: records that were
//! moving when they should not; `model`: values that no machine has; `copies`: channels and records that are there twice; `hum`: the
//! mains; `sign`: a force or an excitation of the other sign; `scale` and `dynamic`: units that are off by powers of ten, in the data
//! or in the model, of contacts and of structures; `table`: motions beyond a measured law.
//!
//! A finding is told only where nothing else makes what is seen: the limits are far from what noise, friction and impacts do, so that
//! clean data have none.

mod copies;
mod dynamic;
mod hum;
mod model;
mod rest;
mod samples;
mod scale;
mod sign;
mod table;
#[cfg(test)]
mod tests;
mod time;

pub(super) use table::{BEYOND, range_of};

use crate::data::{Channel, Dataset, Record};
use crate::model::Model;

/// Something that is wrong with a record or with the model it is compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Name of the record; `None` where it concerns the model.
    pub record: Option<String>,
    /// Name of the channel, or path of the model's parameter; `None` where it concerns the whole record.
    pub channel: Option<String>,
    /// What is wrong.
    pub fault: Fault,
}

/// What is wrong. Places count samples from 0.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// Samples far from all others, alone or as the code of an error.
    Outlier {
        /// The sample.
        sample: usize,
        /// Its value, and what its neighbours say, in the channel's unit.
        value: f64,
        /// See `value`.
        expected: f64,
        /// Unit of both.
        unit: &'static str,
        /// How many there are in the channel.
        count: usize,
    },
    /// Samples held at an end of the channel.
    Clipping {
        /// Where it is held.
        level: f64,
        /// Unit of the level.
        unit: &'static str,
        /// Fraction of the samples.
        fraction: f64,
    },
    /// Samples held in the middle of motion, or at zero.
    DropOuts {
        /// How often.
        count: usize,
        /// First sample of the first one.
        first: usize,
        /// Whether all of them read zero.
        zero: bool,
    },
    /// Values are multiples of a coarse step.
    Quantisation {
        /// The step over the channel's standard deviation.
        fraction: f64,
    },
    /// A line at the frequency of the mains.
    MainsHum {
        /// Frequency (Hz).
        frequency: f64,
        /// Amplitude in `unit`.
        amplitude: f64,
        /// Unit of the channel.
        unit: &'static str,
    },
    /// A stretch of time without samples.
    TimeGap {
        /// Last sample before it.
        sample: usize,
        /// Its length (s).
        length: f64,
        /// Steps of the record that are missing, in all such stretches.
        missing: usize,
        /// How many stretches there are.
        count: usize,
    },
    /// Time stamps of an even clock have too few digits.
    RoundedTime {
        /// Their last digit (s).
        digit: f64,
        /// The clock's step (s).
        step: f64,
    },
    /// The record is said to begin at rest, and does not.
    MovingAtStart {
        /// First value over the largest.
        fraction: f64,
    },
    /// The record is said to begin at rest, and begins with a motion that the excitation does not make.
    MovingUndriven {
        /// What the excitation does not explain of the first period, over all of it.
        fraction: f64,
    },
    /// The channel has the values of another.
    CopyOf {
        /// Name of the other channel.
        other: String,
    },
    /// The record has the values of another.
    GivenTwice {
        /// Name of the other record.
        other: String,
    },
    /// The force feeds energy in.
    ReversedSign {
        /// Energy in the record (J) over the largest that force and motion could have.
        fraction: f64,
    },
    /// Data and model are orders of magnitude apart.
    Scale {
        /// What is compared, in words.
        what: &'static str,
        /// What the data say.
        measured: f64,
        /// What the model says.
        modelled: f64,
        /// Unit of both.
        unit: &'static str,
        /// The likely cause, in words.
        cause: &'static str,
    },
    /// The contact moves farther than the table of its measured law goes.
    BeyondTable {
        /// Half of its motion (m).
        moved: f64,
        /// Where the table ends (m).
        range: f64,
    },
    /// A parameter of the model that no machine has.
    Implausible {
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// The likely cause, in words.
        cause: &'static str,
    },
}

impl Fault {
    /// As in JSON.
    pub fn id(&self) -> &'static str {
        match self {
            Self::Outlier { .. } => "outlier",
            Self::Clipping { .. } => "clipping",
            Self::DropOuts { .. } => "drop-outs",
            Self::Quantisation { .. } => "quantisation",
            Self::MainsHum { .. } => "mains-hum",
            Self::TimeGap { .. } => "time-gap",
            Self::RoundedTime { .. } => "rounded-time",
            Self::MovingAtStart { .. } | Self::MovingUndriven { .. } => "moving-at-start",
            Self::CopyOf { .. } => "copy-of-channel",
            Self::GivenTwice { .. } => "given-twice",
            Self::ReversedSign { .. } => "reversed-sign",
            Self::Scale { .. } => "scale",
            Self::BeyondTable { .. } => "beyond-table",
            Self::Implausible { .. } => "implausible",
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Outlier { sample, value, expected, unit, count } => {
                let more = if *count > 1 { format!(" ({count} such samples)") } else { String::new() };
                format!(
                    "sample {} is {value:.4e} {unit}, its neighbours say {expected:.4e}{more}: a lost decimal point, a spike, or a logger's code for \
                     an error or an overload",
                    sample + 1
                )
            }
            Self::Clipping { level, unit, fraction } => format!(
                "{:.1} % of the samples are held at {level:.4e} {unit}: the channel is clipped",
                100.0 * fraction
            ),
            Self::DropOuts { count, first, zero } => format!(
                "{count} drop-out{} from sample {} on: the same {} again and again",
                if *count == 1 { "" } else { "s" },
                first + 1,
                if *zero { "zero" } else { "value" }
            ),
            Self::Quantisation { fraction } => format!(
                "values are multiples of a step of {:.1} % of the channel's standard deviation: too coarse a range or too few digits",
                100.0 * fraction
            ),
            Self::MainsHum { frequency, amplitude, unit } => {
                format!("hum of the mains: {amplitude:.2e} {unit} at {frequency:.1} Hz")
            }
            Self::TimeGap { sample, length, missing, count } => {
                let more = if *count > 1 { format!(", the first of {count} such jumps") } else { String::new() };
                let are = if *missing == 1 { "sample is" } else { "samples are" };
                format!("time jumps by {length:.3e} s after sample {}{more}: about {missing} {are} missing", sample + 1)
            }
            Self::RoundedTime { digit, step } => format!(
                "stamps are rounded to {digit:.0e} s, {:.0} % of the step of {step:.4e} s, and look uneven: export the time stamps with \
                 more digits",
                100.0 * digit / step
            ),
            Self::MovingAtStart { fraction } => format!(
                "the record is said to begin at rest, but begins at {:.0} % of its largest value: use regime = \
                 \"unknown-initial-state\", or start it earlier",
                100.0 * fraction
            ),
            Self::MovingUndriven { fraction } => format!(
                "the record is said to begin at rest, but {:.0} % of its first period are no response to the excitation: use regime = \
                 \"unknown-initial-state\", or start it earlier; a reversed sign or a delay between both would look the same",
                100.0 * fraction
            ),
            Self::CopyOf { other } => format!("it has the values of `{other}`: one of the two was not measured"),
            Self::GivenTwice { other } => {
                format!("it has the values of {other}: a record given twice would test a fit with its own data")
            }
            Self::ReversedSign { .. } => "it feeds energy in over the record: its sign is reversed (multiply the column by −1), or that \
                                          of the motion is"
                .to_owned(),
            Self::Scale { what, measured, modelled, unit, cause } => {
                format!("the {what} is {measured:.2e} {unit} in the data and {modelled:.2e} {unit} in the model: {cause}")
            }
            Self::BeyondTable { moved, range } => format!(
                "the contact moves by ± {:.3} µm, the table of the model's measured law ends at {:.3} µm: what is foretold beyond is the \
                 force at its end, which nobody has measured",
                1e6 * moved,
                1e6 * range
            ),
            // A ratio has no unit to be told.
            Self::Implausible { value, unit: "1", cause } => format!("{value} is implausible: {cause}"),
            Self::Implausible { value, unit, cause } => format!("{value:e} {unit} is implausible: {cause}"),
        }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(record) = &self.record {
            write!(formatter, "{record}: ")?;
        }
        if let Some(channel) = &self.channel {
            write!(formatter, "`{channel}`: ")?;
        }
        formatter.write_str(&self.fault.words())
    }
}

/// The natural frequencies (Hz) of a structure whose contact is free, and of the one whose contact sticks; `None` for a contact
/// alone, and for a model that makes no system.
///
/// ```
/// # let text = "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{ name = \"m1\", mass = 1.0 }]\n\
/// #     spring = [{ between = [\"ground\", \"m1\"], stiffness = 39.47841760435743 }]";
/// // One kilogram on 4 π² N/m.
/// let [free, _] = stickslip::fit::checks::natural_frequencies(&stickslip::model::Model::parse(text)?).unwrap();
/// assert!((free[0] - 1.0).abs() < 1e-9);
/// # Ok::<(), stickslip::model::ModelError>(())
/// ```
pub fn natural_frequencies(model: &Model) -> Option<[Vec<f64>; 2]> {
    Some(dynamic::Linear::of(model)?.natural_frequencies())
}

/// What is wrong with `dataset`, and with `model` beside it: the model first, then record by record.
///
/// ```
/// use stickslip::data::{Channel, Dataset, Record, Regime};
/// use stickslip::fit::checks::{Fault, check};
/// use stickslip::model::Model;
///
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "contact"
///     contact = { law = "jenkins", tangential_stiffness = 1e6, friction_coefficient = 0.5, normal_load = 20.0 }
///     "#,
/// )?;
/// // A loop whose load cell shows the other sign.
/// let of = |f: &dyn Fn(f64) -> f64| (0..200).map(|i| f(0.1 * f64::from(i))).collect::<Vec<f64>>();
/// let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
/// let channels = vec![
///     channel("time", "s", of(&|t| t)),
///     channel("displacement", "m", of(&|t| 2e-5 * t.sin())),
///     channel("force", "N", of(&|t| -10.0 * (t + 0.5).sin())),
/// ];
/// let regime = Regime::UnknownInitialState;
/// let records = vec![Record { name: "loop.csv".into(), regime, use_for: None, channels }];
/// let found = check(&model, &Dataset { title: None, records });
/// assert!(matches!(found[0].fault, Fault::ReversedSign { .. }) && found.len() == 1);
/// assert!(found[0].to_string().starts_with("loop.csv: `force`: it feeds energy in"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn check(model: &Model, dataset: &Dataset) -> Vec<Finding> {
    let mut found = model::of(model);
    let records = &dataset.records;
    let mut told: Vec<Vec<Finding>> =
        (0..records.len()).map(|place| alone(&records[place], &records[..place])).collect();
    let linear = dynamic::Linear::of(model);
    // A model off by powers of ten is told once, and its responses are off, too.
    if let Some(linear) = &linear {
        dynamic::of_frequencies(linear, records, &told, &mut found);
    }
    let linear = linear.filter(|_| found.is_empty());
    for (record, told) in records.iter().zip(&mut told) {
        if !record.regime.is_table() {
            beside(model, linear.as_ref(), record, told);
        }
    }
    found.extend(told.into_iter().flatten());
    found
}

/// What is wrong with a record whatever the model is.
fn alone(record: &Record, before: &[Record]) -> Vec<Finding> {
    let mut found = Vec::new();
    copies::of(record, before, &mut found);
    if !record.regime.is_table() {
        time::of(record, &mut found);
        samples::of(record, &mut found);
        hum::of(record, &mut found);
    }
    found
}

/// What is wrong with a record in time and its model, beside what was `found` in the record alone.
fn beside(model: &Model, linear: Option<&dynamic::Linear>, record: &Record, found: &mut Vec<Finding>) {
    sign::of(model, record, found);
    rest::of(model, linear, record, found);
    scale::of_contact(model, record, found);
    table::of(model, record, found);
    linear.iter().for_each(|linear| dynamic::of_response(linear, record, found));
}

/// Whether nothing was `found` in the channel that would make it say something wrong of the model.
fn is_sound(found: &[Finding], channel: &Channel) -> bool {
    let spoils = |fault: &Fault| {
        matches!(fault, Fault::Outlier { .. } | Fault::DropOuts { .. } | Fault::CopyOf { .. })
    };
    !found.iter().any(|one| one.channel.as_deref() == Some(&channel.name) && spoils(&one.fault))
}

/// A finding in a channel of a record.
fn finding(record: &Record, channel: &str, fault: Fault) -> Finding {
    Finding { record: Some(record.name.clone()), channel: Some(channel.to_owned()), fault }
}

/// The magnitude below which a fraction of `values` lies; 0 of none.
fn quantile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(((sorted.len().saturating_sub(1)) as f64 * fraction).round() as usize).copied().unwrap_or(0.0)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}
