//! Model against measurement.

mod comparison;

pub use comparison::{ChannelResult, Comparison, Parameter, RecordResult, Stage};
