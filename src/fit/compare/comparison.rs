//! The result of comparing models with measurements, as data for tables, JSON and reports.

use super::nested::Nested;
use crate::data::Record;
use crate::fit::checks::Finding;
use crate::fit::ring_down::RingDown;

/// Values of all tables together up to which the gain of a step is given with its uncertainty.
const FEW: usize = 40;

/// One or more models (or the same before and after a refit) against one dataset.
///
/// ```
/// use stickslip::fit::compare::{Comparison, evaluate};
/// use stickslip::model::Model;
/// # let model = Model::parse("schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
/// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.1\nnormal_load = 10.0")?;
/// # let dataset = stickslip::data::Dataset { title: None, records: vec![] };
/// let stages = vec![evaluate("as given", &model, &dataset)];
/// let records = dataset.records;
/// let comparison = Comparison { title: "Loops".into(), records, ring_downs: vec![], findings: vec![], notes: vec![], stages };
/// assert_eq!(comparison.stages[0].name, "as given");
/// # Ok::<(), stickslip::model::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// What was compared, for a heading.
    pub title: String,
    /// The measurements, in SI.
    pub records: Vec<Record>,
    /// Free decays whose tables are among the records, with their levels.
    pub ring_downs: Vec<RingDown>,
    /// What is wrong with the measurements, or with the first model's units ([`check`](crate::fit::checks::check)).
    pub findings: Vec<Finding>,
    /// What else a reader must know of how it was made: columns that were not used, what was guessed.
    pub notes: Vec<String>,
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
    /// What a reader must know of the fit: that it was interrupted, that a parameter changes nothing.
    pub notes: Vec<String>,
}

/// What a fitted stage gains over a fitted one before it that has fewer free parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct StepGain {
    /// Index of the stage before, and of this one.
    pub stages: [usize; 2],
    /// Free parameters of the two.
    pub parameters: [usize; 2],
    /// F of the fall of the squares; `None` where no degree of freedom is left.
    pub ratio: Option<f64>,
    /// Probability of an F at least as large by chance, for one or two parameters more.
    pub p_value: Option<f64>,
    /// Change of AICc: negative speaks for the step. `None` where the values are too few for it.
    pub criterion: Option<f64>,
    /// The same in words.
    pub words: String,
}

impl Comparison {
    /// What each step gains, with its significance, where the records are tables of few points: the scatter of their
    /// values is not known, and one more parameter always lowers the error.
    pub fn steps(&self) -> Vec<StepGain> {
        let tables = self.records.iter().all(|record| record.regime.is_table());
        let fitted: Vec<(usize, usize, f64, usize)> = (self.stages.iter().enumerate())
            .filter_map(|(index, stage)| {
                let free = stage.parameters.iter().filter(|parameter| parameter.fitted.is_some()).count();
                let (squares, values) = stage.squares()?;
                (free > 0).then_some((index, free, squares, values))
            })
            .collect();
        let few = |values: usize| tables && (1..=FEW).contains(&values);
        fitted
            .windows(2)
            .filter(|pair| pair[1].1 > pair[0].1 && pair[0].3 == pair[1].3 && few(pair[1].3))
            .map(|pair| {
                let (before, after) = (pair[0], pair[1]);
                let parameters = [before.1, after.1];
                let nested = Nested { values: after.3, parameters, squares: [before.2, after.2] };
                StepGain {
                    stages: [before.0, after.0],
                    parameters,
                    ratio: nested.ratio(),
                    p_value: nested.p_value(),
                    criterion: nested.criterion(),
                    words: nested.words(),
                }
            })
            .collect()
    }
}

impl Stage {
    /// Sum of the normalised squared residuals of all records, and the number of values; `None` where a record has no
    /// prediction.
    fn squares(&self) -> Option<(f64, usize)> {
        let mut sum = (0.0, 0);
        for record in &self.records {
            if record.failure.is_some() {
                return None;
            }
            for channel in &record.channels {
                let count = channel.predicted.len();
                sum = (sum.0 + channel.error.powi(2) * count as f64, sum.1 + count);
            }
        }
        Some(sum)
    }
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
    /// How it was fitted; `None` where it was not.
    pub fitted: Option<Fitted>,
}

/// What a fit says of a parameter.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fitted {
    /// Value before the fit, in the parameter's unit; `None` for one that is new in the model.
    pub from: Option<f64>,
    /// Ends of its 95 % interval, in the parameter's unit; `None` where the data do not determine it.
    pub interval: Option<[f64; 2]>,
    /// Whether it ended at a bound: its interval is unknown, and the data may ask for more.
    pub at_bound: bool,
    /// Whether no fitted record depends on it: it keeps its value.
    pub unseen: bool,
    /// Paths of the parameters whose estimates are correlated with this one by [`Fitted::TOLD`] or more in size, and the
    /// correlation (1), the largest first: these data determine a combination of them better than each.
    pub correlated: Vec<(String, f64)>,
}

impl Fitted {
    /// Correlations of this size and larger are told (1).
    pub const TOLD: f64 = 0.9;

    /// From a fitted value that was `from` before; nothing else is known.
    pub fn from(from: f64) -> Self {
        Self { from: Some(from), ..Self::default() }
    }

    /// The correlations to be told of number `index` among `paths`, where `row` holds its correlation with each.
    pub(crate) fn told(index: usize, paths: &[&str], row: &[f64]) -> Vec<(String, f64)> {
        let others = paths.iter().zip(row).enumerate().filter(|(other, _)| *other != index);
        let mut told: Vec<(String, f64)> = others
            .filter(|(_, (_, correlation))| correlation.abs() >= Self::TOLD)
            .map(|(_, (path, correlation))| ((*path).to_owned(), *correlation))
            .collect();
        told.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        told
    }
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

/// A record that a fit or a diagnosis left out because it could not be solved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// Its name in the dataset.
    pub record: String,
    /// What the solver said.
    pub reason: String,
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
