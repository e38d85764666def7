//! Friction contacts for structural dynamics: contact laws, a modal beam, harmonic balance,
//! identification and the FMI-neutral instances behind the exported FMUs.
//!
//! The library does no input or output and holds no global state. Everything inside is SI
//! (m, N, kg, s, rad); frequencies are in rad/s inside and in Hz where a user sees them.
//! `ARCHITECTURE.md` is the map.
//!
//! Without the default feature `analysis` it is what an FMU needs: models, and their steps in time.

// Some of what models and integrators can do serves the analysis alone.
#![cfg_attr(not(feature = "analysis"), allow(dead_code, unused_imports))]

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
pub mod model;
#[cfg(feature = "analysis")]
pub(crate) mod numeric;
pub mod system;
pub mod time;
pub mod vocabulary;
