//! Time integration of the modal beam, with a friction contact or under an external contact force.
//!
//! # Equations
//! `q̈ᵢ + 2 ζᵢ ωᵢ q̇ᵢ + ωᵢ² qᵢ + T [cᵢ − Σⱼ Gᵢⱼ qⱼ] + Σₖ Tₖ φᵢ(xₖ) = f φᵢ(S)` with the contact displacement
//! `u = c·q − ½ qᵀG q − a T` and velocity `u̇ = c·q̇ − qᵀG q̇ − a Ṫ`, `a` the axial flexibility.
//! The forces `Tₖ` at further contact points come from outside. The contact force `T` is restoring. It either comes from outside ([`Contact::Force`]) or from a
//! law ([`Contact::Friction`]), where `T = law(u)` is an equation for `T` as soon as `a > 0`. A law in
//! series with the axial spring has the tangent `D/(1 + a D)`.
//!
//! **Direct feed-through.** Under [`Contact::Force`] a jump of `T` at a communication point makes `u`
//! jump by `−a ΔT` at once. Under [`Contact::Friction`] a jump of the normal load changes `T` and `u`
//! at once where the new limit cuts the force, and the excitation passes to the accelerations.
//!
//! # Method
//! The twentieth mode lies two to three decades above the first and would set the step of an explicit
//! Runge–Kutta method, though it carries little. So each mode's linear part is solved
//! exactly, and only the forcing `p = f φ − Σ Tₖ φₖ − T (c − G q)` is approximated, by a polynomial over the step:
//!
//! 1. *Collocation* with a quadratic through the start, the middle and the end of the step (Lobatto's
//!    points, order 4). The middle's force answers to itself implicitly, the rest by sweeps; a stuck
//!    contact much stiffer than the beam still converges.
//! 2. *Correction*: the forcing is evaluated at ¼ and ¾ as well and a quartic through all five gives
//!    the end state (order 5). The difference of the two, in the energy norm `√Σ(ω²q² + q̇²)`, is the
//!    error estimate, held below the tolerance times the norm of the state.
//!
//! Steps adapt to the estimate, so that a high mode limits the step only once its motion matters.
//!
//! # Events
//! Every stage evaluates the law from the state committed at the start of the step, which is right as
//! long as `u` runs one way. Reversals of `u` are therefore located and end a step, and so does a
//! change of [`SlipState`](crate::contact::SlipState) (the corner of Jenkins' loop, lift-off,
//! re-contact), where the force has a kink that no polynomial follows.
//!
//! # State
//! [`BeamMotion`] is one flat list of numbers and holds everything that the future depends on, the
//! suggested step size included: a copy written back gives the same future bit for bit.

mod beam;
mod change;
mod contact_point;
mod error;
mod events;
pub mod exact;
mod implicit;
mod motion;
mod propagator;
mod rates;
mod sampled;
mod step;
mod trial;

pub use beam::{BeamIntegrator, BeamOutputs, SensorReading};
pub(crate) use change::{BeamChange, BeamInputChange};
pub use error::{BeamError, IntegrationError};
pub use exact::{
    Excitation, LoadedContact, OscillatorError, OscillatorFlow, OscillatorMotion, Passage, PeriodicMotion,
    RungeKutta, ShootingSettings, Transient, shoot,
};
pub use implicit::{OscillatorIntegrator, OscillatorState};
pub use motion::BeamMotion;
pub(crate) use rates::BeamRates;
pub(crate) use sampled::Followed;
pub use sampled::{Drive, MOST_STEPPED, SampledIntegrator};

use crate::contact::ContactLaw;

/// An input over one communication step: held, or running linearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    /// Value at the start of the step.
    pub start: f64,
    /// Value at its end.
    pub end: f64,
}

impl Ramp {
    /// The same value throughout.
    pub const fn held(value: f64) -> Self {
        Self { start: value, end: value }
    }

    /// From `start` with the time derivative `slope` (1/s) over `duration` (s).
    pub const fn with_slope(start: f64, slope: f64, duration: f64) -> Self {
        Self { start, end: start + slope * duration }
    }

    /// The value at `fraction` of the step; exact at both ends.
    pub(crate) fn at(&self, fraction: f64) -> f64 {
        if fraction >= 1.0 { self.end } else { self.start + (self.end - self.start) * fraction }
    }
}

/// What acts on the beam at its contact.
#[derive(Debug, Clone, Copy)]
pub enum Contact<'a> {
    /// An external restoring force T (N).
    Force(Ramp),
    /// A contact law.
    Friction {
        /// The law; its memory is part of [`BeamMotion`].
        law: &'a dyn ContactLaw,
        /// Normal load (N).
        normal_load: Ramp,
    },
}

/// Everything that acts on the beam over a communication step.
#[derive(Debug, Clone, Copy)]
pub struct BeamInputs<'a> {
    /// Force f of the exciter (N).
    pub excitation: Ramp,
    /// What acts at the contact.
    pub contact: Contact<'a>,
    /// Restoring forces Tₖ (N) at the beam's [contact points](crate::system::ModalBeam::contact_points), in their order.
    pub at_points: &'a [Ramp],
}

/// How accurate, and how much work at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Relative tolerance (1) on the error of a step in the energy norm, between 1e-13 and 0.1.
    pub tolerance: f64,
    /// Most steps, rejected ones included, within one communication step.
    pub step_limit: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-6, step_limit: 1_000_000 }
    }
}
