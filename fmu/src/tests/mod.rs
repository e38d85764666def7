//! The exported functions, called as an importer calls them.

mod call_table;
mod derivatives;
mod fixture;
mod lifecycle;
mod model_exchange;
mod panics;
mod saved_states;
mod values;
mod warnings;
