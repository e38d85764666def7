//! The exact motion of lumped oscillators with piecewise-linear contacts: the oracle of every other solver.
//!
//! `M q̈ + C q̇ + K q + Σ Bᵢᵀ Tᵢ(uᵢ) = e f(t)`, `uᵢ = Bᵢ q`: a [`LinearStructure`](crate::system::LinearStructure)
//! with contact laws whose forces are restoring. It shares no code with the integrator or the harmonic balance:
//!
//! - [`OscillatorFlow`] (`flow`) goes from event to event. In between, the system is linear and its motion a Taylor
//!   series (`system`, `polynomial`); `elements` are the sliders and the branch each is on, `events` what changes it,
//!   `excitation` the force, `passage` what is summed on the way.
//! - [`shoot`] (`shooting`) finds periodic motions of that flow by Newton's method on the period map, with Floquet
//!   multipliers.
//! - [`RungeKutta`] is the classical scheme on the rate form of sliders, with fixed steps.

pub(crate) mod elements;
mod error;
mod events;
mod excitation;
mod flow;
mod passage;
pub(crate) mod polynomial;
mod runge_kutta;
mod shooting;
pub(crate) mod system;

pub use crate::contact::LoadedContact;
pub use error::OscillatorError;
pub use excitation::Excitation;
pub use flow::{OscillatorFlow, OscillatorMotion};
pub use passage::Passage;
pub use runge_kutta::{RungeKutta, Transient};
#[cfg(feature = "analysis")]
pub(crate) use shooting::multipliers;
pub use shooting::{PeriodicMotion, ShootingSettings, shoot};
