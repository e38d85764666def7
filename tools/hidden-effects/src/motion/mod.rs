//! What the test machine does with a bare contact: path.rs curves over time, drive.rs the records of an experiment,
//! moving.rs those that are not stationary, ramped.rs those that
//! are ramped up and held.

pub mod drive;
pub mod moving;
pub mod path;
pub mod ramped;
