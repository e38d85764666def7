//! The result of a diagnosis, as data for tables, JSON and reports.

use crate::data::Use;
use crate::fit::compare::{Comparison, Skipped};
use crate::fit::residual::Appearance;
use crate::model::Model;

/// What was found, what it rests on, and what to do next.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// The answer.
    pub verdict: Verdict,
    /// Its probability, given that one of the hypotheses weighed is true; NaN where none were, or where the verdict rests on
    /// something else.
    pub probability: f64,
    /// Whether the size of the noise is known: stated, or seen in repeats. Where it is not, an effect that is found is likely
    /// and no more.
    pub noise_is_known: bool,
    /// Why, in sentences for an engineer, the most important first.
    pub reasons: Vec<String>,
    /// Ids of the effects found, in the order they were added. Empty unless the verdict is
    /// [`Verdict::EffectFound`]; the members of a group are in [`Diagnosis::groups`] instead.
    pub effects: Vec<&'static str>,
    /// The contact law that shows what was found in the place of the model's: `valanis`; `None` where effects do.
    pub law: Option<&'static str>,
    /// Ids of effects that lower the error without explaining the data: they only absorb error and are no physics.
    pub surrogates: Vec<&'static str>,
    /// Sets of effects that these data cannot distinguish.
    pub groups: Vec<Group>,
    /// The errors before and after.
    pub error: Errors,
    /// Mean square of the residual over that of the noise on the test records, if the noise is known.
    pub chi_square: Option<f64>,
    /// The steps of the selection, in order: what each added effect gained.
    pub steps: Vec<Step>,
    /// Every candidate of the first round, best first. The parameters of a candidate that was kept are those of
    /// [`Diagnosis::model`]: fitted with all other effects found, to the training and validation records.
    pub candidates: Vec<Candidate>,
    /// Every fitted parameter of [`Diagnosis::model`], by its path, with its interval.
    pub parameters: Vec<Estimate>,
    /// The rounds after the first: candidates beside the effects already added, best first.
    pub rounds: Vec<Vec<Candidate>>,
    /// Effects of the catalogue that were not tried, and why.
    pub untried: Vec<Untried>,
    /// Correlation of pairs of candidates' sensitivities, after projection off those of the base parameters.
    pub confounding: Vec<Confounding>,
    /// The detection limits: the smallest size of each effect that would have been found.
    pub detectable: Vec<Detectable>,
    /// What was seen of the effects found, and what else could cause it.
    pub evidence: Vec<Evidence>,
    /// What the residual of the last stage looks like over all records, or of the refitted model without effects where nothing
    /// explains it: the shape of what is missing, where something is, and hints. Told, and never a reason of the verdict.
    pub residual: Appearance,
    /// The experiment that would decide between the explanations that remain.
    pub next_experiment: Option<String>,
    /// What each record was used for, in the order of the dataset.
    pub split: Vec<Use>,
    /// Standard deviations of the noise, per record and compared channel.
    pub noise: Vec<Noise>,
    /// Records of the dataset that could not be solved: everything else here is of the others.
    pub skipped: Vec<Skipped>,
    /// Baseline, refitted, and one stage per added effect, with all predictions.
    pub comparison: Comparison,
    /// The model of the last stage.
    pub model: Model,
    /// What fits of that model from other starts say of its parameters.
    pub agreement: Agreement,
    /// Refits made, and simulations of a whole dataset in them.
    pub cost: Cost,
}

/// The answer of a diagnosis.
///
/// ```
/// use stickslip::diagnose::Verdict;
/// assert_eq!(Verdict::EffectFound.id(), "effect-found");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The error of the refitted model is noise.
    NothingMissing,
    /// With these effects the error is noise, or nearly.
    EffectFound,
    /// Several effects fit equally well, and these data cannot distinguish them.
    NotDistinguishable,
    /// The model does not explain the data, and no effect of the catalogue does.
    Unexplained,
    /// There are too few data for an answer.
    InsufficientData,
}

impl Verdict {
    /// As in JSON.
    pub fn id(self) -> &'static str {
        match self {
            Self::NothingMissing => "nothing-missing",
            Self::EffectFound => "effect-found",
            Self::NotDistinguishable => "not-distinguishable",
            Self::Unexplained => "unexplained",
            Self::InsufficientData => "insufficient-data",
        }
    }
}

impl Diagnosis {
    /// Whether nothing explains the data and `most` effects together were tried where there are more: more may explain them.
    ///
    /// ```
    /// use stickslip::diagnose::{Diagnosis, DiagnoseOptions};
    /// fn go_on(found: &Diagnosis, options: &DiagnoseOptions) -> Option<usize> {
    ///     found.may_lack_more_than(options.max_effects).then_some(options.max_effects + 1)
    /// }
    /// ```
    pub fn may_lack_more_than(&self, most: usize) -> bool {
        let mut tried: Vec<_> = self.candidates.iter().map(|one| (&one.effects, &one.location)).collect();
        tried.sort_unstable();
        tried.dedup();
        let reached = most > 0 && self.surrogates.len() >= most;
        self.verdict == Verdict::Unexplained && reached && tried.len() > most
    }

    /// The exit code of `stickslip diagnose`.
    pub fn exit_code(&self) -> u8 {
        match self.verdict {
            Verdict::NothingMissing => 0,
            Verdict::EffectFound if self.noise_is_known => 10,
            Verdict::NotDistinguishable => 11,
            Verdict::Unexplained => 12,
            Verdict::InsufficientData => 13,
            Verdict::EffectFound => 14,
        }
    }
}

/// Effects that these data cannot distinguish.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Their ids, best first.
    pub effects: Vec<&'static str>,
    /// Why they cannot be distinguished.
    pub reason: String,
    /// The experiment that would distinguish them.
    pub experiment: String,
}

/// Root-mean-square errors over all measured channels, each normalised by its own standard deviation in the
/// record (1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// The model as given, all records.
    pub baseline: f64,
    /// Refitted, nothing added, all records.
    pub refitted: f64,
    /// With the effects added, all records.
    pub last: f64,
    /// With the effects added, the test records; NaN when there are none.
    pub test: f64,
    /// Refitted without effects, the test records.
    pub test_refitted: f64,
    /// The error that noise alone would cause, all records; `None` where the noise is unknown.
    pub noise_floor: Option<f64>,
    /// The same over the test records.
    pub test_noise_floor: Option<f64>,
}

/// A step of the selection.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Ids of what was added: one effect, or a pair at once.
    pub added: Vec<&'static str>,
    /// Error after it on the training records (1).
    pub error: f64,
    /// Its gain in standard deviations: √(2 × the gain of log evidence), below zero where that falls (1).
    pub gain_z: f64,
    /// Fraction of the squared error removed (1).
    pub gain_fraction: f64,
}

/// A candidate of one round, refitted jointly with the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its id; for a pair both.
    pub effects: Vec<&'static str>,
    /// Its place, if it has one.
    pub location: Option<String>,
    /// The contact law that shows it in the place of the model's; `None` for the effect's own.
    pub law: Option<&'static str>,
    /// Error on the training records (1); of the model without it where it promises too little to be fitted.
    pub error: f64,
    /// Its gain in standard deviations: √(2 × the gain of log evidence), below zero where that falls (1).
    pub gain_z: f64,
    /// Fraction of the squared error removed (1).
    pub gain_fraction: f64,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
    /// Simulations of the fitted records spent on its refit.
    pub evaluations: usize,
}

/// A fitted number with its 95 % interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// `half_gap`; in a candidate the name, elsewhere the path.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// Lower end; `None` where the data do not determine it.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// SI unit, `1` for a plain number.
    pub unit: &'static str,
}

/// An effect that was not tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Untried {
    /// Its id.
    pub effect: &'static str,
    /// Why.
    pub reason: String,
}

/// How similar two candidates are in these data.
#[derive(Debug, Clone, PartialEq)]
pub struct Confounding {
    /// Their ids.
    pub effects: [&'static str; 2],
    /// Correlation of their sensitivities, in [−1, 1].
    pub correlation: f64,
}

/// A detection limit: the smallest size of an effect that would have been found.
#[derive(Debug, Clone, PartialEq)]
pub struct Detectable {
    /// The effect's id.
    pub effect: &'static str,
    /// Name of its first parameter.
    pub parameter: &'static str,
    /// Size in `unit`; `None` where the effect is not identifiable from these data.
    pub value: Option<f64>,
    /// SI unit.
    pub unit: &'static str,
    /// Posterior probability, if the effect is there at all, that it moves a channel by more than a hundredth of its
    /// variation; `None` where the effect is not identifiable.
    pub relevant: Option<f64>,
}

/// Evidence for an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// The effect's id.
    pub effect: &'static str,
    /// The feature in the data.
    pub seen: String,
    /// What else could cause the same.
    pub otherwise: Option<String>,
}

/// The noise of a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// Index of the record in the dataset.
    pub record: usize,
    /// Name of the channel.
    pub channel: String,
    /// Standard deviation in the channel's unit; `None` where it is unknown.
    pub deviation: Option<f64>,
    /// Standard error of its logarithm; 0 where it is stated or unknown.
    pub log_error: f64,
    /// How it is known.
    pub source: NoiseSource,
}

/// How the noise of a channel is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseSource {
    /// Stated in the dataset.
    Stated,
    /// From the difference of repeated periods.
    Periods,
    /// From another record of the same motion.
    Repeats,
    /// Taken from other records or channels of the dataset in which it could be measured.
    Carried,
    /// Unknown.
    Unknown,
}

/// How many fits of the model told, from other starts, ended at the same predictions: a minimum is the best one as far as
/// others were looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Agreement {
    /// Fits from other starts.
    pub starts: usize,
    /// Those of them that ended there.
    pub agreeing: usize,
}

/// What the diagnosis cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cost {
    /// Refits.
    pub refits: usize,
    /// Simulations of one record.
    pub simulations: usize,
    /// Samples of all records.
    pub samples: usize,
    /// Those that effects were weighed by: fewer where records are long. The numbers found are those of all.
    pub fitted_samples: usize,
}
