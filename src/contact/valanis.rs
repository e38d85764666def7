//! Valanis' endochronic law in the form used for frictional joints.

use super::endochronic::{Stretch, advance, dissipation, within};
use super::error::{Bounds, LawError, checked};
use super::{
    ContactLaw, GradualLaw, Inputs, JointBase, LawKind, LawParameter, LawRule, LawValues, Response,
    SlipState, StateTangents, Tangents, catalogue, cut_to,
};
use crate::vocabulary::{
    FRICTION_COEFFICIENT, NORMAL_LOAD, RESIDUAL_STIFFNESS, SMOOTHNESS, Scale, TANGENTIAL_STIFFNESS,
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
    friction_coefficient: f64,
    smoothness: f64,
    residual_stiffness: f64,
    /// p = e0 − e_t (N/m), slope of the hysteretic force on initial loading.
    hysteretic_stiffness: f64,
    /// p r/[e0 (1 − κ)] (N/m): reach δ = this × distance/limit.
    reach_stiffness: f64,
    /// b = κ p/[e0 (1 − κ)] of the endochronic equation (1).
    curvature: f64,
    /// a (1): the limit against motion in the direction ±1 is (1 ± a) μ N.
    asymmetry: f64,
}

/// The motion of a step, after re-contact: from the hysteretic force and the load at its start.
struct Start {
    /// Within the limit (N).
    hysteretic_force: f64,
    normal_load: f64,
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

/// A motion under one load.
struct Motion {
    hysteretic_force: f64,
    dissipated_energy: f64,
    by_travel: f64,
    by_start: f64,
    by_limit: f64,
    /// In a motion that a limit ahead did not cut, relative to the limit: gap at the start, reach,
    /// and the end.
    gap: f64,
    delta: f64,
    stretch: Stretch,
}

/// The hysteretic force at the end of a step, with derivatives with respect to the distance moved, the
/// hysteretic force at the start, and the limits at both ends.
struct End {
    hysteretic_force: f64,
    dissipated_energy: f64,
    by_travel: f64,
    by_start: f64,
    by_start_limit: f64,
    by_end_limit: f64,
}

/// Radau's quadrature with two points on `[0, 1]`: the first weight and node; the last node is 1.
const FIRST_FRACTION: f64 = 0.75;
const FIRST_LOAD: f64 = 1.0 / 3.0;

/// A limit behind the motion that falls to less than a half of the force is no small change within a
/// step: it cuts the force to this many limits before the motion, which keeps the gap below 3.
const BEHIND: f64 = 2.0;

pub(super) static KIND: LawKind = LawKind {
    name: "valanis",
    fmu_name: "ValanisContact",
    summary: "Friction contact: Valanis' law",
    parameters: &[
        LawParameter {
            quantity: &SMOOTHNESS,
            default: None,
            includes_min: true,
            range: |_| (0.0, 0.98, Scale::Linear),
        },
        catalogue::RESIDUAL_STIFFNESS,
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
        corner.or_else(|| catalogue::residual_rule(values.own[1], values.tangential_stiffness))
    },
    build: |&LawValues { tangential_stiffness, friction_coefficient, own }| {
        let law = Valanis::new(tangential_stiffness, friction_coefficient, own[0], own[1])?;
        Ok(JointBase::Gradual(Box::new(law)))
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
        Ok(Self {
            tangential_stiffness,
            friction_coefficient,
            smoothness,
            residual_stiffness,
            hysteretic_stiffness,
            reach_stiffness: fraction * r,
            curvature: fraction * smoothness,
            asymmetry: 0.0,
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

    /// Slope of the initial loading curve at zero, e0 (N/m).
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

    /// The limit against motion in the direction `sign`, over μ N.
    fn side(&self, sign: f64) -> f64 {
        1.0 + sign * self.asymmetry
    }

    /// Energy (J) kept in `state`: the hysteretic part's and the residual spring's.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        GradualLaw::stored_energy(self, state)
    }

    /// Whether a step that ends under this load and limit ends apart; a limit that underflows is none.
    fn separated(normal_load: f64, limit: f64) -> bool {
        normal_load <= 0.0 || limit == 0.0
    }

    fn start(state: &[f64], inputs: Inputs) -> Start {
        let (hysteretic_force, displacement, normal_load, origin) = (state[0], state[1], state[2], state[3]);
        let travel = inputs.displacement - displacement;
        if normal_load > 0.0 {
            return Start { hysteretic_force, normal_load, travel, origin, closing: None };
        }
        let load_change = inputs.normal_load - normal_load;
        let closed = inputs.normal_load / load_change;
        Start {
            hysteretic_force: 0.0,
            normal_load: 0.0,
            travel: closed * travel,
            origin: displacement + (1.0 - closed) * travel,
            closing: Some(Closing {
                by_displacement: closed,
                by_start_load: travel * (closed / load_change),
                by_end_load: -travel * (normal_load / load_change) / load_change,
            }),
        }
    }

    /// Moves from `force` (N) over `distance` (m, not negative) in the direction `sign` under one `limit`
    /// (N), which may lie below the force: ahead it cuts, behind it is mostly left to the end of the step.
    fn motion(&self, force: f64, sign: f64, distance: f64, limit: f64) -> Motion {
        let along = sign * force;
        let behind = BEHIND * (self.side(-sign) / self.side(sign));
        let (cut, start) = if along > limit {
            (true, sign * limit)
        } else if along < -behind * limit {
            (true, -sign * behind * limit)
        } else {
            (false, force)
        };
        let gap = 1.0 - sign * (start / limit);
        let delta = self.reach_stiffness * (distance / limit);
        let stretch = advance(gap, delta, self.curvature);
        let end = start + sign * limit * stretch.drop;
        // Where the reach overflows, all of the path is macro-slip.
        let slipped = if delta.is_finite() {
            limit / self.reach_stiffness * dissipation(gap, &stretch)
        } else {
            distance + self.lost_by_cut(start, sign * limit) / limit
        };
        let by_start = stretch.ratio * (1.0 + self.curvature * gap) / (1.0 + self.curvature * stretch.gap);
        let by_limit = self.by_limit(sign, gap, stretch.gap, by_start, delta);
        Motion {
            // Rounding may pass the limit ahead.
            hysteretic_force: if sign * end > limit { sign * limit } else { end },
            dissipated_energy: limit * slipped + self.lost_by_cut(force, start),
            by_travel: self.reach_stiffness * self.slope(stretch.gap),
            by_start: if cut { 0.0 } else { by_start },
            by_limit: if cut { by_limit + by_start * (start / limit) } else { by_limit },
            gap,
            delta,
            stretch,
        }
    }

    /// Slope of the hysteretic force over the distance, relative to the reach stiffness.
    fn slope(&self, gap: f64) -> f64 {
        gap / (1.0 + self.curvature * gap)
    }

    /// Derivative of the force after a motion with respect to its limit, at a given start.
    fn by_limit(&self, sign: f64, gap: f64, end_gap: f64, by_start: f64, delta: f64) -> f64 {
        let slope = self.slope(end_gap);
        let reach_term = if slope == 0.0 { 0.0 } else { delta * slope };
        sign * ((1.0 - end_gap) - by_start * (1.0 - gap) - reach_term)
    }

    /// Energy (J) lost where the hysteretic force is cut to `cut`.
    fn lost_by_cut(&self, force: f64, cut: f64) -> f64 {
        if force == cut {
            return 0.0;
        }
        0.5 * (force.abs() - cut.abs()) * (force.abs() + cut.abs()) / self.hysteretic_stiffness
    }

    fn direction(start: &Start) -> f64 {
        if start.travel == 0.0 { -start.hysteretic_force.signum() } else { start.travel.signum() }
    }

    fn end(&self, start: &Start, end_load: f64, limit: f64) -> End {
        let (sign, distance) = (Self::direction(start), start.travel.abs());
        let (ahead, behind) = (self.side(sign), self.side(-sign));
        let (limit, limit_behind) = (ahead * limit, behind * limit);
        let mut end = if start.closing.is_some() {
            self.growth(sign, distance, limit)
        } else if start.normal_load == end_load {
            self.one_motion(start.hysteretic_force, sign, distance, limit)
        } else {
            let first = ahead * self.limit(start.normal_load + FIRST_LOAD * (end_load - start.normal_load));
            self.two_motions(start.hysteretic_force, sign, distance, [first, limit])
        };
        // A limit behind the motion that falls faster than the force takes it along: the mean counts.
        let cut = if sign * end.hysteretic_force < -limit_behind {
            -sign * limit_behind
        } else {
            cut_to(end.hysteretic_force, limit.max(limit_behind))
        };
        end.by_start_limit *= ahead;
        end.by_end_limit *= ahead;
        if cut != end.hysteretic_force {
            let (first, last) = (start.hysteretic_force.abs(), cut.abs());
            let lost = (first - last) / self.hysteretic_stiffness - distance;
            // NaN stays, which `max` would not keep.
            let lost = if lost < 0.0 { 0.0 } else { lost };
            end = End {
                hysteretic_force: cut,
                dissipated_energy: 0.5 * (first + last) * lost,
                by_travel: 0.0,
                by_start: 0.0,
                by_start_limit: 0.0,
                by_end_limit: -sign * behind,
            };
        }
        end
    }

    /// Under constant load both motions of a step are one; its derivatives still distinguish their limits.
    fn one_motion(&self, force: f64, sign: f64, distance: f64, limit: f64) -> End {
        let whole = self.motion(force, sign, distance, limit);
        let (delta, end_gap) = (whole.delta, whole.stretch.gap);
        let (gap, left) = within(whole.gap, delta, self.curvature, &whole.stretch, FIRST_FRACTION);
        let last_delta = (1.0 - FIRST_FRACTION) * delta;
        let by_start = left * (1.0 + self.curvature * gap) / (1.0 + self.curvature * end_gap);
        let last = self.by_limit(sign, gap, end_gap, by_start, last_delta);
        let first = whole.by_limit - last;
        End {
            hysteretic_force: whole.hysteretic_force,
            dissipated_energy: whole.dissipated_energy,
            by_travel: whole.by_travel,
            by_start: whole.by_start,
            by_start_limit: (1.0 - FIRST_LOAD) * first,
            by_end_limit: last + FIRST_LOAD * first,
        }
    }

    /// Motion since the contact closed. The limit grows from zero in proportion to the distance, and so
    /// does the force: their ratio `d` is the root of `d (1 + b (1 − d)) = ρ (1 − d)`.
    fn growth(&self, sign: f64, distance: f64, limit: f64) -> End {
        let (b, rho) = (self.curvature, self.reach_stiffness * (distance / limit));
        let root = (1.0 + 2.0 * (b + rho)).sqrt().hypot(b - rho);
        // Where ρ overflows the contact is saturated.
        let saturated = rho == f64::INFINITY;
        let ratio = if saturated { 1.0 } else { 2.0 * rho / (1.0 + b + rho + root) };
        let by_rho = if saturated { 0.0 } else { (1.0 - ratio) / root };
        let reach_term = if saturated { 0.0 } else { rho * by_rho };
        End {
            hysteretic_force: sign * limit * ratio,
            dissipated_energy: 0.5 * limit * ratio * distance * (ratio / (1.0 + b * (1.0 - ratio))),
            by_travel: self.reach_stiffness * by_rho,
            by_start: 0.0,
            by_start_limit: 0.0,
            by_end_limit: sign * (ratio - reach_term),
        }
    }

    fn two_motions(&self, force: f64, sign: f64, distance: f64, limits: [f64; 2]) -> End {
        let first = self.motion(force, sign, FIRST_FRACTION * distance, limits[0]);
        let last = self.motion(first.hysteretic_force, sign, (1.0 - FIRST_FRACTION) * distance, limits[1]);
        let by_first_limit = last.by_start * first.by_limit;
        End {
            hysteretic_force: last.hysteretic_force,
            dissipated_energy: first.dissipated_energy + last.dissipated_energy,
            by_travel: FIRST_FRACTION * last.by_start * first.by_travel
                + (1.0 - FIRST_FRACTION) * last.by_travel,
            by_start: last.by_start * first.by_start,
            by_start_limit: (1.0 - FIRST_LOAD) * by_first_limit,
            by_end_limit: last.by_limit + FIRST_LOAD * by_first_limit,
        }
    }

    /// Energy (J) dissipated in a step that ends apart: that of the motion up to the instant `N = 0`, the
    /// last part of which is without force, and all that is kept there.
    fn lift_off(&self, state: &[f64], inputs: Inputs) -> f64 {
        let [force, displacement, normal_load, origin] = [state[0], state[1], state[2], state[3]];
        let first = self.limit((1.0 - FIRST_LOAD) * normal_load);
        if first == 0.0 {
            return self.stored_energy(state);
        }
        let in_contact = normal_load / (normal_load - inputs.normal_load.min(0.0));
        let travel = in_contact * (inputs.displacement - displacement);
        let start = Start { hysteretic_force: force, normal_load, travel, origin, closing: None };
        let sign = Self::direction(&start);
        let moved = self.motion(force, sign, FIRST_FRACTION * travel.abs(), self.side(sign) * first);
        let stretch = displacement + travel - origin;
        let hysteretic = moved.hysteretic_force * moved.hysteretic_force / self.hysteretic_stiffness;
        moved.dissipated_energy + 0.5 * (hysteretic + self.residual_stiffness * stretch * stretch)
    }
}

impl GradualLaw for Valanis {
    fn boxed(&self) -> Box<dyn GradualLaw> {
        Box::new(*self)
    }

    fn with_asymmetry(&self, asymmetry: f64) -> Box<dyn GradualLaw> {
        Box::new(Self { asymmetry, ..*self })
    }

    fn asymmetry(&self) -> f64 {
        self.asymmetry
    }

    fn hysteretic_stiffness(&self) -> f64 {
        self.hysteretic_stiffness
    }

    fn residual_stiffness(&self) -> f64 {
        self.residual_stiffness
    }
}

impl ContactLaw for Valanis {
    fn state_len(&self) -> usize {
        4
    }

    /// See [`ContactLaw::set_state`]; the residual spring is unstressed at `displacement`.
    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        let limit = self.limit(normal_load);
        state[0] = cut_to(force, self.side(force.signum()) * limit);
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
                dissipated_energy: self.lift_off(state, inputs),
                slip_state: SlipState::Separated,
            };
        }
        let start = Self::start(state, inputs);
        let end = self.end(&start, inputs.normal_load, limit);
        next[0] = end.hysteretic_force;
        next[3] = start.origin;
        let slope = end.by_travel + self.residual_stiffness;
        let (travel_by_displacement, travel_by_load) =
            start.closing.map_or((1.0, 0.0), |closing| (closing.by_displacement, closing.by_end_load));
        Response {
            force: end.hysteretic_force + self.residual_stiffness * (inputs.displacement - start.origin),
            tangents: Tangents {
                displacement: slope * travel_by_displacement,
                velocity: 0.0,
                normal_load: self.friction_coefficient * end.by_end_limit + slope * travel_by_load,
            },
            dissipated_energy: end.dissipated_energy,
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
        let start = Self::start(state, inputs);
        let end = self.end(&start, inputs.normal_load, limit);
        let slope = end.by_travel + self.residual_stiffness;
        out.next_by_normal_load[0] = self.friction_coefficient * end.by_end_limit;
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
        let by_start_load = self.friction_coefficient * end.by_start_limit;
        let by_state = [end.by_start, -end.by_travel, by_start_load];
        out.force_by_state[..3].copy_from_slice(&by_state);
        out.force_by_state[3] = -self.residual_stiffness;
        out.next_by_state[..3].copy_from_slice(&by_state);
        out.next_by_state[15] = 1.0;
        out.next_by_displacement[0] = end.by_travel;
    }

    fn is_odd(&self) -> bool {
        self.asymmetry == 0.0
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
        let symmetric = self.asymmetry == 0.0;
        let constant =
            symmetric && state[2] == inputs.normal_load && !Self::separated(inputs.normal_load, limit);
        let travel = inputs.displacement - state[1];
        let sign = if travel == 0.0 { -state[0].signum() } else { travel.signum() };
        let gap = 1.0 - sign * (state[0] / limit);
        // Within the limit nothing is cut.
        if !constant || !(0.0..=BEHIND).contains(&gap) {
            return self.step_and_tangents(state, inputs, next, out);
        }
        let stretch = advance(gap, self.reach_stiffness * (travel.abs() / limit), self.curvature);
        let end = cut_to(state[0] + sign * limit * stretch.drop, limit);
        let by_travel = self.reach_stiffness * self.slope(stretch.gap);
        let by_start = stretch.ratio * (1.0 + self.curvature * gap) / (1.0 + self.curvature * stretch.gap);
        out.force_by_state.clear();
        out.force_by_state.extend_from_slice(&[by_start, -by_travel, 0.0, -self.residual_stiffness]);
        Response {
            force: end + self.residual_stiffness * (inputs.displacement - state[3]),
            tangents: Tangents { displacement: by_travel + self.residual_stiffness, ..Tangents::default() },
            dissipated_energy: 0.0,
            slip_state: SlipState::Slip,
        }
    }

    fn has_stick(&self) -> bool {
        false
    }

    fn limit(&self, normal_load: f64) -> f64 {
        if normal_load <= 0.0 { 0.0 } else { self.friction_coefficient * normal_load }
    }
}
