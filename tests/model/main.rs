//! Model files.

#[path = "../common/mod.rs"]
mod common;

mod file;
mod normal;
mod oscillator;
mod parameters;
mod pin_rig;
