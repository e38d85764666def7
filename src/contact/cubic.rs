//! A cubic spring.

use super::error::{Bounds, LawError, checked};
use super::{ContactLaw, Inputs, Response, Slider, SlipState, StateTangents, Tangents};

/// A spring with a linear and a cubic part: Duffing's, hardening or softening.
///
/// # Law
/// `T = k u + k₃ u³`. Independent of velocity and normal load.
///
/// # State
/// None: the force is a function of the displacement.
///
/// # Parameters
/// `tangential_stiffness` k (N/m), at least zero; `cubic_stiffness` k₃ (N/m³), finite: above zero the
/// spring hardens, below it softens.
///
/// # Limits of validity
/// A softening spring turns round at `|u| = √(k/(−3 k₃))` and pushes away beyond `√(k/(−k₃))`.
///
/// # Reference
/// Duffing (1918), *Erzwungene Schwingungen bei veränderlicher Eigenfrequenz*, Vieweg.
///
/// ```
/// use stickslip::contact::{ContactLaw, CubicSpring, Inputs};
/// let law = CubicSpring::new(2.0, 0.5)?;
/// let response = law.step(&[], Inputs { displacement: 2.0, velocity: 0.0, normal_load: 0.0 }, &mut []);
/// assert_eq!((response.force, response.tangents.displacement), (8.0, 8.0));
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CubicSpring {
    tangential_stiffness: f64,
    cubic_stiffness: f64,
}

impl CubicSpring {
    /// A spring of stiffness `tangential_stiffness` (N/m) at rest and `cubic_stiffness` (N/m³).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless both are finite and the first is at least zero.
    pub fn new(tangential_stiffness: f64, cubic_stiffness: f64) -> Result<Self, LawError> {
        let tangential_stiffness =
            checked("tangential_stiffness", "N/m", tangential_stiffness, Bounds::NOT_NEGATIVE)?;
        let cubic_stiffness = checked("cubic_stiffness", "N/m^3", cubic_stiffness, Bounds::FINITE)?;
        Ok(Self { tangential_stiffness, cubic_stiffness })
    }

    /// Stiffness at rest, k (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.tangential_stiffness
    }

    /// Cubic stiffness, k₃ (N/m³).
    pub fn cubic_stiffness(&self) -> f64 {
        self.cubic_stiffness
    }
}

impl ContactLaw for CubicSpring {
    fn state_len(&self) -> usize {
        0
    }

    /// Writes nothing: the force follows from the displacement.
    fn set_state(&self, _displacement: f64, _normal_load: f64, _force: f64, _state: &mut [f64]) {}

    fn step(&self, _state: &[f64], inputs: Inputs, _next: &mut [f64]) -> Response {
        let u = inputs.displacement;
        let (linear, cubic) = (self.tangential_stiffness, self.cubic_stiffness * u * u);
        Response {
            force: (linear + cubic) * u,
            tangents: Tangents { displacement: linear + 3.0 * cubic, ..Tangents::default() },
            dissipated_energy: 0.0,
            slip_state: SlipState::Stick,
        }
    }

    fn state_tangents(&self, _state: &[f64], _inputs: Inputs, out: &mut StateTangents) {
        out.reset(0);
    }

    fn sliders(&self, _normal_load: f64, out: &mut Vec<Slider>) -> bool {
        out.clear();
        if self.cubic_stiffness != 0.0 {
            return false;
        }
        if self.tangential_stiffness > 0.0 {
            out.push(Slider::linear(self.tangential_stiffness));
        }
        true
    }
}
