//! Valanis' endochronic law in the form used for frictional joints; motion.rs: the motions of one step.

mod endochronic;
mod motion;

use motion::{BEHIND, Curve};

use crate::contact::error::{Bounds, LawError, checked};
use crate::contact::gradual::{Gradual, GradualLaw, STATE};
use crate::contact::kind::{self, LawKind, LawParameter, LawRule, LawValues};
use crate::contact::{ContactLaw, Inputs, Response, SlipState, StateTangents, Tangents, cut_to};
use crate::vocabulary::{
    FRICTION_COEFFICIENT, NORMAL_LOAD, RESIDUAL_STIFFNESS, SMOOTHNESS, Scale, TANGENTIAL_STIFFNESS,
};
use endochronic::advance;

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
/// Under constant normal load a step is integrated in closed form, so one step equals many steps in the
/// same direction. The energy kept is `y²/(2 p) + e_t (u − origin)²/2`; what the contact dissipates is
/// closed form too.
///
/// # Varying normal load
/// A change of the load alone moves the limit and never creates a force; where the limit falls below the
/// force it cuts `y`, and the energy difference is dissipated. Displacement and load run linearly within
/// a step, and `y` then follows `y' = u' f(y, N(t))`. The step is split into two motions in closed form,
/// each under one load: three quarters of the distance under the load a third into the step, the rest
/// under the load at its end. These are the weights and nodes of Radau's quadrature with two points:
///
/// - the mean load is the true one, hence the second order in the step; what grows with the square of
///   the change of load is integrated exactly too, and only the order in which the two motions follow
///   each other leaves an error of third order in a step;
/// - the last motion ends under the load at the end, so that a saturated contact stays at `±μ N(t)`
///   whatever the step's size, and dissipates the exact mean, `μ (N₀ + N₁)/2` times the distance;
/// - a limit ahead of the motion cuts at once, for the force cannot get away from it. A limit behind it,
///   which the motion may lead away from, cuts at the end of the step; the force then counts as running
///   linearly from start to end. (To twice such a limit the force is cut at once.)
///
/// The energy dissipated is that of this very path, and no part of it creates energy.
///
/// A contact that lifts off moves until the instant `N = 0`, where the force vanishes and all the energy
/// kept, that of the residual spring too, is dissipated. One that closes remembers nothing and moves from
/// the instant `N = 0`: limit and `y` then grow in proportion to the distance, which is exact.
///
/// # State
/// `[y, u, N, origin]`: hysteretic force (N), displacement (m) and normal load (N) at the end of the
/// last step, and the displacement at which the residual spring is unstressed (m).
///
/// # Parameters
/// - `tangential_stiffness` e0 (N/m), above zero: slope of the initial loading curve;
/// - `friction_coefficient` μ (1), above zero;
/// - `smoothness` κ (1), 0 ≤ κ < 1: the initial loading curve is exponential at 0 and Jenkins' at 1;
/// - `residual_stiffness` e_t (N/m), 0 ≤ e_t < e0. The integral holds for e_t < 0 as well, but a
///   separation would then release negative energy: refused.
///
/// # Limits of validity
/// A step must not contain a reversal. The law is not of Masing type, and minor loops do not close.
/// Where the limit grows manyfold within a step, after a contact has closed, and faster than `y` could
/// grow, the order in the step falls below the second, towards the first; the error is then a small
/// part of the change of the limit in a step. No point sticks: [`SlipState::Stick`] is never reported.
/// At a step without motion the tangent is that of unloading, the stiffer of the two directions.
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
    smoothness: f64,
    curve: Curve,
}

pub(in crate::contact) static KIND: LawKind = LawKind {
    name: "valanis",
    fmu_name: "ValanisContact",
    summary: "Friction contact: Valanis' law",
    equations: &[
        "Ṫ = e0 u̇ [1 + (λ/e0) s (et u − T)] / [1 + κ (λ/e0) s (et u − T)], s = sgn(u̇)",
        "λ = e0 (e0 − et) / [(e0 − κ et) μ N], so that T − et u saturates at ±μ N",
        "e0: tangential_stiffness, et: residual_stiffness, κ: smoothness, μ: friction_coefficient, N: normal_load",
    ],
    parameters: &[
        LawParameter {
            quantity: &SMOOTHNESS,
            default: None,
            includes_min: true,
            one_slider_at: Some(1.0),
            range: |_| (0.0, 0.98, Scale::Linear),
        },
        kind::RESIDUAL_STIFFNESS,
    ],
    one_slider: false,
    refuses: |values| {
        // The message of the bounds would not say why one is excluded.
        let corner = (values.own[0] == 1.0).then(|| LawRule {
            parameter: SMOOTHNESS.name,
            message:
                "`smoothness` must be below 1: at 1 the Valanis law has a corner and is Jenkins' element"
                    .to_owned(),
            help: "use law = \"jenkins\"",
        });
        corner.or_else(|| kind::residual_rule(values.own[1], values.tangential_stiffness))
    },
    build: |&LawValues { tangential_stiffness, friction_coefficient, own }| {
        let law = Valanis::new(tangential_stiffness, friction_coefficient, own[0], own[1])?;
        Ok(law.into())
    },
};

impl Valanis {
    /// A law with stiffness `tangential_stiffness` e0 (N/m), `friction_coefficient` μ (1), `smoothness`
    /// κ (1) and `residual_stiffness` e_t (N/m).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless 0 < e0, 0 < μ, 0 ≤ κ < 1 and 0 ≤ e_t < e0, all finite.
    ///
    /// ```
    /// use stickslip::contact::{ContactLaw, Valanis};
    /// // 5 N/µm, a coefficient of 0.5, smoothness 0.7, no residual stiffness.
    /// let law = Valanis::new(5e6, 0.5, 0.7, 0.0)?;
    /// assert_eq!(law.limit(100.0), 50.0);
    /// assert!(Valanis::new(5e6, 0.5, 1.0, 0.0).is_err());
    /// # Ok::<(), stickslip::contact::LawError>(())
    /// ```
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
        let fraction = hysteretic_stiffness / (tangential_stiffness * (1.0 - smoothness));
        let gradual =
            Gradual { hysteretic_stiffness, residual_stiffness, friction_coefficient, asymmetry: 0.0 };
        let curve = Curve { gradual, reach_stiffness: fraction * r, curvature: fraction * smoothness };
        Ok(Self { tangential_stiffness, smoothness, curve })
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

    /// Slope of the initial loading curve at zero, e0 (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.tangential_stiffness
    }

    /// Coefficient of friction, μ (1).
    pub fn friction_coefficient(&self) -> f64 {
        self.curve.gradual.friction_coefficient
    }

    /// κ (1).
    pub fn smoothness(&self) -> f64 {
        self.smoothness
    }

    /// Slope left in macro-slip, e_t (N/m).
    pub fn residual_stiffness(&self) -> f64 {
        self.curve.gradual.residual_stiffness
    }

    /// The published constant λ (1/m) of this law under `normal_load` (N), which must be above zero.
    pub fn lambda(&self, normal_load: f64) -> f64 {
        let r = self.tangential_stiffness - self.smoothness * self.curve.gradual.residual_stiffness;
        self.tangential_stiffness * (self.curve.gradual.hysteretic_stiffness / r) / self.limit(normal_load)
    }

    /// Energy (J) kept in `state`: the hysteretic part's and the residual spring's.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        GradualLaw::stored_energy(self, state)
    }
}

impl GradualLaw for Valanis {
    fn boxed(&self) -> Box<dyn GradualLaw> {
        Box::new(*self)
    }

    fn gradual(&self) -> &Gradual {
        &self.curve.gradual
    }

    fn gradual_mut(&mut self) -> &mut Gradual {
        &mut self.curve.gradual
    }
}

impl ContactLaw for Valanis {
    fn state_len(&self) -> usize {
        STATE
    }

    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        self.curve.gradual.set_state(displacement, normal_load, force, state);
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let limit = self.limit(inputs.normal_load);
        next[1] = inputs.displacement;
        next[2] = inputs.normal_load;
        if Curve::separated(inputs.normal_load, limit) {
            next[0] = 0.0;
            next[3] = inputs.displacement;
            return Response {
                force: 0.0,
                tangents: Tangents::default(),
                dissipated_energy: self.curve.lift_off(state, inputs),
                slip_state: SlipState::Separated,
            };
        }
        let start = Curve::start(state, inputs);
        let end = self.curve.end(&start, inputs.normal_load, limit);
        next[0] = end.hysteretic_force;
        next[3] = start.origin;
        let slope = end.by_travel + self.curve.gradual.residual_stiffness;
        let (travel_by_displacement, travel_by_load) =
            start.closing.map_or((1.0, 0.0), |closing| (closing.by_displacement, closing.by_end_load));
        Response {
            force: end.hysteretic_force
                + self.curve.gradual.residual_stiffness * (inputs.displacement - start.origin),
            tangents: Tangents {
                displacement: slope * travel_by_displacement,
                velocity: 0.0,
                normal_load: self.curve.gradual.friction_coefficient * end.by_end_limit
                    + slope * travel_by_load,
            },
            dissipated_energy: end.dissipated_energy,
            slip_state: SlipState::Slip,
        }
    }

    /// Without derivatives.
    fn advance(&self, state: &mut [f64], inputs: Inputs) -> f64 {
        let limit = self.limit(inputs.normal_load);
        let start = Curve::start(state, inputs);
        if Curve::separated(inputs.normal_load, limit) || start.closing.is_some() {
            return self.advance_by_step(state, inputs);
        }
        state[0] = self.curve.end_force(&start, inputs.normal_load, limit);
        state[1] = inputs.displacement;
        state[2] = inputs.normal_load;
        state[0] + self.curve.gradual.residual_stiffness * (inputs.displacement - state[3])
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        out.reset(4);
        out.next_by_displacement[1] = 1.0;
        out.next_by_normal_load[2] = 1.0;
        let limit = self.limit(inputs.normal_load);
        if Curve::separated(inputs.normal_load, limit) {
            out.next_by_displacement[3] = 1.0;
            return;
        }
        let start = Curve::start(state, inputs);
        let end = self.curve.end(&start, inputs.normal_load, limit);
        let slope = end.by_travel + self.curve.gradual.residual_stiffness;
        out.next_by_normal_load[0] = self.curve.gradual.friction_coefficient * end.by_end_limit;
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
        let by_start_load = self.curve.gradual.friction_coefficient * end.by_start_limit;
        let by_state = [end.by_start, -end.by_travel, by_start_load];
        out.force_by_state[..3].copy_from_slice(&by_state);
        out.force_by_state[3] = -self.curve.gradual.residual_stiffness;
        out.next_by_state[..3].copy_from_slice(&by_state);
        out.next_by_state[15] = 1.0;
        out.next_by_displacement[0] = end.by_travel;
    }

    fn is_odd(&self) -> bool {
        self.curve.gradual.asymmetry == 0.0
    }

    /// One motion, without the energy and without what the limits at its ends do, each of which costs as much.
    fn force_and_tangents(
        &self,
        state: &[f64],
        inputs: Inputs,
        next: &mut [f64],
        out: &mut StateTangents,
    ) -> Response {
        let limit = self.limit(inputs.normal_load);
        let symmetric = self.curve.gradual.asymmetry == 0.0;
        let constant =
            symmetric && state[2] == inputs.normal_load && !Curve::separated(inputs.normal_load, limit);
        let travel = inputs.displacement - state[1];
        let sign = if travel == 0.0 { -state[0].signum() } else { travel.signum() };
        let gap = 1.0 - sign * (state[0] / limit);
        // Within the limit nothing is cut.
        if !constant || !(0.0..=BEHIND).contains(&gap) {
            return self.step_and_tangents(state, inputs, next, out);
        }
        let stretch = advance(gap, self.curve.reach_stiffness * (travel.abs() / limit), self.curve.curvature);
        let end = cut_to(state[0] + sign * limit * stretch.drop, limit);
        let by_travel = self.curve.reach_stiffness * self.curve.slope(stretch.gap);
        let by_start =
            stretch.ratio * (1.0 + self.curve.curvature * gap) / (1.0 + self.curve.curvature * stretch.gap);
        out.force_by_state.clear();
        out.force_by_state.extend_from_slice(&[
            by_start,
            -by_travel,
            0.0,
            -self.curve.gradual.residual_stiffness,
        ]);
        Response {
            force: end + self.curve.gradual.residual_stiffness * (inputs.displacement - state[3]),
            tangents: Tangents {
                displacement: by_travel + self.curve.gradual.residual_stiffness,
                ..Tangents::default()
            },
            dissipated_energy: 0.0,
            slip_state: SlipState::Slip,
        }
    }

    fn has_stick(&self) -> bool {
        false
    }

    fn limit(&self, normal_load: f64) -> f64 {
        self.curve.gradual.limit(normal_load)
    }
}
