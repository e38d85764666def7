//! Friction in structural dynamics: predict what a structure with joints that stick and slip does, compare it with
//! measurements, and find the physical effect that a model lacks.
//!
//! ```
//! use stickslip::prelude::*;
//!
//! // A slider of 5 N/µm that slips at 80 N, pulled by 50 µm and back.
//! let law = Jenkins::new(5e6, 0.5)?;
//! let mut state = vec![0.0; law.state_len()];
//! let mut next = state.clone();
//! law.set_state(0.0, 160.0, 0.0, &mut state);
//! let mut forces = Vec::new();
//! for displacement in [10e-6, 50e-6, 40e-6, 0.0] {
//!     let inputs = Inputs { displacement, velocity: 0.0, normal_load: 160.0 };
//!     forces.push(law.step(&state, inputs, &mut next).force.round());
//!     std::mem::swap(&mut state, &mut next);
//! }
//! // It sticks, slips, sticks on the way back, slips the other way.
//! assert_eq!(forces, [50.0, 80.0, 30.0, -80.0]);
//! # Ok::<(), LawError>(())
//! ```
//!
//! # Where to start
//!
//! | you want | start at |
//! |---|---|
//! | what most programs need | [`prelude`] |
//! | the force of a contact under a given motion, or a law of your own | [`contact`] |
//! | a model file (`model.toml`) | [`model::Model::parse`] |
//! | the response to a harmonic force over frequency | [`harmonic::frequency_response`] |
//! | motion in time | [`time`] |
//! | a model against measured records | [`fit::predict`], [`fit::compare`] |
//! | the effect that a model lacks | [`diagnose::diagnose`]; the catalogue is [`effects`] |
//! | records as a laboratory would take them, from a model | [`rig::test_on`] |
//! | FMUs, and systems of them | [`fmi`], [`cosim`] |
//!
//! # Conventions
//!
//! A contact force is *restoring*: positive when it resists positive displacement. Everything inside is SI (m, N, kg, s,
//! rad); frequencies are in rad/s inside and in Hz where a user sees them. The library does no input or output and
//! holds no global state; files are read by `stickslip-readers`. `ARCHITECTURE.md` is the map of the code, `docs/` the
//! guide. Without the default feature `analysis` the library is what an FMU needs: models, and their steps in time.

pub mod contact;
#[cfg(feature = "analysis")]
pub mod cosim;
pub mod data;
#[cfg(feature = "analysis")]
pub mod diagnose;
pub mod document;
pub mod effects;
#[cfg(feature = "analysis")]
pub mod fit;
pub mod fmi;
#[cfg(feature = "analysis")]
pub mod harmonic;
#[cfg(feature = "analysis")]
pub mod identify;
pub mod model;
#[cfg(feature = "analysis")]
pub(crate) mod numeric;
pub mod prelude;
#[cfg(feature = "analysis")]
pub mod rig;
pub mod system;
pub mod time;
pub mod vocabulary;
