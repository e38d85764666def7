//! Motion in time.
//!
//! - [`Integrator`] is the one for production: any [`System`](crate::system::System), with tangents. Its steps are under
//!   control of their error and end at events, or are equal, for records that are sampled finely (`equal`).
//! - [`exact`] is its oracle: the exact event flow of piecewise-linear oscillators, shooting for its periodic motions,
//!   and a Runge–Kutta scheme.
//! - [`ClassicalSteps`] is the plainest scheme for all elements, contacts in two directions among them, in equal steps.
//!
//! # Equations of the integrator
//! `q̈ᵢ + 2 ζᵢ ωᵢ q̇ᵢ + ωᵢ² qᵢ + Σₚ Fₚ [bₚ − γₚ G q]ᵢ = Σₖ fₖ bₖᵢ` in modal coordinates, with displacements of ports
//! `uₚ = bₚ·q − γₚ ½ qᵀG q − aₚ Fₚ`, a the flexibility in series. Restoring forces F come from a law, from springs
//! between ports or from outside. `F = law(u)` is an equation for F as soon as `a > 0`: a law of tangent D in series
//! has `D/(1 + a D)`. A law sees the velocity behind a; one whose limit follows the velocity
//! ([`limit_follows_velocity`](crate::contact::ContactLaw::limit_follows_velocity)) sees that in front of it. Damping that the modes do not diagonalise
//! is a force, too.
//!
//! **Direct feed-through.** A jump of a force from outside at a communication point makes `u` jump by `−a ΔF` at once.
//! A jump of a normal load changes F and `u` at once where the new limit cuts the force, and forces on driven ports
//! pass to the accelerations.
//!
//! # Method
//! The highest mode lies decades above the first and would set the step of an explicit Runge–Kutta method, though it
//! carries little. So the linear part is solved exactly (`propagator`), and only the forcing p, all that stands beside
//! it, is approximated by a polynomial over the step (`trial`):
//!
//! 1. *Collocation* with a quadratic through the start, the middle and the end of the step (Lobatto's
//!    points, order 4). The force of a law answers to itself implicitly (`contact_point`), the rest by sweeps; a stuck
//!    contact much stiffer than the structure still converges.
//! 2. *Correction*: the forcing is evaluated at ¼ and ¾ as well and a quartic through all five gives
//!    the end state (order 5). The difference of the two, in the energy norm `√Σ(ω²q² + q̇²)`, is the
//!    error estimate, held below the tolerance times the norm of the state (`integrator`).
//!
//! Steps adapt to the estimate, so that a high mode limits the step only once its motion matters.
//!
//! # Events
//! Every stage evaluates a law from the state committed at the start of the step, which is right as
//! long as `u` runs one way. Reversals of `u` are therefore located and end a step, and so does a
//! change of [`SlipState`](crate::contact::SlipState) (the corner of Jenkins' loop, lift-off,
//! re-contact), where the force has a kink that no polynomial follows (`events`).
//!
//! # State
//! [`Motion`] is one flat list of numbers and holds everything that the future depends on, the
//! suggested step size included: a copy written back gives the same future bit for bit. `step` works on it, `outputs`
//! reads it, and `tangent` carries a small change of the inputs along.

mod classical;
mod coefficients;
mod contact_point;
mod equal;
mod error;
mod events;
pub mod exact;
mod follow;
mod integrator;
mod motion;
mod node;
mod outputs;
mod plant;
mod propagator;
mod solve;
mod step;
mod tangent;
mod trial;

pub use classical::{ClassicalSteps, ContactInTwo, Energies, SteppedMotion};
pub use error::{IntegrationError, SystemError};
pub use exact::{
    Excitation, LoadedContact, OscillatorError, OscillatorFlow, OscillatorMotion, Passage, PeriodicMotion,
    RungeKutta, ShootingSettings, Transient, shoot,
};
pub(crate) use follow::Steps;
pub use integrator::Integrator;
pub use motion::{ContactMotion, Motion};
pub(crate) use outputs::OutputRates;
pub use outputs::{ContactReading, Outputs, SensorReading};
pub(crate) use tangent::Tangent;

/// An input over one communication step: held, running linearly, along a parabola or a cubic.
///
/// ```
/// use stickslip::time::Ramp;
/// assert_eq!(Ramp::held(3.0), Ramp::line(3.0, 3.0));
/// assert_eq!(Ramp::with_slope(1.0, -2.0, 0.25), Ramp::line(1.0, 0.5));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    /// Value at the start of the step.
    pub start: f64,
    /// Value at its end.
    pub end: f64,
    /// Four times its height above the straight line at the middle.
    pub bow: f64,
    /// What makes it a cubic: at `f` of the step it adds `skew · f (1 − f) (2 f − 1)`.
    pub skew: f64,
}

impl Ramp {
    /// The same value throughout.
    pub const fn held(value: f64) -> Self {
        Self::line(value, value)
    }

    /// On a straight line.
    pub const fn line(start: f64, end: f64) -> Self {
        Self { start, end, bow: 0.0, skew: 0.0 }
    }

    /// From `start` with the time derivative `slope` (1/s) over `duration` (s).
    pub const fn with_slope(start: f64, slope: f64, duration: f64) -> Self {
        Self::line(start, start + slope * duration)
    }

    /// From `start` with the first three derivatives with respect to time (1/s, 1/s², 1/s³) over `duration` (s).
    pub(crate) fn with_derivatives(start: f64, [first, second, third]: [f64; 3], duration: f64) -> Self {
        let (square, cube) = (0.5 * duration * duration * second, duration.powi(3) / 6.0 * third);
        let end = start + first * duration + square + cube;
        Self { start, end, bow: -square - 1.5 * cube, skew: -0.5 * cube }
    }

    /// Its rise at the end, over the step.
    pub(crate) fn rise(&self) -> f64 {
        self.end - self.start - self.bow - self.skew
    }

    /// Its derivative by the fraction of the step.
    pub(crate) fn slope(&self, fraction: f64) -> f64 {
        let line = self.end - self.start;
        if self.bow == 0.0 && self.skew == 0.0 {
            return line;
        }
        let skew = 6.0 * fraction * (1.0 - fraction) - 1.0;
        line + self.bow * (1.0 - 2.0 * fraction) + self.skew * skew
    }

    /// Where within the step it turns round, as fractions in their order.
    pub(crate) fn turns(&self) -> impl Iterator<Item = f64> + use<> {
        // Its slope is c + b f + a f².
        let Self { start, end, bow, skew } = *self;
        let (a, b, c) = (-6.0 * skew, 6.0 * skew - 2.0 * bow, end - start + bow - skew);
        let square = b * b - 4.0 * a * c;
        let mut found = [f64::NAN; 2];
        if square > 0.0 {
            let half = -0.5 * (b + square.sqrt().copysign(b));
            found = [half / a, c / half];
            found.sort_by(f64::total_cmp);
        }
        found.into_iter().filter(|fraction| (1e-6..1.0 - 1e-6).contains(fraction))
    }

    /// The value at `fraction` of the step; exact at both ends.
    pub(crate) fn at(&self, fraction: f64) -> f64 {
        if fraction >= 1.0 {
            return self.end;
        }
        let curve = self.bow + self.skew * (2.0 * fraction - 1.0);
        self.start + (self.end - self.start) * fraction + curve * fraction * (1.0 - fraction)
    }

    /// Whether it is held.
    pub(crate) fn is_held(&self) -> bool {
        self.start == self.end && self.bow == 0.0 && self.skew == 0.0
    }
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
