//! Our FMUs and third-party FMUs, as a host sees them.

#[path = "../support/mod.rs"]
mod support;
#[cfg(target_os = "linux")]
#[path = "../support/unruly.rs"]
mod unruly;

mod import;
mod isolation;
mod library;
