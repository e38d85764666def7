//! Jenkins' element with play.

use super::element::Element;
use super::error::{Bounds, LawError, checked, checked_pair};
use super::{ContactLaw, Inputs, Response, Slider, StateTangents};

/// Jenkins' element with play of half-width g in series: a clearance that must be taken up before the
/// contact resists.
///
/// ```text
///              T ▲        ┌─────── μN
///                │       ╱        ╱
///                │      ╱ k      ╱
///   ─────────────┼─────╱────────╱──► u
///          ╱     └──g──┘  ╱─2g─╱
///    ─────┘  −μN
/// ```
///
/// # Law
/// `T = k d_g(u − z)` with `|T| ≤ μN`, where `d_g(x)` is zero for `|x| ≤ g`, `x − g` above and `x + g`
/// below. In stick the slider `z` rests; in slip it follows so that `T = ±μN(t)`. After a reversal out of
/// slip the force falls to zero with the slope k, stays there over the play 2g, and only then builds up. At
/// `N ≤ 0` the bodies are apart, `T = 0` and the slider follows the displacement: on re-contact the play
/// lies evenly on both sides. A change of `N` alone moves the limit and never creates a force.
///
/// Displacement and normal load run linearly within a step, and the step is exact, as Jenkins'. A
/// symmetric closed loop of amplitude `U > g + μN/k` dissipates `4 μN (U − g − μN/k)`. Without play the law is
/// [`super::Jenkins`].
///
/// # State
/// `[z, u, N]`: slider position (m), displacement (m) and normal load (N) at the end of the last step.
///
/// # Parameters
/// `tangential_stiffness` k (N/m) and `friction_coefficient` μ (1), both above zero; `play` g (m), half of
/// the clearance, at least zero.
///
/// # Limits of validity
/// The play closes without impact. A step must not contain a reversal.
///
/// # Reference
/// Play and stop operators in series: Visintin (1994), *Differential Models of Hysteresis*, Springer, ch. III.
///
/// ```
/// use stickslip::contact::{Backlash, ContactLaw, Inputs};
/// let law = Backlash::new(2e6, 0.5, 10e-6)?;
/// let (mut state, mut next) = ([0.0; 3], [0.0; 3]);
/// law.set_state(0.0, 100.0, 0.0, &mut state);
/// let mut force = |displacement| {
///     let response = law.step(&state, Inputs { displacement, velocity: 0.0, normal_load: 100.0 }, &mut next);
///     state = next;
///     response.force
/// };
/// assert_eq!(force(8e-6), 0.0);
/// assert!((force(15e-6) - 10.0).abs() < 1e-9);
/// assert_eq!(force(80e-6), 50.0);
/// assert_eq!(force(50e-6), 0.0);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Backlash {
    element: Element,
}

impl Backlash {
    /// A law with stiffness `tangential_stiffness` (N/m), `friction_coefficient` (1) and half-width of the
    /// play `play` (m).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless all are finite, the play at least zero and the others above.
    pub fn new(tangential_stiffness: f64, friction_coefficient: f64, play: f64) -> Result<Self, LawError> {
        let (stiffness, friction) = checked_pair(tangential_stiffness, friction_coefficient)?;
        let play = checked("play", "m", play, Bounds::NOT_NEGATIVE)?;
        Ok(Self { element: Element::new(stiffness, friction, play) })
    }

    /// Stiffness in stick outside the play, k (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.element.stiffness
    }

    /// Coefficient of friction, μ (1).
    pub fn friction_coefficient(&self) -> f64 {
        self.element.friction
    }

    /// Half-width of the play, g (m).
    pub fn play(&self) -> f64 {
        self.element.play
    }

    /// Energy (J) kept in the spring in `state`.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        self.element.stored_energy(state[0], state[1])
    }
}

impl ContactLaw for Backlash {
    fn state_len(&self) -> usize {
        3
    }

    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        self.element.set_state(displacement, normal_load, force, state);
    }

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
            let Element { stiffness, play, .. } = self.element;
            let jenkins = Slider::jenkins(stiffness, self.limit(normal_load));
            out.push(Slider { play_below: -play, play_above: play, ..jenkins });
        }
        true
    }
}
