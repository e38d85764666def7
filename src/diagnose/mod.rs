//! Model against measurement: predict every record, score the prediction, refit, compare again.

mod beam_record;
mod compare;
mod comparison;
mod contact_record;
mod predict;
mod score;

pub use compare::{Refit, RefitError, Watch, evaluate, refit};
pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage};
pub use predict::{NO_OSCILLATOR, unused_columns};
