//! Friction contacts for structural dynamics: contact laws, a modal beam, harmonic balance,
//! identification and the FMI-neutral instances behind the exported FMUs.
//!
//! The library does no input or output and holds no global state. Everything inside is SI
//! (m, N, kg, s, rad); frequencies are in rad/s inside and in Hz where a user sees them.
//! `ARCHITECTURE.md` is the map.

pub mod contact;
pub mod cosim;
pub mod data;
pub mod diagnose;
pub mod document;
pub mod effects;
pub mod fit;
pub mod fmi;
pub mod harmonic;
pub mod model;
pub mod system;
pub mod time;
pub mod vocabulary;
