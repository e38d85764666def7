//! Model against measurement: predict every record, score the prediction, refit, compare again.

mod beam_about;
mod beam_record;
mod beam_steady;
#[cfg(test)]
mod beam_tests;
mod beginnings;
mod bench;
mod blocks;
mod candidates;
mod compare;
mod comparison;
mod confound;
mod contact_record;
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
mod motion;
mod nested;
mod noise;
mod oscillator_record;
mod periods;
mod predict;
mod prehistory;
mod remainder;
mod resonance;
mod score;
mod select;
mod sensitivity;
mod sensors;
mod shown;
mod simulation;
mod split;
mod thinned;
mod tone;
mod trial;
mod unseen;
mod verdict;

pub use compare::{Refit, RefitError, Watch, evaluate, refit};
pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage, StepGain};
pub use diagnosis::{
    Candidate, Confounding, Cost, Detectable, Diagnosis, Errors, Estimate, Evidence, Group, Noise,
    NoiseSource, Step, Untried, Verdict,
};
pub use engine::{Added, DiagnoseError, DiagnoseHook, DiagnoseOptions, DiagnoseWatch, add, diagnose};
pub use noise::noise_of;
pub use predict::unused_columns;
