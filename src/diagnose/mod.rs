//! Model against measurement: predict every record, score the prediction, refit, compare again.

mod beginnings;
mod bench;
mod blocks;
mod candidates;
mod confound;
mod detectable;
mod diagnosis;
mod doubt;
mod engine;
mod explain;
mod features;
mod few_points;
mod findings;
mod inputs;
mod loops;
mod magnitudes;
mod maps;
mod noise;
mod remainder;
mod resonance;
mod select;
mod sensitivity;
mod split;
mod thinned;
mod tone;
mod trial;
mod verdict;

pub use diagnosis::{
    Candidate, Confounding, Cost, Detectable, Diagnosis, Errors, Estimate, Evidence, Group, Noise,
    NoiseSource, Step, Untried, Verdict,
};
pub use engine::{Added, DiagnoseError, DiagnoseHook, DiagnoseOptions, DiagnoseWatch, add, diagnose};
pub use noise::noise_of;

pub use crate::fit::compare::{
    ChannelResult, Comparison, Parameter, RecordResult, Refit, RefitError, Stage, StepGain, Watch, evaluate,
    refit,
};
pub use crate::fit::predict::unused_columns;
