//! Model against measurement: predict every record, score the prediction, refit, compare again.

mod beam_record;

mod comparison;
mod contact_record;
mod predict;
mod score;

pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage};
