//! Time integration of beams and oscillators.

#[path = "../common/mod.rs"]
mod common;

mod equal;
mod errors;
mod frequency;
mod friction;
mod linear;
mod oscillator;
mod shooting;
