//! Model files.

#[path = "../common/mod.rs"]
mod common;

mod file;
mod oscillator;
mod parameters;
