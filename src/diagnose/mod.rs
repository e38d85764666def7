//! Model against measurement: predict every record, score the prediction, refit, compare again.

mod beam_record;
mod compare;
mod comparison;
mod contact_record;
mod diagnosis;
mod motion;
mod periods;
mod predict;
mod prehistory;
mod score;
mod sensors;
mod shown;
mod simulation;

pub use compare::{Refit, RefitError, Watch, evaluate, refit};
pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage};
pub use diagnosis::{
    Candidate, Confounding, Cost, Detectable, Diagnosis, Errors, Estimate, Evidence, Group, Noise, NoiseSource, Step,
    Untried, Verdict,
};
pub use predict::{NO_OSCILLATOR, unused_columns};
