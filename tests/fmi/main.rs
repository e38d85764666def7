//! The library's models as co-simulation slaves.
//! The Python files beside run the exported FMUs under independent importers.

#[path = "../common/mod.rs"]
mod common;

mod contact;
mod continuous;
mod dependencies;
mod derivatives;
mod energy;
mod input_derivatives;
mod instance;
mod orders;
mod oscillator;
mod pin_rig;
