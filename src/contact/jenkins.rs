//! Jenkins' element: a spring in series with a Coulomb slider.

use super::error::{Bounds, LawError, checked};
use super::{ContactLaw, Inputs, Response, Slider, SlipState, StateTangents, Tangents, cut_to};
use crate::vocabulary::{FRICTION_COEFFICIENT, TANGENTIAL_STIFFNESS};

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
    tangential_stiffness: f64,
    friction_coefficient: f64,
    /// μ/k (m/N): stretch of the spring at the limit, by normal load.
    stretch_per_load: f64,
}

/// One step, with all that the response and both kinds of derivative need.
struct Step {
    force: f64,
    dissipated_energy: f64,
    branch: Branch,
}

/// Which formula gives the force at the end of the step.
enum Branch {
    /// The slider rested for the whole step.
    Stick,
    /// The slider rested since the contact closed within the step; `closed` is the fraction of the
    /// step in contact.
    StickSinceContact {
        closed: f64,
        load_change: f64,
    },
    /// At the limit, in the direction `sign`.
    Slip {
        sign: f64,
    },
    Separated,
}

impl Jenkins {
    /// A law with stiffness `tangential_stiffness` (N/m) and `friction_coefficient` (1).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless both are finite and above zero.
    pub fn new(tangential_stiffness: f64, friction_coefficient: f64) -> Result<Self, LawError> {
        let (stiffness, friction) = (&TANGENTIAL_STIFFNESS, &FRICTION_COEFFICIENT);
        let tangential_stiffness =
            checked(stiffness.name, stiffness.unit, tangential_stiffness, Bounds::POSITIVE)?;
        let friction_coefficient =
            checked(friction.name, friction.unit, friction_coefficient, Bounds::POSITIVE)?;
        let stretch_per_load = friction_coefficient / tangential_stiffness;
        Ok(Self { tangential_stiffness, friction_coefficient, stretch_per_load })
    }

    /// Stiffness in stick, k (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.tangential_stiffness
    }

    /// Coefficient of friction, μ (1).
    pub fn friction_coefficient(&self) -> f64 {
        self.friction_coefficient
    }

    fn evaluate(&self, state: &[f64], inputs: Inputs) -> Step {
        let (slider, start, start_load) = (state[0], state[1], state[2]);
        let (end, end_load) = (inputs.displacement, inputs.normal_load);
        if end_load <= 0.0 {
            let dissipated_energy =
                if start_load > 0.0 { self.lift_off(slider, start, start_load, inputs) } else { 0.0 };
            return Step { force: 0.0, dissipated_energy, branch: Branch::Separated };
        }
        if start_load <= 0.0 {
            return self.re_contact(start, start_load, inputs);
        }
        let stretch = end - slider;
        let slipped = stretch.abs() - self.stretch_per_load * end_load;
        if slipped <= 0.0 {
            let force = cut_to(self.tangential_stiffness * stretch, self.friction_coefficient * end_load);
            return Step { force, dissipated_energy: 0.0, branch: Branch::Stick };
        }
        let sign = stretch.signum();
        // Slip begins where the stuck force crosses the limit, a fraction `stuck` into the step, and
        // lasts; the slider's speed is constant and the limit linear, so their mean values multiply.
        let margin = self.margin(sign, slider, start, start_load);
        let stuck = margin / (margin + slipped);
        let mean_load = end_load + 0.5 * (1.0 - stuck) * (start_load - end_load);
        Step {
            force: sign * (self.friction_coefficient * end_load),
            dissipated_energy: self.friction_coefficient * mean_load * slipped,
            branch: Branch::Slip { sign },
        }
    }

    /// A step in which the contact closes. The slider starts from the displacement at that instant;
    /// from there spring force and limit both grow from zero in proportion, so that the rest of the step
    /// sticks or slips throughout.
    fn re_contact(&self, start: f64, start_load: f64, inputs: Inputs) -> Step {
        let load_change = inputs.normal_load - start_load;
        let closed = inputs.normal_load / load_change;
        let travel = closed * (inputs.displacement - start);
        let limit = self.friction_coefficient * inputs.normal_load;
        let slipped = travel.abs() - self.stretch_per_load * inputs.normal_load;
        if slipped <= 0.0 {
            let force = cut_to(self.tangential_stiffness * travel, limit);
            let branch = Branch::StickSinceContact { closed, load_change };
            return Step { force, dissipated_energy: 0.0, branch };
        }
        let sign = travel.signum();
        let dissipated_energy = 0.5 * limit * slipped;
        Step { force: sign * limit, dissipated_energy, branch: Branch::Slip { sign } }
    }

    /// How far (m) the spring at the start of the step could still stretch in the direction `sign`.
    /// Round-off may put a slipping state slightly beyond its limit, hence the cut at zero.
    fn margin(&self, sign: f64, slider: f64, start: f64, start_load: f64) -> f64 {
        (self.stretch_per_load * start_load - sign * (start - slider)).max(0.0)
    }

    /// Energy (J) dissipated on the way to the instant `N = 0` within the step: as the limit falls to
    /// zero the slider must give up all of the spring's stretch.
    fn lift_off(&self, slider: f64, start: f64, start_load: f64, inputs: Inputs) -> f64 {
        let fraction = start_load / (start_load - inputs.normal_load);
        let stretch = start + fraction * (inputs.displacement - start) - slider;
        if stretch == 0.0 {
            return 0.0;
        }
        let margin = self.margin(stretch.signum(), slider, start, start_load);
        let slipped = stretch.abs();
        let load_at_slip = start_load * (slipped / (margin + slipped));
        0.5 * self.friction_coefficient * load_at_slip * slipped
    }
}

impl ContactLaw for Jenkins {
    fn state_len(&self) -> usize {
        3
    }

    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        let limit = self.limit(normal_load);
        let force = cut_to(force, limit);
        state[0] = displacement - force / self.tangential_stiffness;
        state[1] = displacement;
        state[2] = normal_load;
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let step = self.evaluate(state, inputs);
        // In stick the slider is kept to the last bit rather than recomputed from the force.
        next[0] = match step.branch {
            Branch::Stick => state[0],
            Branch::Separated => inputs.displacement,
            Branch::Slip { sign } => {
                inputs.displacement - sign * (self.stretch_per_load * inputs.normal_load)
            }
            Branch::StickSinceContact { closed, .. } => {
                state[1] + (1.0 - closed) * (inputs.displacement - state[1])
            }
        };
        next[1] = inputs.displacement;
        next[2] = inputs.normal_load;
        let (displacement, normal_load, slip_state) = match step.branch {
            Branch::Stick => (self.tangential_stiffness, 0.0, SlipState::Stick),
            Branch::StickSinceContact { closed, load_change } => {
                let travel = inputs.displacement - state[1];
                let by_load = -self.tangential_stiffness * travel * (state[2] / load_change) / load_change;
                (self.tangential_stiffness * closed, by_load, SlipState::Stick)
            }
            Branch::Slip { sign } => (0.0, sign * self.friction_coefficient, SlipState::Slip),
            Branch::Separated => (0.0, 0.0, SlipState::Separated),
        };
        Response {
            force: step.force,
            tangents: Tangents { displacement, velocity: 0.0, normal_load },
            dissipated_energy: step.dissipated_energy,
            slip_state,
        }
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        out.reset(3);
        let stiffness = self.tangential_stiffness;
        let friction = self.friction_coefficient;
        // ∂next/∂(z, u, N | displacement, normal_load) follows from z = u − T/k, except when apart.
        match self.evaluate(state, inputs).branch {
            Branch::Stick => {
                out.force_by_state[0] = -stiffness;
                out.next_by_state[0] = 1.0;
            }
            Branch::StickSinceContact { closed, load_change } => {
                let travel = inputs.displacement - state[1];
                let slider_by_start_load = -travel * (closed / load_change);
                out.force_by_state[1] = -stiffness * closed;
                out.force_by_state[2] = -stiffness * slider_by_start_load;
                out.next_by_state[1] = closed;
                out.next_by_state[2] = slider_by_start_load;
                out.next_by_displacement[0] = 1.0 - closed;
                out.next_by_normal_load[0] = travel * (state[2] / load_change) / load_change;
            }
            Branch::Slip { sign } => {
                out.next_by_displacement[0] = 1.0;
                out.next_by_normal_load[0] = -sign * friction / stiffness;
            }
            Branch::Separated => out.next_by_displacement[0] = 1.0,
        }
        out.next_by_displacement[1] = 1.0;
        out.next_by_normal_load[2] = 1.0;
    }

    fn limit(&self, normal_load: f64) -> f64 {
        if normal_load <= 0.0 { 0.0 } else { self.friction_coefficient * normal_load }
    }

    fn sliders(&self, normal_load: f64, out: &mut Vec<Slider>) -> bool {
        out.clear();
        if normal_load > 0.0 {
            out.push(Slider::jenkins(self.tangential_stiffness, self.limit(normal_load)));
        }
        true
    }
}
