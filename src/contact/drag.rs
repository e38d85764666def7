//! Quadratic drag.

use super::error::{Bounds, LawError, checked};
use super::{ContactLaw, Inputs, Response, SlipState, StateTangents, Tangents};
use crate::vocabulary as v;

/// Drag of a medium that is pushed aside.
///
/// # Law
/// `T = q |v| v`. Depends on the velocity at the end of the step alone; the energy of a step is the mean of the
/// forces at its ends times its displacement.
///
/// # State
/// `[u, T]`: displacement (m) and force (N) at the end of the last step, for the energy.
///
/// # Parameters
/// `quadratic_damping` q (N s²/m²), finite: above zero it takes energy, below it feeds energy in, which a fit may try.
///
/// # Limits of validity
/// Steady turbulent flow: no added mass of the medium, no memory of its own wake.
///
/// # Reference
/// Free decay between turning points: `x e^(−2qx/m)` changes as derived by Milne (1923), *University of California
/// Publications in Mathematics* 2; the equivalent damping ratio is `4 q A/(3 π m)` at amplitude A.
///
/// ```
/// use stickslip::contact::{ContactLaw, Drag, Inputs};
/// let law = Drag::new(0.5)?;
/// let inputs = Inputs { displacement: 0.0, velocity: -2.0, normal_load: 0.0 };
/// let response = law.step(&[0.0; 2], inputs, &mut [0.0; 2]);
/// assert_eq!((response.force, response.tangents.velocity), (-2.0, 2.0));
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    quadratic_damping: f64,
}

impl Drag {
    /// Drag with the coefficient `quadratic_damping` (N s²/m²).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless it is finite.
    pub fn new(quadratic_damping: f64) -> Result<Self, LawError> {
        let quadratic_damping =
            checked(v::QUADRATIC_DAMPING.name, v::QUADRATIC_DAMPING.unit, quadratic_damping, Bounds::FINITE)?;
        Ok(Self { quadratic_damping })
    }

    /// The coefficient q (N s²/m²).
    pub fn quadratic_damping(&self) -> f64 {
        self.quadratic_damping
    }
}

impl ContactLaw for Drag {
    fn state_len(&self) -> usize {
        2
    }

    fn set_state(&self, displacement: f64, _normal_load: f64, force: f64, state: &mut [f64]) {
        state[..2].copy_from_slice(&[displacement, force]);
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let slope = self.quadratic_damping * inputs.velocity.abs();
        let force = slope * inputs.velocity;
        next[..2].copy_from_slice(&[inputs.displacement, force]);
        let work = 0.5 * (state[1] + force) * (inputs.displacement - state[0]);
        Response {
            force,
            tangents: Tangents { velocity: 2.0 * slope, ..Tangents::default() },
            dissipated_energy: work.max(0.0),
            slip_state: SlipState::Stick,
        }
    }

    fn state_tangents(&self, _state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        out.reset(2);
        out.next_by_displacement[0] = 1.0;
        out.next_by_velocity[1] = 2.0 * self.quadratic_damping * inputs.velocity.abs();
    }
}
