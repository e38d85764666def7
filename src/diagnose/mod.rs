//! Which effect is missing: a model and measurements come in, a [`Diagnosis`] goes out.
//!
//! `engine` goes through it from beginning to end: `measurements` lays the records out with their weights and splits
//! them, `refit` fits models jointly to them, `search` adds effects and drops them again by what `residual` says of two
//! models' residuals, `verdict` judges and explains with the help of `features`. Tables of few points go their own way in
//! `few_points`.

mod diagnosis;
mod engine;
mod features;
mod few_points;
mod measurements;
mod refit;
mod residual;
mod search;
mod verdict;

pub use diagnosis::{
    Candidate, Confounding, Cost, Detectable, Diagnosis, Errors, Estimate, Evidence, Group, Noise,
    NoiseSource, Step, Untried, Verdict,
};
pub use engine::{Added, DiagnoseError, DiagnoseHook, DiagnoseOptions, DiagnoseWatch, add, diagnose};
pub use measurements::noise::noise_of;

pub use crate::fit::compare::{
    ChannelResult, Comparison, Parameter, RecordResult, Refit, RefitError, Stage, StepGain, Watch, evaluate,
    refit,
};
pub use crate::fit::predict::unused_columns;
