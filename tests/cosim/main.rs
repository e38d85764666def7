//! Co-simulation masters.

#[path = "../common/mod.rs"]
mod common;

mod beam;
mod curves;
mod faults;
mod loops;
mod orders;
mod pin_rig;
mod run;
mod slip_slap;
mod system;
mod watched;
