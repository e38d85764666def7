//! Effects of the catalogue: in model files, in beams, oscillators and instances.

#[path = "../common/mod.rs"]
mod common;

mod beam;
mod catalogue;
mod instance;
mod model;
mod oscillator;
mod pin_rig;
