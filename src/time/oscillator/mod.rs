//! Time integration of lumped oscillators with contacts.
//!
//! `M q̈ + C q̇ + K q + Σ Bᵢᵀ Tᵢ(uᵢ) = e f(t)`, `uᵢ = Bᵢ q`: a [`LinearStructure`](crate::system::LinearStructure)
//! with contact laws whose forces are restoring. Independent of the harmonic balance, and its check:
//!
//! - [`OscillatorFlow`]: exact, event by event, for piecewise-linear laws;
//! - [`shoot`]: periodic motions of that flow by Newton's method on the period map, with Floquet multipliers;
//! - [`OscillatorIntegrator`]: any law, adaptive steps of order four to five;
//! - [`SampledIntegrator`]: any law and load, steps of one length, for fits that simulate thousands of times;
//! - [`RungeKutta`]: the classical scheme on the rate form of sliders, fixed steps.

pub(crate) mod elements;
mod error;
mod excitation;
mod flow;
mod implicit;
mod passage;
pub(crate) mod polynomial;
mod runge_kutta;
mod sampled;
mod shooting;
pub(crate) mod system;

pub use elements::LoadedContact;
pub use error::OscillatorError;
pub use excitation::Excitation;
pub use flow::{OscillatorFlow, OscillatorMotion};
pub use implicit::{OscillatorIntegrator, OscillatorState};
pub use passage::Passage;
pub use runge_kutta::{RungeKutta, Transient};
pub(crate) use sampled::Followed;
pub use sampled::{Drive, MOST_STEPPED, SampledIntegrator};
pub(crate) use shooting::multipliers;
pub use shooting::{PeriodicMotion, ShootingSettings, shoot};
