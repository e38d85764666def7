//! Model against measurement: predict every record, score the prediction, refit, compare again.

mod beam_record;
mod beam_steady;
#[cfg(test)]
mod beam_tests;
mod compare;
mod comparison;
mod contact_record;
mod diagnosis;
mod predict;
mod score;
mod simulation;

pub use compare::{Refit, RefitError, Watch, evaluate, refit};
pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage};
pub use diagnosis::{
    Candidate, Confounding, Cost, Detectable, Diagnosis, Errors, Estimate, Evidence, Group, Noise,
    NoiseSource, Step, Untried, Verdict,
};
pub use predict::{NO_OSCILLATOR, unused_columns};
