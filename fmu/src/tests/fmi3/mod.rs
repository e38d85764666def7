//! The functions of FMI 3.0, called as an importer calls them.

mod call_table;
mod chance;
mod fixture;
mod intermediate;
mod lifecycle;
mod values;
