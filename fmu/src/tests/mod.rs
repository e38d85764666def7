//! The exported functions, called as an importer calls them.

mod call_table;
mod derivatives;
mod fixture;
mod fmi3;
mod fuzz;
mod heap;
mod lifecycle;
pub mod model_exchange;
mod panics;
pub mod saved_states;
mod values;
mod warnings;
