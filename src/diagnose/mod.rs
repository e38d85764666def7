//! Model against measurement: predict every record, score the prediction, refit, compare again.

mod beam_record;
mod bench;
mod blocks;
mod candidates;
mod compare;
mod comparison;
mod contact_record;
mod diagnosis;
mod magnitudes;
mod motion;
mod noise;
mod periods;
mod predict;
mod prehistory;
mod score;
mod sensors;
mod shown;
mod select;
mod simulation;
mod split;
mod trial;

pub use compare::{Refit, RefitError, Watch, evaluate, refit};
pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage};
pub use diagnosis::{
    Candidate, Confounding, Cost, Detectable, Diagnosis, Errors, Estimate, Evidence, Group, Noise,
    NoiseSource, Step, Untried, Verdict,
};
pub use predict::{NO_OSCILLATOR, unused_columns};
