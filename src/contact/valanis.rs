//! Valanis' endochronic law in the form used for frictional joints.

use super::endochronic::{Stretch, advance, dissipation};
use super::error::{Bounds, LawError, checked};
use super::{ContactLaw, Inputs, Response, SlipState, StateTangents, Tangents, cut_to};
use crate::vocabulary::{
    FRICTION_COEFFICIENT, NORMAL_LOAD, RESIDUAL_STIFFNESS, SMOOTHNESS, TANGENTIAL_STIFFNESS,
};

/// Valanis' law: slip sets in gradually, without a switch, and may keep a residual stiffness.
///
/// ```text
///        T ▲          ___───  slope e_t
///          │      _.-‾    ╱
///          │    ╱       ╱
///          │  ╱ e0     ╱  2 e0/(1 + κ) on reversal from saturation (e_t = 0)
///   ───────┼╱─────────╱──► u
/// ```
///
/// # Law
/// `Ṫ = e0 u̇ [1 + (λ/e0) s (e_t u − T)] / [1 + κ (λ/e0) s (e_t u − T)]`, `s = sgn(u̇)`. The force is
/// the sum of the hysteretic part `y`, which saturates at the friction limit `μ N`, and a residual
/// spring: `T = y + e_t (u − origin)`. With `p = e0 − e_t` and `r = e0 − κ e_t` saturation at `μ N`
/// means `λ = e0 p/(r μ N)`, for `e_t = 0` simply `λ = e0/(μ N)`.
///
/// A step is integrated in closed form, so one step equals many steps in the same direction. The
/// energy kept is `y²/(2 p) + e_t (u − origin)²/2`; what the contact dissipates is closed form too.
///
/// Normal load: a step uses the load at its end. A load that falls cuts `y` to the new limit before
/// the motion (the energy difference is dissipated); a load that rises creates no force. On
/// separation, `N ≤ 0` at the end of a step, the force is zero for the whole step, `y` vanishes and the
/// residual spring relaxes (all the energy kept is dissipated). After it, motion counts from the
/// instant at which the load, linear within the step, becomes positive.
///
/// # State
/// `[y, u, N, origin]`: hysteretic force (N), displacement (m) and normal load (N) at the end of the
/// last step, and the displacement at which the residual spring is unstressed (m).
///
/// # Parameters
/// - `tangential_stiffness` e0 (N/m), above zero: slope of the virgin curve;
/// - `friction_coefficient` μ (1), above zero;
/// - `smoothness` κ (1), 0 ≤ κ < 1: the virgin curve is exponential at 0 and Jenkins' at 1;
/// - `residual_stiffness` e_t (N/m), 0 ≤ e_t < e0. The integral holds for e_t < 0 as well, but a
///   separation would then release negative energy: refused.
///
/// # Limits of validity
/// A step must not contain a reversal. The law is not of Masing type, and minor loops do not close.
/// Because a step uses one normal load, a varying load is resolved to first order in the step. No point
/// sticks: [`SlipState::Stick`] is never reported. At a step without motion the tangent is that of
/// unloading, the stiffer of the two directions.
///
/// # Reference
/// Beam with a frictional support, eq. 10; L. Gaul, J. Lenz, *Nonlinear dynamics of structures
/// assembled by bolted joints*, Acta Mechanica 125 (1997).
///
/// ```
/// use stickslip::contact::{ContactLaw, Inputs, Valanis};
/// // Published by λ rather than by the limit: 147.15 N preload.
/// let law = Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15)?;
/// assert!((law.limit(147.15) - 7.9e6 / 8.7e4).abs() < 1e-12);
/// let (mut state, mut next) = ([0.0; 4], [0.0; 4]);
/// law.set_state(0.0, 147.15, 0.0, &mut state);
/// let inputs = Inputs { displacement: 10e-6, velocity: 0.0, normal_load: 147.15 };
/// assert!((law.step(&state, inputs, &mut next).force - 56.581491).abs() < 1e-6);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Valanis {
    tangential_stiffness: f64,
    friction_coefficient: f64,
    smoothness: f64,
    residual_stiffness: f64,
    /// p = e0 − e_t (N/m), slope of the virgin hysteretic force.
    hysteretic_stiffness: f64,
    /// p r/[e0 (1 − κ)] (N/m): reach δ = this × distance/limit.
    reach_stiffness: f64,
    /// b = κ p/[e0 (1 − κ)] of the endochronic equation (1).
    curvature: f64,
}

/// Where the motion of a step starts, after separation, re-contact and loss of normal load.
struct Start {
    /// Hysteretic force within the limit (N), and its derivative with respect to the state's.
    hysteretic_force: f64,
    kept: f64,
    /// +1 or −1 when the force was cut to plus or minus the limit, else 0.
    cut: f64,
    /// Distance moved in contact (m), signed.
    travel: f64,
    origin: f64,
    /// Present when the contact closed within the step.
    closing: Option<Closing>,
}

/// Derivatives of the distance moved in contact, when the contact closed within the step.
#[derive(Clone, Copy)]
struct Closing {
    by_displacement: f64,
    by_start_load: f64,
    by_end_load: f64,
}

/// The hysteretic force at the end of a step.
struct End {
    hysteretic_force: f64,
    dissipated_energy: f64,
    by_travel: f64,
    by_start: f64,
    /// At a given start, with respect to the limit.
    by_limit: f64,
}

impl Valanis {
    /// A law with stiffness `tangential_stiffness` e0 (N/m), `friction_coefficient` μ (1), `smoothness`
    /// κ (1) and `residual_stiffness` e_t (N/m).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless 0 < e0, 0 < μ, 0 ≤ κ < 1 and 0 ≤ e_t < e0, all finite.
    pub fn new(
        tangential_stiffness: f64,
        friction_coefficient: f64,
        smoothness: f64,
        residual_stiffness: f64,
    ) -> Result<Self, LawError> {
        let mu = &FRICTION_COEFFICIENT;
        let friction_coefficient = checked(mu.name, mu.unit, friction_coefficient, Bounds::POSITIVE)?;
        Self::check_shape(tangential_stiffness, smoothness, residual_stiffness)?;
        let hysteretic_stiffness = tangential_stiffness - residual_stiffness;
        let r = tangential_stiffness - smoothness * residual_stiffness;
        let share = hysteretic_stiffness / (tangential_stiffness * (1.0 - smoothness));
        Ok(Self {
            tangential_stiffness,
            friction_coefficient,
            smoothness,
            residual_stiffness,
            hysteretic_stiffness,
            reach_stiffness: share * r,
            curvature: share * smoothness,
        })
    }

    /// The law of published constants e0 (N/m), e_t (N/m), κ (1) and λ (1/m), which were identified
    /// under `normal_load` (N): the coefficient of friction is `e0 p/(r λ N)`.
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] as for [`Valanis::new`], and unless λ and the normal load are finite and
    /// above zero.
    pub fn from_lambda(
        tangential_stiffness: f64,
        residual_stiffness: f64,
        smoothness: f64,
        lambda: f64,
        normal_load: f64,
    ) -> Result<Self, LawError> {
        Self::check_shape(tangential_stiffness, smoothness, residual_stiffness)?;
        checked("lambda", "1/m", lambda, Bounds::POSITIVE)?;
        checked(NORMAL_LOAD.name, NORMAL_LOAD.unit, normal_load, Bounds::POSITIVE)?;
        let p = tangential_stiffness - residual_stiffness;
        let r = tangential_stiffness - smoothness * residual_stiffness;
        let limit = tangential_stiffness / lambda * (p / r);
        Self::new(tangential_stiffness, limit / normal_load, smoothness, residual_stiffness)
    }

    fn check_shape(e0: f64, kappa: f64, e_t: f64) -> Result<(), LawError> {
        let (stiffness, residual) = (&TANGENTIAL_STIFFNESS, &RESIDUAL_STIFFNESS);
        checked(stiffness.name, stiffness.unit, e0, Bounds::POSITIVE)?;
        checked(SMOOTHNESS.name, SMOOTHNESS.unit, kappa, Bounds::from_zero_to_below(1.0))?;
        checked(residual.name, residual.unit, e_t, Bounds::from_zero_to_below(e0))?;
        Ok(())
    }

    /// Slope of the virgin curve at zero, e0 (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.tangential_stiffness
    }

    /// Coefficient of friction, μ (1).
    pub fn friction_coefficient(&self) -> f64 {
        self.friction_coefficient
    }

    /// κ (1).
    pub fn smoothness(&self) -> f64 {
        self.smoothness
    }

    /// Slope left in macro-slip, e_t (N/m).
    pub fn residual_stiffness(&self) -> f64 {
        self.residual_stiffness
    }

    /// The published constant λ (1/m) of this law under `normal_load` (N), which must be above zero.
    pub fn lambda(&self, normal_load: f64) -> f64 {
        let r = self.tangential_stiffness - self.smoothness * self.residual_stiffness;
        self.tangential_stiffness * (self.hysteretic_stiffness / r) / self.limit(normal_load)
    }

    /// Energy (J) kept in `state`: the hysteretic part's and the residual spring's.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        let stretch = state[1] - state[3];
        0.5 * (state[0] * state[0] / self.hysteretic_stiffness + self.residual_stiffness * stretch * stretch)
    }

    /// Whether a step that ends under this load and limit ends apart; a limit that underflows is none.
    fn separated(normal_load: f64, limit: f64) -> bool {
        normal_load <= 0.0 || limit == 0.0
    }

    fn start(&self, state: &[f64], inputs: Inputs, limit: f64) -> Start {
        let (force, displacement, load, origin) = (state[0], state[1], state[2], state[3]);
        let travel = inputs.displacement - displacement;
        if load <= 0.0 {
            let load_change = inputs.normal_load - load;
            let closed = inputs.normal_load / load_change;
            return Start {
                hysteretic_force: 0.0,
                kept: 0.0,
                cut: 0.0,
                travel: closed * travel,
                origin: displacement + (1.0 - closed) * travel,
                closing: Some(Closing {
                    by_displacement: closed,
                    by_start_load: travel * (closed / load_change),
                    by_end_load: -travel * (load / load_change) / load_change,
                }),
            };
        }
        let cut = if force.abs() > limit { force.signum() } else { 0.0 };
        let (hysteretic_force, kept) = if cut == 0.0 { (force, 1.0) } else { (cut * limit, 0.0) };
        Start { hysteretic_force, kept, cut, travel, origin, closing: None }
    }

    fn end(&self, start: &Start, limit: f64) -> End {
        let sign = if start.travel != 0.0 { start.travel.signum() } else { -start.hysteretic_force.signum() };
        let gap = 1.0 - sign * (start.hysteretic_force / limit);
        let delta = self.reach_stiffness * (start.travel.abs() / limit);
        let stretch = advance(gap, delta, self.curvature);
        let Stretch { drop, ratio, .. } = stretch;
        let hysteretic_force = cut_to(start.hysteretic_force + sign * limit * drop, limit);
        // Where the reach overflows, all of the path is macro-slip.
        let slipped = if delta.is_finite() {
            limit / self.reach_stiffness * dissipation(gap, &stretch)
        } else {
            start.travel.abs()
        };
        let slope = stretch.gap / (1.0 + self.curvature * stretch.gap);
        let by_start = ratio * (1.0 + self.curvature * gap) / (1.0 + self.curvature * stretch.gap);
        let reach_term = if slope == 0.0 { 0.0 } else { delta * slope };
        End {
            hysteretic_force,
            dissipated_energy: limit * slipped,
            by_travel: self.reach_stiffness * slope,
            by_start,
            by_limit: sign * ((1.0 - stretch.gap) - by_start * (1.0 - gap) - reach_term),
        }
    }

    /// Derivative of the hysteretic force at the end with respect to the normal load there, apart from
    /// its effect on the distance moved in contact.
    fn by_end_load(&self, start: &Start, end: &End) -> f64 {
        self.friction_coefficient * (end.by_limit + end.by_start * start.cut)
    }
}

impl ContactLaw for Valanis {
    fn state_len(&self) -> usize {
        4
    }

    /// See [`ContactLaw::set_state`]; the residual spring is unstressed at `displacement`.
    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        let limit = self.limit(normal_load);
        state[0] = cut_to(force, limit);
        state[1] = displacement;
        state[2] = normal_load;
        state[3] = displacement;
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let limit = self.limit(inputs.normal_load);
        next[1] = inputs.displacement;
        next[2] = inputs.normal_load;
        if Self::separated(inputs.normal_load, limit) {
            next[0] = 0.0;
            next[3] = inputs.displacement;
            return Response {
                force: 0.0,
                tangents: Tangents::default(),
                dissipated_energy: self.stored_energy(state),
                slip_state: SlipState::Separated,
            };
        }
        let start = self.start(state, inputs, limit);
        let end = self.end(&start, limit);
        next[0] = end.hysteretic_force;
        next[3] = start.origin;
        let mut cut_energy = 0.0;
        if start.cut != 0.0 {
            cut_energy =
                0.5 * (state[0].abs() - limit) * (state[0].abs() + limit) / self.hysteretic_stiffness;
        }
        let slope = end.by_travel + self.residual_stiffness;
        let (travel_by_displacement, travel_by_load) =
            start.closing.map_or((1.0, 0.0), |closing| (closing.by_displacement, closing.by_end_load));
        Response {
            force: end.hysteretic_force + self.residual_stiffness * (inputs.displacement - start.origin),
            tangents: Tangents {
                displacement: slope * travel_by_displacement,
                velocity: 0.0,
                normal_load: self.by_end_load(&start, &end) + slope * travel_by_load,
            },
            dissipated_energy: end.dissipated_energy + cut_energy,
            slip_state: SlipState::Slip,
        }
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        out.reset(4);
        out.next_by_displacement[1] = 1.0;
        out.next_by_normal_load[2] = 1.0;
        let limit = self.limit(inputs.normal_load);
        if Self::separated(inputs.normal_load, limit) {
            out.next_by_displacement[3] = 1.0;
            return;
        }
        let start = self.start(state, inputs, limit);
        let end = self.end(&start, limit);
        let slope = end.by_travel + self.residual_stiffness;
        out.next_by_normal_load[0] = self.by_end_load(&start, &end);
        // Rows of next_by_state: y, u, N, origin; columns likewise.
        if let Some(closing) = start.closing {
            let closed = closing.by_displacement;
            out.force_by_state[1] = -slope * closed;
            out.force_by_state[2] = slope * closing.by_start_load;
            out.next_by_state[1] = -end.by_travel * closed;
            out.next_by_state[2] = end.by_travel * closing.by_start_load;
            out.next_by_displacement[0] = end.by_travel * closed;
            out.next_by_normal_load[0] += end.by_travel * closing.by_end_load;
            // The origin is the displacement at the end less the distance moved in contact.
            out.next_by_state[12 + 1] = closed;
            out.next_by_state[12 + 2] = -closing.by_start_load;
            out.next_by_displacement[3] = 1.0 - closed;
            out.next_by_normal_load[3] = -closing.by_end_load;
            return;
        }
        let by_start = end.by_start * start.kept;
        out.force_by_state.copy_from_slice(&[by_start, -end.by_travel, 0.0, -self.residual_stiffness]);
        out.next_by_state[0] = by_start;
        out.next_by_state[1] = -end.by_travel;
        out.next_by_state[15] = 1.0;
        out.next_by_displacement[0] = end.by_travel;
    }

    fn limit(&self, normal_load: f64) -> f64 {
        if normal_load <= 0.0 { 0.0 } else { self.friction_coefficient * normal_load }
    }
}
