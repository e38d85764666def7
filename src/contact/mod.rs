//! Contact laws, each a pure step `(state, inputs) → (force, tangents, next state)`.
//!
//! # Sign convention
//! A contact force is *restoring*: positive when it resists positive relative displacement. It
//! enters the equation of motion on the left-hand side as `+ Bᵀ T`, and its work `∮ T du` over a
//! closed cycle, the dissipated energy, is never negative.
//!
//! # State
//! A law's memory is a slice of `state_len()` numbers that the caller owns. Nothing is hidden in
//! the law: roll-back, rejected trial steps and harmonic balance need no more than a copy.

mod backlash;
mod bouc_wen;
mod catalogue;
mod cubic;
mod drag;
mod element;
mod error;
mod gradual;
mod iwan;
mod jenkins;
mod joint;
mod kind;
mod measured;
mod parallel;
mod periodic;
pub(crate) mod quadrature;
mod slider;
mod slip_slap;
mod state_sensitivity;
mod unilateral;
mod valanis;

pub use backlash::Backlash;
pub use bouc_wen::BoucWen;
pub(crate) use catalogue::AnyLaw;
pub use catalogue::{LAWS, Law, MEASURED};
pub use cubic::CubicSpring;
pub use drag::Drag;
pub use error::{Bounds, LawError};
pub use gradual::{Gradual, GradualLaw};
pub use iwan::{Iwan, IwanSpacing};
pub use jenkins::Jenkins;
pub use joint::{Joint, JointChanges, MICRO_SLIDERS};
pub use kind::{JointBase, LawKind, LawParameter, LawRule, LawValues, MOST_PARAMETERS};
pub use measured::Measured;
pub use parallel::ParallelSliders;
pub use periodic::{Period, PeriodicError, PeriodicInfo, PeriodicSolver, periodic_state};
pub use slider::Slider;
pub use slip_slap::{
    NormalDirection, NormalLaw, SlipSlap, SlipSlapInputs, SlipSlapResponse, SlipSlapTangents, SlipSlapWork,
};
pub(crate) use state_sensitivity::StateSensitivity;
pub use unilateral::Unilateral;
pub use valanis::Valanis;

/// A contact law under the constant normal load it has in a structure.
///
/// ```
/// use stickslip::prelude::*;
/// let law = Jenkins::new(2e6, 0.5)?;
/// let contact = LoadedContact { law: &law, normal_load: 100.0 };
/// assert_eq!(contact.law.limit(contact.normal_load), 50.0);
/// # Ok::<(), LawError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct LoadedContact<'a> {
    /// The law.
    pub law: &'a dyn ContactLaw,
    /// Normal load (N); laws that know none ignore it.
    pub normal_load: f64,
}

/// What a contact sees at the end of a step. Within the step displacement and normal load run
/// linearly from their previous values, which are part of the state.
///
/// ```
/// use stickslip::prelude::*;
/// let inputs = Inputs { displacement: 10e-6, velocity: 0.0, normal_load: 100.0 };
/// let law = Jenkins::new(2e6, 0.5)?;
/// assert_eq!(law.step(&[0.0, 0.0, 100.0], inputs, &mut [0.0; 3]).force, 20.0);
/// # Ok::<(), LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Relative tangential displacement (m).
    pub displacement: f64,
    /// Relative tangential velocity (m/s); only rate-dependent laws use it. Behind a flexibility in series it is that of the
    /// displacement, but for a law whose [limit follows the velocity](ContactLaw::limit_follows_velocity).
    pub velocity: f64,
    /// Normal load (N); at zero or below the contact is separated.
    pub normal_load: f64,
}

/// Derivatives of the force at the end of the step with respect to the inputs, at fixed state.
///
/// ```
/// use stickslip::prelude::*;
/// let law = Jenkins::new(2e6, 0.5)?;
/// let tangents = |displacement| {
///     let inputs = Inputs { displacement, velocity: 0.0, normal_load: 100.0 };
///     law.step(&[0.0, 0.0, 100.0], inputs, &mut [0.0; 3]).tangents
/// };
/// // In stick the spring, in slip the coefficient of friction.
/// assert_eq!(tangents(10e-6).displacement, 2e6);
/// assert_eq!((tangents(40e-6).displacement, tangents(40e-6).normal_load), (0.0, 0.5));
/// # Ok::<(), LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tangents {
    /// ∂force/∂displacement (N/m).
    pub displacement: f64,
    /// ∂force/∂velocity (N s/m).
    pub velocity: f64,
    /// ∂force/∂normal_load (1).
    pub normal_load: f64,
}

/// What the contact does at the end of a step.
///
/// ```
/// use stickslip::prelude::*;
/// let law = Jenkins::new(2e6, 0.5)?;
/// let state = |displacement, normal_load| {
///     law.step(&[0.0, 0.0, 100.0], Inputs { displacement, velocity: 0.0, normal_load }, &mut [0.0; 3]).slip_state
/// };
/// assert_eq!(state(10e-6, 100.0), SlipState::Stick);
/// assert_eq!(state(40e-6, 100.0), SlipState::Slip);
/// assert_eq!(state(40e-6, -1.0), SlipState::Separated);
/// # Ok::<(), LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum SlipState {
    /// No point of the contact slides. A law without a distinct stick, as Valanis', never reports it.
    Stick = 0,
    /// The contact slides, wholly or in part.
    Slip = 1,
    /// No normal load: the bodies are apart and the force is zero.
    Separated = 2,
}

/// Result of one step of a law.
///
/// ```
/// use stickslip::prelude::*;
/// let law = Jenkins::new(2e6, 0.5)?;
/// let mut state = [0.0; 3];
/// law.set_state(0.0, 100.0, 0.0, &mut state);
/// let inputs = Inputs { displacement: 40e-6, velocity: 0.0, normal_load: 100.0 };
/// let response: Response = law.step(&state, inputs, &mut [0.0; 3]);
/// // It slips at 50 N, over the last 15 µm.
/// assert_eq!(response.force, 50.0);
/// assert!((response.dissipated_energy - 50.0 * 15e-6).abs() < 1e-12);
/// # Ok::<(), LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Restoring tangential force (N).
    pub force: f64,
    /// Derivatives of `force`.
    pub tangents: Tangents,
    /// Energy dissipated in this step (J), never negative.
    pub dissipated_energy: f64,
    /// Stick, slip or separated.
    pub slip_state: SlipState,
}

/// Derivatives of one step with respect to the previous state, needed where a derivative must be
/// carried through a whole history (periodic states, harmonic balance). Row-major.
///
/// ```
/// use stickslip::contact::{ContactLaw, Inputs, Jenkins, StateTangents};
/// let law = Jenkins::new(2e6, 0.5)?;
/// let mut tangents = StateTangents::default();
/// let inputs = Inputs { displacement: 10e-6, velocity: 0.0, normal_load: 100.0 };
/// law.state_tangents(&[0.0, 0.0, 100.0], inputs, &mut tangents);
/// // A slider that stood one metre farther would give k newtons less.
/// assert_eq!(tangents.force_by_state[0], -2e6);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StateTangents {
    /// ∂force/∂state, `n` entries.
    pub force_by_state: Vec<f64>,
    /// ∂next/∂state, `n × n` entries.
    pub next_by_state: Vec<f64>,
    /// ∂next/∂displacement, `n` entries.
    pub next_by_displacement: Vec<f64>,
    /// ∂next/∂velocity, `n` entries.
    pub next_by_velocity: Vec<f64>,
    /// ∂next/∂normal_load, `n` entries.
    pub next_by_normal_load: Vec<f64>,
}

impl StateTangents {
    /// Makes every vector fit a state of `n` numbers and fills it with zeros. Allocates only when `n`
    /// is larger than ever before.
    pub fn reset(&mut self, n: usize) {
        let sizes = [n, n * n, n, n, n];
        let vectors = [
            &mut self.force_by_state,
            &mut self.next_by_state,
            &mut self.next_by_displacement,
            &mut self.next_by_velocity,
            &mut self.next_by_normal_load,
        ];
        for (vector, size) in vectors.into_iter().zip(sizes) {
            vector.clear();
            vector.resize(size, 0.0);
        }
    }
}

/// A jump of the force: a damper that takes hold, or lets go, with a velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// Where (m).
    pub displacement: f64,
    /// The damper (N s/m): one that takes energy takes hold there, one that feeds energy in (below zero) lets go. Either
    /// way the force changes by its magnitude times the velocity.
    pub damping: f64,
}

/// A contact law with its parameters. See the module documentation for the sign convention.
///
/// ```
/// use stickslip::prelude::*;
///
/// /// Force along a history of displacements (m) under a load of 100 N.
/// fn forces(law: &dyn ContactLaw, displacements: &[f64]) -> Vec<f64> {
///     let mut state = vec![0.0; law.state_len()];
///     law.set_state(0.0, 100.0, 0.0, &mut state);
///     let inputs = |displacement| Inputs { displacement, velocity: 0.0, normal_load: 100.0 };
///     displacements.iter().map(|u| law.advance(&mut state, inputs(*u)).round()).collect()
/// }
///
/// let law = Jenkins::new(2e6, 0.5)?;
/// assert_eq!(forces(&law, &[10e-6, 40e-6, 30e-6]), [20.0, 50.0, 30.0]);
/// # Ok::<(), LawError>(())
/// ```
pub trait ContactLaw: std::fmt::Debug + Send + Sync {
    /// Length of the state slice.
    fn state_len(&self) -> usize;

    /// Writes the state in which the contact, at rest at `displacement` (m) under `normal_load` (N),
    /// carries `force` (N). A force above the limit is cut to the limit. A contact at rest that
    /// remembers nothing is `set_state(0.0, normal_load, 0.0, state)`.
    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]);

    /// One step from `state` to `inputs`; writes the next state. Allocates nothing.
    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response;

    /// As [`ContactLaw::step`], in place and for the force (N) alone: for whole records walked many times.
    fn advance(&self, state: &mut [f64], inputs: Inputs) -> f64 {
        let mut few = [0.0; 64];
        let n = state.len();
        let mut many = Vec::new();
        let next = match few.get_mut(..n) {
            Some(next) => next,
            None => {
                many.resize(n, 0.0);
                &mut many
            }
        };
        let force = self.step(state, inputs, next).force;
        state.copy_from_slice(next);
        force
    }

    /// Starts a record in `state`: what counts from its start, the distance slipped, goes back to zero.
    fn restart(&self, state: &mut [f64]) {
        let _ = state;
    }

    /// Derivatives of [`ContactLaw::step`] with respect to the previous state, at the same arguments.
    /// `out`'s vectors are resized on first use and only overwritten after.
    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents);

    /// [`ContactLaw::step`] and [`ContactLaw::state_tangents`] at once, of which quadrature along a motion under constant
    /// load needs no more than force, tangents by displacement and velocity, slip state and the derivatives of the
    /// force by the state's part that is not the load: a law may leave out the rest, `next` too.
    fn force_and_tangents(
        &self,
        state: &[f64],
        inputs: Inputs,
        next: &mut [f64],
        out: &mut StateTangents,
    ) -> Response {
        self.step_and_tangents(state, inputs, next, out)
    }

    /// [`ContactLaw::step`] and [`ContactLaw::state_tangents`] at once, with all that belongs to them.
    fn step_and_tangents(
        &self,
        state: &[f64],
        inputs: Inputs,
        next: &mut [f64],
        out: &mut StateTangents,
    ) -> Response {
        let response = self.step(state, inputs, next);
        self.state_tangents(state, inputs, out);
        response
    }

    /// The largest force the law reaches under `normal_load` (N) before any residual stiffness is
    /// added (N); a law without a limit says infinity, as here.
    fn limit(&self, normal_load: f64) -> f64 {
        let _ = normal_load;
        f64::INFINITY
    }

    /// Whether the reversed history of displacement gives the reversed history of force. Then a periodic
    /// response to a force of odd harmonics can have odd harmonics alone.
    fn is_odd(&self) -> bool {
        true
    }

    /// Whether stick is a state of its own; a law that slips however small the motion has none.
    fn has_stick(&self) -> bool {
        true
    }

    /// Whether the limit itself follows the velocity or the way already slipped. Then the force along a stroke is
    /// not that of one step from the stroke's start, and a period must be walked in small steps.
    fn limit_moves(&self) -> bool {
        false
    }

    /// Whether the limit follows the velocity. At a port with a flexibility in series the law has the velocity in front of it
    /// then: with its own a limit that falls with it would have it run away within no time.
    fn limit_follows_velocity(&self) -> bool {
        false
    }

    /// Where the force jumps on the way from the displacement of `state` to that of `inputs`, one way under constant load;
    /// `None` where it does not.
    fn jump(&self, state: &[f64], inputs: Inputs) -> Option<Jump> {
        let _ = (state, inputs);
        None
    }

    /// As [`ContactLaw::sliders`], for laws that are sliders with a viscous damper beside them: its damping
    /// (N s/m), 0 for none; `None` where the law is something else.
    fn sliders_and_damper(&self, normal_load: f64, out: &mut Vec<Slider>) -> Option<f64> {
        self.sliders(normal_load, out).then_some(0.0)
    }

    /// Writes the law under the constant `normal_load` (N) as sliders side by side, whose forces add up, and
    /// returns true; or returns false where the law is not piecewise linear.
    fn sliders(&self, normal_load: f64, out: &mut Vec<Slider>) -> bool {
        let _ = (normal_load, out);
        false
    }
}

/// `force` within `±limit`; NaN stays NaN, so that a diverged caller sees it.
/// (Two selections, each one instruction; `limit` is not negative.)
fn cut_to(force: f64, limit: f64) -> f64 {
    let force = if limit < force { limit } else { force };
    if -limit > force { -limit } else { force }
}
