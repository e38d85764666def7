//! The functions of FMI 3.0, called as an importer calls them.

mod call_table;
pub mod chance;
pub mod fixture;
mod intermediate;
mod lifecycle;
mod values;
