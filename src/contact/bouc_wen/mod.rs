//! Bouc's and Wen's law with the friction limit of a contact.

mod saturation;

use std::ops::Bound;

use crate::contact::error::{Bounds, LawError, checked, checked_pair};
use crate::contact::gradual::{Gradual, GradualLaw, STATE};
use crate::contact::kind::{self, LawKind, LawParameter, LawValues};
use crate::contact::{ContactLaw, Inputs, Response, SlipState, StateTangents, Tangents, cut_to};
use crate::vocabulary::{self as v, Scale};
use saturation::{Reached, Saturation};

/// Bouc and Wen's law: slip sets in as gradually as the exponent n says, and unloading may be stiffer than stick.
///
/// ```text
///        T ▲          ___───  slope e_t
///          │      _.-‾    ╱
///          │    ╱       ╱
///          │  ╱ e0     ╱  r (e0 − e_t) + e_t on reversal from saturation
///   ───────┼╱─────────╱──► u
/// ```
///
/// # Law
/// `T = y + e_t (u − origin)` with `ẏ = k u̇ {1 − |y/L|ⁿ [γ + β sgn(u̇ y)]}`, `k = e0 − e_t`, the limit `L = μ N` and
/// `β + γ = 1`, so that y saturates at the limit. On reversal from there the slope is `r k` with `r = 2β`:
/// `β = r/2`, `γ = 1 − r/2`, `β/γ = r/(2 − r)`.
///
/// Under constant normal load a step is integrated to rounding: one step equals many in the same direction, and passes
/// through zero force where the law changes its branch. The energy kept is `y²/(2k) + e_t (u − origin)²/2`; what else
/// the work is, is dissipated, and with `r ≥ 1` that is never negative.
///
/// # Varying normal load
/// A change of the load alone moves the limit and never creates a force; a limit that falls below the force cuts it,
/// and the energy difference is dissipated. Displacement and load run linearly within a step, which is split into two
/// motions, each under one load: three quarters of the distance under the load a third into the step, the rest under
/// that at its end (Radau's quadrature). A saturated contact so stays at `±μ N(t)`. A contact that lifts off moves until
/// `N = 0`, and all energy kept is dissipated; one that closes remembers nothing and moves from `N = 0` on.
///
/// # State
/// `[y, u, N, origin]`: as [`GradualLaw`].
///
/// # Parameters
/// - `tangential_stiffness` e0 (N/m), above zero;
/// - `friction_coefficient` μ (1), above zero;
/// - `sharpness` n (1), from 1 to 50: 1 is the most gradual slip, and large ones come near Jenkins' element;
/// - `unloading_ratio` r (1), from 1 (unloading is a straight line) to 2 (γ = 0; with n = 1 Valanis' law of κ = 0);
/// - `residual_stiffness` e_t (N/m), 0 ≤ e_t < e0.
///
/// # Limits of validity
/// A step must not contain a reversal. Minor loops do not close, as those of Valanis' law. No point sticks. Where the
/// load varies, the error falls with the square of the step.
///
/// # Reference
/// Y.-K. Wen, *Method for random vibration of hysteretic systems*, J. Eng. Mech. Div. ASCE 102 (1976) 249–263; bounds of
/// β and γ: S. Erlicher, N. Point, *Thermodynamic admissibility of Bouc–Wen type hysteresis models*, C. R. Mécanique 332
/// (2004) 51–57.
///
/// ```
/// use stickslip::contact::{BoucWen, ContactLaw, Inputs};
/// let law = BoucWen::new(2e6, 0.5, 1.0, 2.0, 0.0)?;
/// let (mut state, mut next) = ([0.0; 4], [0.0; 4]);
/// law.set_state(0.0, 100.0, 0.0, &mut state);
/// let inputs = Inputs { displacement: 25e-6, velocity: 0.0, normal_load: 100.0 };
/// let initial = 50.0 * (1.0 - f64::exp(-2e6 * 25e-6 / 50.0));
/// assert!((law.step(&state, inputs, &mut next).force - initial).abs() < 1e-12);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoucWen {
    gradual: Gradual,
    loading: Saturation,
    unloading: Saturation,
}

pub(super) static KIND: LawKind = LawKind {
    name: "bouc_wen",
    fmu_name: "BoucWenContact",
    summary: "Friction contact: Bouc and Wen's law",
    equations: &[
        "T = y + et (u − origin)",
        "ẏ = (e0 − et) u̇ {1 − |y/(μ N)|^n [1 − r/2 + (r/2) sgn(u̇ y)]}",
        "e0: tangential_stiffness, et: residual_stiffness, n: sharpness, r: unloading_ratio, μ: friction_coefficient, N: normal_load",
    ],
    parameters: &[
        LawParameter {
            quantity: &v::SHARPNESS,
            default: None,
            includes_min: false,
            one_slider_at: Some(f64::INFINITY),
            range: |_| (1.0, 20.0, Scale::Logarithmic),
        },
        LawParameter {
            quantity: &v::UNLOADING_RATIO,
            default: Some(1.0),
            includes_min: false,
            one_slider_at: None,
            range: |_| (1.0, 2.0, Scale::Linear),
        },
        kind::RESIDUAL_STIFFNESS,
    ],
    one_slider: false,
    refuses: |values| kind::residual_rule(values.own[2], values.tangential_stiffness),
    build: |&LawValues { tangential_stiffness, friction_coefficient, own }| {
        let law = BoucWen::new(tangential_stiffness, friction_coefficient, own[0], own[1], own[2])?;
        Ok(law.into())
    },
};

/// Radau's quadrature with two points on `[0, 1]`: node and weight of the first; the last node is 1.
const FIRST_LOAD: f64 = 1.0 / 3.0;
const FIRST_PART: f64 = 0.75;

// A step depends on the state's four numbers, then on these.
const END: usize = 4;
const END_LOAD: usize = 5;

/// A value with its derivatives by all that a step depends on.
#[derive(Debug, Clone, Copy, Default)]
struct Graded {
    value: f64,
    by: [f64; 6],
}

impl Graded {
    fn variable(value: f64, index: usize) -> Self {
        let mut by = [0.0; 6];
        by[index] = 1.0;
        Self { value, by }
    }

    /// `value` of which the derivatives are those of `terms`, each times its factor.
    fn of<const N: usize>(value: f64, terms: [(f64, &Graded); N]) -> Self {
        Self {
            value,
            by: std::array::from_fn(|i| terms.iter().map(|(factor, term)| factor * term.by[i]).sum()),
        }
    }

    fn plus(&self, factor: f64, other: &Self) -> Self {
        Self::of(self.value + factor * other.value, [(1.0, self), (factor, other)])
    }

    fn times(&self, other: &Self) -> Self {
        Self::of(self.value * other.value, [(other.value, self), (self.value, other)])
    }

    fn over(&self, other: &Self) -> Self {
        let quotient = self.value / other.value;
        Self::of(quotient, [(1.0 / other.value, self), (-quotient / other.value, other)])
    }

    fn scaled(&self, factor: f64) -> Self {
        Self::of(factor * self.value, [(factor, self)])
    }
}

/// The end of a step.
struct Outcome {
    hysteretic: Graded,
    origin: Graded,
    force: Graded,
    dissipated_energy: f64,
}

impl BoucWen {
    /// A law with stiffness `tangential_stiffness` e0 (N/m), `friction_coefficient` μ (1), `sharpness` n (1),
    /// `unloading_ratio` r (1) and `residual_stiffness` e_t (N/m).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless 0 < e0, 0 < μ, 1 ≤ n ≤ 50, 1 ≤ r ≤ 2 and 0 ≤ e_t < e0, all finite.
    pub fn new(
        tangential_stiffness: f64,
        friction_coefficient: f64,
        sharpness: f64,
        unloading_ratio: f64,
        residual_stiffness: f64,
    ) -> Result<Self, LawError> {
        let (stiffness, friction) = checked_pair(tangential_stiffness, friction_coefficient)?;
        let between = |lower, upper| Bounds { lower: Bound::Included(lower), upper: Bound::Included(upper) };
        let n = checked(v::SHARPNESS.name, v::SHARPNESS.unit, sharpness, between(1.0, 50.0))?;
        let ratio = &v::UNLOADING_RATIO;
        let r = checked(ratio.name, ratio.unit, unloading_ratio, between(1.0, 2.0))?;
        let residual = &v::RESIDUAL_STIFFNESS;
        checked(residual.name, residual.unit, residual_stiffness, Bounds::from_zero_to_below(stiffness))?;
        let gradual = Gradual {
            hysteretic_stiffness: stiffness - residual_stiffness,
            residual_stiffness,
            friction_coefficient: friction,
            asymmetry: 0.0,
        };
        Ok(Self { gradual, loading: Saturation { n, a: 1.0 }, unloading: Saturation { n, a: 1.0 - r } })
    }

    /// Coefficient of friction against motion in the direction `sign` (1).
    fn friction(&self, sign: f64) -> f64 {
        self.gradual.friction_coefficient * self.gradual.side(sign)
    }

    /// `force` (N) within the limits under `load` (N), and the energy (J) lost by cutting it.
    fn cut(&self, force: Graded, load: &Graded) -> (Graded, f64) {
        let sign = force.value.signum();
        let limit = load.scaled(sign * self.friction(sign));
        if force.value.abs() <= limit.value.abs() {
            return (force, 0.0);
        }
        let kept = |y: f64| 0.5 * y * y / self.gradual.hysteretic_stiffness;
        (limit, kept(force.value) - kept(limit.value))
    }

    /// Force (N) after the motion over `travel` (m) in the direction `sign` from `force` (N), which is within the limits,
    /// under the constant `load` (N), and the energy (J) dissipated.
    fn follow(&self, force: &Graded, travel: &Graded, sign: f64, load: &Graded) -> (Graded, f64) {
        let (limit, stiffness) = (self.friction(sign) * load.value, self.gradual.hysteretic_stiffness);
        if limit <= 0.0 {
            return (Graded::default(), 0.0);
        }
        let start = sign * force.value / limit;
        let way = stiffness * travel.value.abs() / limit;
        let (end, slope, by_start, lost) = if start < 0.0 {
            let (Reached { x, by_start, slope, lost }, rest) = self.unloading.fall(-start, way);
            if rest > 0.0 {
                let risen = self.loading.rise(0.0, rest);
                (risen.x, risen.slope, by_start * risen.by_start, lost + risen.lost)
            } else {
                (-x, slope, by_start, lost)
            }
        } else {
            let Reached { x, by_start, slope, lost } = self.loading.rise(start, way);
            (x, slope, by_start, lost)
        };
        let end = sign * end * limit;
        // The force is homogeneous of the first degree in force, way and limit.
        let by_travel = stiffness * slope;
        let by_load = (end - by_start * force.value - by_travel * travel.value) / load.value;
        let terms = [(by_start, force), (by_travel, travel), (by_load, load)];
        (Graded::of(end, terms), lost * limit * limit / stiffness)
    }

    /// The force (N) that [`BoucWen::cut`] and then [`BoucWen::follow`] give, without derivatives.
    fn followed(&self, force: f64, travel: f64, load: f64) -> f64 {
        let sign = travel.signum();
        let limit = self.friction(sign) * load;
        if limit <= 0.0 {
            return 0.0;
        }
        let start = sign * cut_to(force, self.friction(force.signum()) * load) / limit;
        let way = self.gradual.hysteretic_stiffness * travel.abs() / limit;
        let end = if start < 0.0 {
            let (Reached { x, .. }, rest) = self.unloading.fall(-start, way);
            if rest > 0.0 { self.loading.risen_to(0.0, rest) } else { -x }
        } else {
            self.loading.risen_to(start, way)
        };
        sign * end * limit
    }

    /// Hysteretic force (N) after the distance `travel` (m) from `force` (N), while the load runs linearly between
    /// `loads` (N), and the energy (J) dissipated.
    fn move_on(&self, force: Graded, travel: &Graded, loads: [&Graded; 2]) -> (Graded, f64) {
        // Without motion the derivative is that of unloading, the stiffer.
        let sign = if travel.value != 0.0 { travel.value.signum() } else { -force.value.signum() };
        let middle = loads[0].scaled(1.0 - FIRST_LOAD).plus(FIRST_LOAD, loads[1]);
        let (mut force, mut lost) = (force, 0.0);
        for (part, load) in [(FIRST_PART, &middle), (1.0 - FIRST_PART, loads[1])] {
            let (cut, by_cut) = self.cut(force, load);
            let (end, by_motion) = self.follow(&cut, &travel.scaled(part), sign, load);
            (force, lost) = (end, lost + by_cut + by_motion);
        }
        (force, lost)
    }

    fn outcome(&self, state: &[f64], inputs: Inputs) -> Outcome {
        let [force, start, start_load, origin] =
            std::array::from_fn(|index| Graded::variable(state[index], index));
        let end = Graded::variable(inputs.displacement, END);
        let end_load = Graded::variable(inputs.normal_load, END_LOAD);
        let travel = end.plus(-1.0, &start);
        // The part of the step in contact where the load crosses zero.
        let fall = start_load.plus(-1.0, &end_load);
        let none = Graded::default();
        match (start_load.value > 0.0, end_load.value > 0.0) {
            (false, false) => Outcome { hysteretic: none, origin: end, force: none, dissipated_energy: 0.0 },
            (true, false) => {
                let way = travel.times(&start_load.over(&fall));
                let (rest, lost) = self.move_on(force, &way, [&start_load, &none]);
                let stretch = start.value + way.value - origin.value;
                let kept = 0.5
                    * (rest.value * rest.value / self.gradual.hysteretic_stiffness
                        + self.gradual.residual_stiffness * stretch * stretch);
                Outcome { hysteretic: none, origin: end, force: none, dissipated_energy: lost + kept }
            }
            (false, true) => {
                let way = travel.times(&end_load.scaled(-1.0).over(&fall));
                let (hysteretic, lost) = self.move_on(none, &way, [&none, &end_load]);
                let force = hysteretic.plus(self.gradual.residual_stiffness, &way);
                Outcome { hysteretic, origin: end.plus(-1.0, &way), force, dissipated_energy: lost }
            }
            (true, true) => {
                let (hysteretic, lost) = self.move_on(force, &travel, [&start_load, &end_load]);
                let force = hysteretic.plus(self.gradual.residual_stiffness, &end.plus(-1.0, &origin));
                Outcome { hysteretic, origin, force, dissipated_energy: lost }
            }
        }
    }
}

impl GradualLaw for BoucWen {
    fn boxed(&self) -> Box<dyn GradualLaw> {
        Box::new(*self)
    }

    fn gradual(&self) -> &Gradual {
        &self.gradual
    }

    fn gradual_mut(&mut self) -> &mut Gradual {
        &mut self.gradual
    }
}

impl ContactLaw for BoucWen {
    fn state_len(&self) -> usize {
        STATE
    }

    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        self.gradual.set_state(displacement, normal_load, force, state);
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let Outcome { hysteretic, origin, force, dissipated_energy } = self.outcome(state, inputs);
        next.copy_from_slice(&[hysteretic.value, inputs.displacement, inputs.normal_load, origin.value]);
        Response {
            force: force.value,
            tangents: Tangents {
                displacement: force.by[END],
                velocity: 0.0,
                normal_load: force.by[END_LOAD],
            },
            dissipated_energy,
            slip_state: if inputs.normal_load > 0.0 { SlipState::Slip } else { SlipState::Separated },
        }
    }

    /// Without derivatives. Under a constant load the two motions of a step are one.
    fn advance(&self, state: &mut [f64], inputs: Inputs) -> f64 {
        let Inputs { displacement, normal_load, .. } = inputs;
        let (travel, start_load) = (displacement - state[1], state[2]);
        if !(normal_load > 0.0 && start_load > 0.0) {
            return self.advance_by_step(state, inputs);
        }
        state[0] = if start_load == normal_load {
            self.followed(state[0], travel, normal_load)
        } else {
            let middle = (1.0 - FIRST_LOAD) * start_load + FIRST_LOAD * normal_load;
            let first = self.followed(state[0], FIRST_PART * travel, middle);
            self.followed(first, (1.0 - FIRST_PART) * travel, normal_load)
        };
        state[1] = displacement;
        state[2] = normal_load;
        state[0] + self.gradual.residual_stiffness * (displacement - state[3])
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        let Outcome { hysteretic, origin, force, .. } = self.outcome(state, inputs);
        let n = self.state_len();
        out.reset(n);
        out.force_by_state.copy_from_slice(&force.by[..n]);
        let end = Graded::variable(inputs.displacement, END);
        let end_load = Graded::variable(inputs.normal_load, END_LOAD);
        for (row, number) in [hysteretic, end, end_load, origin].iter().enumerate() {
            out.next_by_state[row * n..(row + 1) * n].copy_from_slice(&number.by[..n]);
            out.next_by_displacement[row] = number.by[END];
            out.next_by_normal_load[row] = number.by[END_LOAD];
        }
    }

    fn limit(&self, normal_load: f64) -> f64 {
        self.gradual.limit(normal_load)
    }

    fn is_odd(&self) -> bool {
        self.gradual.asymmetry == 0.0
    }

    fn has_stick(&self) -> bool {
        false
    }
}
