//! Simulated measurements with a hidden effect, and the score of a diagnosis of them.
//!
//! The generator shares nothing with the models it tests: it has its own contact (many sliders, clamped step by
//! step), its own beam (finite elements), and its own integrators (short explicit steps; a steady state is
//! waited for). A mistake in the models is therefore not mirrored in the data.
//!
//! Cases are sealed: a case is its name, all its numbers follow from it, and its files are made on demand.

pub mod cases;
pub mod motion;
pub mod physics;
pub mod records;
pub mod rigs;
pub mod scoring;
