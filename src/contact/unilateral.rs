//! A one-sided spring with a gap.

use super::error::{Bounds, LawError, checked};
use super::{ContactLaw, Inputs, Response, Slider, SlipState, StateTangents, Tangents};

/// A spring that only resists displacement above a gap: an elastic stop.
///
/// ```text
///        T ▲         ╱
///          │        ╱ k
///   ───────┼───────╱──► u
///          └─ gap ─┘
/// ```
///
/// # Law
/// `T = k (u − g)` for `u > g`, otherwise zero; g is the gap. Independent of velocity and normal load. With a negative
/// gap the contact is closed at rest and carries `k |g|`.
///
/// # State
/// None: the force is a function of the displacement.
///
/// # Parameters
/// `tangential_stiffness` k (N/m), above zero; `gap` g (m), finite.
///
/// # Limits of validity
/// Elastic: no energy is lost in an impact, and none is ever dissipated. For a stop on the other side
/// reverse the direction of the contact.
///
/// # Reference
/// Shaw & Holmes (1983), *A periodically forced piecewise linear oscillator*, J. Sound Vib. 90, 129–155.
///
/// ```
/// use stickslip::contact::{ContactLaw, Inputs, Unilateral};
/// let law = Unilateral::new(1e6, 2e-6)?;
/// let force = |displacement| {
///     law.step(&[], Inputs { displacement, velocity: 0.0, normal_load: 0.0 }, &mut []).force
/// };
/// assert_eq!((force(-1.0), force(2e-6)), (0.0, 0.0));
/// assert!((force(5e-6) - 3.0).abs() < 1e-12);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unilateral {
    spring: Slider,
}

impl Unilateral {
    /// A stop of stiffness `tangential_stiffness` (N/m) behind the gap `gap` (m).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless both are finite and the stiffness is above zero.
    pub fn new(tangential_stiffness: f64, gap: f64) -> Result<Self, LawError> {
        let stiffness = checked("tangential_stiffness", "N/m", tangential_stiffness, Bounds::POSITIVE)?;
        let gap = checked("gap", "m", gap, Bounds::FINITE)?;
        Ok(Self { spring: Slider::unilateral(stiffness, gap) })
    }

    /// Stiffness of the stop, k (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.spring.stiffness
    }

    /// Gap at rest, g (m).
    pub fn gap(&self) -> f64 {
        self.spring.play_above
    }
}

impl ContactLaw for Unilateral {
    fn state_len(&self) -> usize {
        0
    }

    /// Writes nothing: the force follows from the displacement.
    fn set_state(&self, _displacement: f64, _normal_load: f64, _force: f64, _state: &mut [f64]) {}

    fn step(&self, _state: &[f64], inputs: Inputs, _next: &mut [f64]) -> Response {
        let (force, _) = self.spring.step(0.0, inputs.displacement);
        let (displacement, slip_state) = if inputs.displacement > self.gap() {
            (self.spring.stiffness, SlipState::Stick)
        } else {
            (0.0, SlipState::Separated)
        };
        let tangents = Tangents { displacement, ..Tangents::default() };
        Response { force, tangents, dissipated_energy: 0.0, slip_state }
    }

    fn state_tangents(&self, _state: &[f64], _inputs: Inputs, out: &mut StateTangents) {
        out.reset(0);
    }

    fn is_odd(&self) -> bool {
        false
    }

    fn sliders(&self, _normal_load: f64, out: &mut Vec<Slider>) -> bool {
        out.clear();
        out.push(self.spring);
        true
    }
}
