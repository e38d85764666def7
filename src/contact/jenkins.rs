//! Jenkins' element: a spring in series with a Coulomb slider.

use super::element::Element;
use super::error::{LawError, checked_pair};
use super::kind::{BaseLaw, JointBase, LawKind};
use super::{ContactLaw, Inputs, Response, Slider, StateTangents};

/// Jenkins' element, `T = k (u − z)` with `|T| ≤ μ N`.
///
/// ```text
///         T ▲   ┌─────────── μN
///           │  ╱           ╱
///           │ ╱ k         ╱
///   ────────┼╱───────────╱──► u
///           ╱           ╱
///     −μN ─────────────┘
/// ```
///
/// # Law
/// In stick the slider `z` rests; in slip it follows so that `T = ±μ N(t)`. At `N ≤ 0` the bodies
/// are apart, `T = 0` and the slider follows the displacement: re-contact remembers nothing. A change
/// of `N` alone moves the limit and never creates a force.
///
/// Displacement and normal load run linearly within a step. The distance of the stuck force from
/// either limit is then linear too, so that it changes sign once at most and slip, once begun, lasts:
/// force, slider and dissipated energy of a step are exact, whatever its size. A lift-off or a
/// re-contact within the step is taken at its instant, `N = 0`.
///
/// # State
/// `[z, u, N]`: slider position (m), displacement (m) and normal load (N) at the end of the last step.
///
/// # Parameters
/// `tangential_stiffness` k (N/m) and `friction_coefficient` μ (1), both above zero.
///
/// # Limits of validity
/// One slider: the whole contact sticks or slips at once. A step must not contain a reversal.
///
/// # Reference
/// Two-mass oscillator with a Jenkins element, eq. 2; its slip branch is read as
/// `z = u − sgn(u − z) μN/k`.
///
/// ```
/// use stickslip::contact::{ContactLaw, Inputs, Jenkins, SlipState};
/// let law = Jenkins::new(2e6, 0.5)?;
/// let (mut state, mut next) = ([0.0; 3], [0.0; 3]);
/// law.set_state(0.0, 100.0, 0.0, &mut state);
/// let inputs = Inputs { displacement: 40e-6, velocity: 0.0, normal_load: 100.0 };
/// let response = law.step(&state, inputs, &mut next);
/// assert_eq!(response.force, 50.0);
/// assert_eq!(response.slip_state, SlipState::Slip);
/// assert!((response.dissipated_energy - 50.0 * 15e-6).abs() < 1e-15);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jenkins {
    element: Element,
}

pub(super) static KIND: LawKind = LawKind {
    name: "jenkins",
    fmu_name: "JenkinsContact",
    summary: "Friction contact: Jenkins' element",
    equations: &[
        "stick: Ṫ = k u̇, while |T| < μ N",
        "slip: T = μ N sgn(u̇)",
        "k: tangential_stiffness, μ: friction_coefficient, N: normal_load",
    ],
    parameters: &[],
    one_slider: true,
    refuses: |_| None,
    build: |values| Ok(Jenkins::new(values.tangential_stiffness, values.friction_coefficient)?.into()),
};

impl Jenkins {
    /// A law with stiffness `tangential_stiffness` (N/m) and `friction_coefficient` (1).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless both are finite and above zero.
    ///
    /// ```
    /// use stickslip::contact::{ContactLaw, Jenkins};
    /// assert_eq!(Jenkins::new(2e6, 0.5)?.limit(100.0), 50.0);
    /// assert!(Jenkins::new(0.0, 0.5).is_err());
    /// # Ok::<(), stickslip::contact::LawError>(())
    /// ```
    pub fn new(tangential_stiffness: f64, friction_coefficient: f64) -> Result<Self, LawError> {
        let (stiffness, friction) = checked_pair(tangential_stiffness, friction_coefficient)?;
        Ok(Self { element: Element::new(stiffness, friction, 0.0) })
    }

    /// Stiffness in stick, k (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.element.stiffness
    }

    /// [`ContactLaw::step`] of a contact that is closed from beginning to end, without a call; `None` of another.
    #[inline(always)]
    pub(crate) fn step_closed(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Option<Response> {
        self.element.step_closed(state, inputs, next)
    }

    /// Coefficient of friction, μ (1).
    pub fn friction_coefficient(&self) -> f64 {
        self.element.friction
    }
}

impl From<Element> for Jenkins {
    fn from(element: Element) -> Self {
        Self { element }
    }
}

impl From<Jenkins> for JointBase {
    fn from(law: Jenkins) -> Self {
        Self(BaseLaw::Slider(law.element))
    }
}

impl ContactLaw for Jenkins {
    fn state_len(&self) -> usize {
        3
    }

    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        self.element.set_state(displacement, normal_load, force, state);
    }

    #[inline(always)]
    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        self.element.step(state, inputs, next)
    }

    fn advance(&self, state: &mut [f64], inputs: Inputs) -> f64 {
        self.element.advance(state, inputs)
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        self.element.state_tangents(state, inputs, out);
    }

    fn limit(&self, normal_load: f64) -> f64 {
        self.element.limit(normal_load)
    }

    fn sliders(&self, normal_load: f64, out: &mut Vec<Slider>) -> bool {
        out.clear();
        if normal_load > 0.0 {
            out.push(Slider::jenkins(self.element.stiffness, self.limit(normal_load)));
        }
        true
    }
}
