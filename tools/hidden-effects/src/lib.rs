//! Simulated measurements with a hidden effect, and the score of a diagnosis of them.
//!
//! The generator shares nothing with the models it tests: it has its own contact (many sliders, clamped step by
//! step), its own beam (finite elements), and its own integrators (short explicit steps; a steady state is
//! waited for). A mistake in the models is therefore not mirrored in the data.
//!
//! Cases are sealed: a case is its name, all its numbers follow from it, and its files are made on demand.

pub mod agreement;
pub mod beam;
pub mod case;
pub mod effect;
pub mod files;
pub mod finite_elements;
pub mod friction;
pub mod joint_effects;
pub mod motion;
pub mod moving;
pub mod oscillator;
pub mod path;
pub mod prescribed;
pub mod random;
pub mod record;
pub mod rig;
pub mod run;
pub mod score;
pub mod table;
pub mod truth;
pub mod visibility;
pub mod wilson;
