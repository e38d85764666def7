//! Co-simulation masters.

#[path = "../common/mod.rs"]
mod common;

mod beam;
mod orders;
mod run;
mod system;
