//! The experiments, one file per kind of model: what they are made of, what is hidden in them, how they respond.
//!
//! rig.rs: what all have in common; setting.rs: what is unlike the usual; effect.rs: what is hidden, with its parameters;
//! joint_effects.rs: what can be hidden in any contact.

pub mod beam;
pub mod effect;
pub mod joint_effects;
pub mod oscillator;
pub mod prescribed;
pub mod rig;
pub mod setting;
