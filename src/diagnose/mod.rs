//! Which effect is missing: a model and measurements come in, a [`Diagnosis`] goes out.
//!
//! `engine` goes through it from beginning to end: `measurements` lays the records out and splits them, `candidates` lists
//! what may be missing, `evidence` weighs sets of that under what is taken for granted (`assumptions`), and `verdict`
//! makes the answer of the probabilities and explains it with the help of `features`.

mod assumptions;
mod candidates;
mod diagnosis;
mod engine;
mod error;
mod evidence;
mod features;
mod measurements;
mod solvable;
mod stage;
mod verdict;

pub use assumptions::{Assumptions, NotAssumed};
pub use diagnosis::{
    Agreement, Candidate, Confounding, Cost, Detectable, Diagnosis, Errors, Estimate, Evidence, Group, Noise,
    NoiseSource, Step, Untried, Verdict,
};
pub use engine::{Added, DiagnoseHook, DiagnoseOptions, DiagnoseWatch, add, diagnose};
pub use error::DiagnoseError;
pub use measurements::noise::noise_of;
pub use verdict::confound::ALIKE;

pub use crate::fit::compare::{
    ChannelResult, Comparison, Fitted, Parameter, RecordResult, Refit, RefitError, Skipped, Stage, StepGain,
    Watch, evaluate, refit,
};
pub use crate::fit::predict::unused_columns;
