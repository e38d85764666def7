//! Our FMUs and third-party FMUs, as a host sees them.

#[cfg(target_os = "linux")]
#[path = "../support/kinds.rs"]
mod kinds;
#[path = "../support/mod.rs"]
mod support;
#[cfg(target_os = "linux")]
#[path = "../support/unruly.rs"]
mod unruly;

mod fuzz;
mod import;
mod isolation;
mod kinds_of_fmi3;
mod library;
