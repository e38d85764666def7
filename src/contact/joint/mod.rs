//! A contact with the physical effects that act in it.

mod base;
mod changes;
mod end;
mod jump;
mod look;
mod play;
mod sliders;
mod tangents;

use super::element::Element;
use super::error::{Bounds, LawError, checked};
use super::kind::{BaseLaw, JointBase};
use super::{ContactLaw, Inputs, Jump, ParallelSliders, Response, Slider, SlipState, StateTangents};
use crate::vocabulary::{self as v, Quantity};
use base::Base;
pub use changes::JointChanges;
use end::End;
use look::Look;
use sliders::Sliders;
use std::ops::Bound;

/// A base law with the changes that effects make of it.
///
/// ```text
///          play ±g        ┌── base law, limit · m ──┐
///   u ──────]  [──── w ───┼── spring e_t w + k3 w³ ─┼─── ground
///                         └── damper c v ───────────┘
/// ```
///
/// # Law
/// With the displacement w behind the play, the velocity v and the distance slipped s,
/// `T = T_base(w; limit · m) + e_t w + k3 w³ + c v`, and the factor of the limit is
/// `m = (1 + δ exp(−|v|/v_s)) (1 + w s) (1 ± a)`; wear leaves a millionth of the limit at the least.
///
/// **Play.** `w = u − x` with `−g ≤ x ≤ g`: the force is above zero only at `x = g`, below only at `x = −g`,
/// and zero in between, where w rests. The damper acts while the play is closed, and never pulls the play open
/// ends together: with play the force keeps the sign of the spring and friction force behind it.
///
/// **Micro-slip.** On Jenkins' element the spread σ puts [`MICRO_SLIDERS`] equal springs in its place, whose
/// yield displacements are spread evenly over `(1 ± σ) μN/k`; stiffness and limit of the whole stay.
/// Between an even distribution and so many sliders the force differs by at most `σ μN/(4 n²)` on the loading
/// curve and twice that after a reversal: 0.02 % and 0.03 % of the limit. Motions below the
/// first slider's yield stick.
///
/// **Asymmetry.** The limit is `(1 + a)` times as large against positive slip and `(1 − a)` against negative. A
/// reversal is elastic: each direction only has its own limit to reach.
///
/// **Wear.** s is the mean distance the sliders have slipped since the state was set or
/// [`ContactLaw::restart`]ed; of a gradual law it is the displacement less the elastic part of the force.
///
/// **Separation.** At `N ≤ 0` friction is zero and remembers nothing. Spring and damper stand beside the
/// contact and go on acting.
///
/// Displacement and load run linearly within a step, and the step of the sliders is exact under a constant factor
/// m, and with wear where the motion slips one way.
///
/// # State
/// `[side, s, T_d]` and the state of the base law: which end of the play carries force (−1, 0, 1; zero without
/// play), distance slipped (m), damper force (N).
///
/// # Parameters
/// Those of the base, and [`JointChanges`], of which what concerns the normal load is left to the caller
/// ([`JointChanges::normal_load`]). Springs are unstressed at displacement zero.
///
/// # Limits of validity
/// A step must not contain a reversal. Behind a flexibility in series v is the velocity in front of it where there is
/// weakening, for the damper too: where play closes, such a damper may push it open again. The play closes without
/// impact. A softening spring (k3 < 0) must not outweigh the rest within the play's crossing. With c < 0 or k3 < 0 the law
/// is not passive.
///
/// # Reference
/// Play and stop operators in series and parallel: Visintin (1994), *Differential Models of Hysteresis*,
/// Springer, ch. III. Limit against velocity: Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), Automatica 30,
/// 1083–1138. Distributed sliders: Iwan (1966), J. Appl. Mech. 33, 893–900.
///
/// ```
/// use stickslip::contact::{ContactLaw, Inputs, Jenkins, Joint, JointChanges};
/// let changes = JointChanges { half_gap: 10e-6, residual_stiffness: 1e5, ..JointChanges::default() };
/// let law = Joint::new(Jenkins::new(2e6, 0.5)?, changes)?;
/// let mut state = vec![0.0; law.state_len()];
/// law.set_state(0.0, 100.0, 0.0, &mut state);
/// let mut force = |displacement| law.advance(&mut state, Inputs { displacement, velocity: 0.0, normal_load: 100.0 });
/// assert_eq!(force(8e-6), 0.0);
/// assert!((force(110e-6) - (50.0 + 10.0)).abs() < 1e-9);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Joint {
    base: Base,
    changes: JointChanges,
    /// Energy is neither made by the damper nor by anything else.
    passive_damper: bool,
}

/// Number of sliders that stand for an even distribution of yield displacements. A response near a resonance of three
/// times its frequency shows each of them.
pub const MICRO_SLIDERS: usize = 40;

// What comes before the state of the base law.
const SIDE: usize = 0;
const SLIP: usize = 1;
const DAMPER: usize = 2;
const BASE: usize = 3;

/// What wear leaves of the limit at the least (1).
const WORN_OUT: f64 = 1e-6;

impl Joint {
    /// `base` with `changes`.
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] where a change is not finite or outside its bounds (0 ≤ σ ≤ 1, −1 < a < 1, −1 < δ,
    /// 0 < v_s, 0 ≤ e_t, 0 ≤ g), [`LawError::Combination`] for a spread on a law that slips gradually by itself.
    pub fn new(base: impl Into<JointBase>, changes: JointChanges) -> Result<Self, LawError> {
        let sliders = if changes.spread == 0.0 { 1 } else { MICRO_SLIDERS };
        Self::with_sliders(base.into(), changes, sliders)
    }

    /// As [`Joint::new`], with so many sliders (at least one) in place of Jenkins' whatever the spread: the
    /// state then has the same length for all parameters.
    pub(crate) fn with_sliders(
        base: JointBase,
        changes: JointChanges,
        sliders: usize,
    ) -> Result<Self, LawError> {
        check(&changes)?;
        let spread = changes.spread;
        let base = match base.0 {
            BaseLaw::Slider(element) => {
                Base::Sliders(Sliders::new(spread_out(&element, spread, sliders)?, changes.asymmetry))
            }
            _ if spread > 0.0 => return Err(LawError::Combination { parameter: v::SPREAD.name }),
            BaseLaw::Sliders(sliders) => Base::Sliders(Sliders::new(sliders, changes.asymmetry)),
            BaseLaw::Gradual(law) => Base::Gradual(law.with_asymmetry(changes.asymmetry)),
        };
        Ok(Self { base, changes, passive_damper: changes.damping >= 0.0 })
    }

    /// What is changed.
    pub fn changes(&self) -> &JointChanges {
        &self.changes
    }

    /// Energy (J) kept in the springs in `state`.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        let w = self.base.before(&state[BASE..]).0;
        let JointChanges { residual_stiffness, cubic_stiffness, .. } = self.changes;
        self.base.stored_energy(&state[BASE..])
            + 0.5 * residual_stiffness * w * w
            + 0.25 * cubic_stiffness * (w * w) * (w * w)
    }

    /// Distance slipped (m) in `state`, since it was set or restarted; counted where there is wear alone.
    pub fn slip_distance(&self, state: &[f64]) -> f64 {
        state[SLIP]
    }

    /// Whether there is a spring beside the law.
    fn has_spring(&self) -> bool {
        self.changes.residual_stiffness != 0.0 || self.changes.cubic_stiffness != 0.0
    }

    /// Force (N) of the springs beside the law, and slope (N/m).
    #[inline]
    fn spring(&self, w: f64) -> (f64, f64) {
        let (linear, cubic) = (self.changes.residual_stiffness, self.changes.cubic_stiffness * w * w);
        ((linear + cubic) * w, linear + 3.0 * cubic)
    }

    /// Factor of the limit at a velocity (m/s), and its derivative (s/m).
    #[inline]
    fn speed_factor(&self, velocity: f64) -> (f64, f64) {
        match self.changes.weakening {
            None => (1.0, 0.0),
            Some((excess, scale)) => {
                let excess = excess * (-velocity.abs() / scale).exp();
                let sign = if velocity == 0.0 { 0.0 } else { velocity.signum() };
                (1.0 + excess, -sign * excess / scale)
            }
        }
    }

    /// Factor of the limit after the distance `slip` (m), and its derivative (1/m).
    #[inline]
    fn wear_factor(&self, slip: f64) -> (f64, f64) {
        let factor = 1.0 + self.changes.wear * slip;
        if factor < WORN_OUT { (WORN_OUT, 0.0) } else { (factor, self.changes.wear) }
    }

    /// Damper force (N) at an end at which springs and friction carry `force` (N), and whether it is the damper
    /// that gives it: with play it cannot pull.
    #[inline]
    fn damper(&self, end: &End, force: f64, velocity: f64) -> (f64, bool) {
        if self.changes.damping == 0.0 || !end.follows {
            return (0.0, false);
        }
        let damper = self.changes.damping * velocity;
        if end.side != 0.0 && (force + damper) * end.side < 0.0 { (-force, false) } else { (damper, true) }
    }

    fn store(state: &mut [f64], end: &End, damper: f64) {
        state[SIDE] = end.side;
        state[SLIP] = end.slip;
        state[DAMPER] = damper;
    }

    /// What a step gives but the next state, and the damper's force (N) in it.
    fn response(&self, state: &[f64], inputs: Inputs, end: &End, look: &Look) -> (Response, f64) {
        let (spring, _) = self.spring(end.displacement);
        let (damper, _) = self.damper(end, look.force + spring, inputs.velocity);
        let travel = end.displacement - self.base.before(&state[BASE..]).0;
        let response = Response {
            force: if end.follows { look.force + spring + damper } else { 0.0 },
            tangents: self.tangents(inputs, end, look),
            dissipated_energy: look.dissipated_energy + self.damper_energy(state[DAMPER], damper, travel),
            slip_state: Self::slip_state(inputs, end, look),
        };
        (response, damper)
    }

    fn slip_state(inputs: Inputs, end: &End, look: &Look) -> SlipState {
        if inputs.normal_load <= 0.0 {
            SlipState::Separated
        } else if look.slips && (end.follows || look.path.length > 0.0) {
            SlipState::Slip
        } else {
            SlipState::Stick
        }
    }

    /// Energy (J) the damper takes in a step.
    fn damper_energy(&self, before: f64, after: f64, travel: f64) -> f64 {
        let energy = 0.5 * (before + after) * travel;
        // Velocities that do not belong to the displacements must not make energy.
        if self.passive_damper && energy < 0.0 { 0.0 } else { energy }
    }
}

impl ContactLaw for Joint {
    fn state_len(&self) -> usize {
        BASE + self.base.state_len()
    }

    /// See [`ContactLaw::set_state`]; the springs beside the law carry what they do at `displacement`, the law the rest.
    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        let load = normal_load * self.speed_factor(0.0).0;
        state[..BASE].fill(0.0);
        let missing = force - self.spring(displacement).0;
        let carried = self.base.set_state(displacement, load, missing, &mut state[BASE..]);
        // Force or springs beyond the limit have taken up the play.
        let loaded = if force == 0.0 { carried - missing } else { force };
        if self.changes.half_gap > 0.0 && loaded != 0.0 {
            let side = loaded.signum();
            let w = displacement - side * self.changes.half_gap;
            self.base.set_state(w, load, force - self.spring(w).0, &mut state[BASE..]);
            state[SIDE] = side;
        }
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let end = self.end(state, inputs);
        let look = self.base.step(&state[BASE..], end.displacement, end.load, &mut next[BASE..]);
        let (response, damper) = self.response(state, inputs, &end, &look);
        Self::store(next, &end, damper);
        response
    }

    fn advance(&self, state: &mut [f64], inputs: Inputs) -> f64 {
        let end = self.end(state, inputs);
        let force = self.base.advance(&mut state[BASE..], end.displacement, end.load)
            + self.spring(end.displacement).0;
        let (damper, _) = self.damper(&end, force, inputs.velocity);
        Self::store(state, &end, damper);
        if end.follows { force + damper } else { 0.0 }
    }

    fn restart(&self, state: &mut [f64]) {
        let worn = self.wear_factor(state[SLIP]).0;
        self.base.scale_load(&mut state[BASE..], 1.0 / worn);
        state[SLIP] = 0.0;
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        self.write_state_tangents(state, inputs, out);
    }

    /// Without the next state, whose derivatives grow with the square of the sliders.
    fn force_and_tangents(
        &self,
        state: &[f64],
        inputs: Inputs,
        next: &mut [f64],
        out: &mut StateTangents,
    ) -> Response {
        let (end, base) = (self.end(state, inputs), &state[BASE..]);
        let sliders = match &self.base {
            Base::Sliders(sliders) if sliders.stay_closed(base, end.load) => sliders,
            _ => return self.step_and_tangents(state, inputs, next, out),
        };
        let look = sliders.look(base, end.displacement, end.load);
        let own = |column: usize| match column.checked_sub(BASE) {
            Some(place) => sliders.by_place(place, base, end.displacement, end.load),
            None => (0.0, 0.0),
        };
        self.write_force_by_state(state.len(), inputs, (&end, &look), own, &mut out.force_by_state);
        self.response(state, inputs, &end, &look).0
    }

    fn limit(&self, normal_load: f64) -> f64 {
        let weakening = self.changes.weakening.map_or(0.0, |(excess, _)| excess.max(0.0));
        self.base.limit(normal_load) * (1.0 + weakening)
    }

    fn is_odd(&self) -> bool {
        self.changes.asymmetry == 0.0
    }

    fn has_stick(&self) -> bool {
        matches!(self.base, Base::Sliders(_))
    }

    fn limit_moves(&self) -> bool {
        self.changes.weakening.is_some() || self.changes.wear != 0.0
    }

    fn limit_follows_velocity(&self) -> bool {
        self.changes.weakening.is_some()
    }

    fn jump(&self, state: &[f64], inputs: Inputs) -> Option<Jump> {
        self.jump_on_the_way(state, inputs)
    }

    fn sliders(&self, normal_load: f64, out: &mut Vec<Slider>) -> bool {
        self.sliders_and_damper(normal_load, out) == Some(0.0)
    }

    fn sliders_and_damper(&self, normal_load: f64, out: &mut Vec<Slider>) -> Option<f64> {
        out.clear();
        let JointChanges { residual_stiffness, half_gap, .. } = self.changes;
        // With play the damper acts in turns only.
        let damping = if half_gap == 0.0 { self.changes.damping } else { 0.0 };
        let plain = JointChanges {
            spread: self.changes.spread,
            asymmetry: self.changes.asymmetry,
            load_gain: self.changes.load_gain,
            normal_cubic_stiffness: self.changes.normal_cubic_stiffness,
            impact_damping: self.changes.impact_damping,
            residual_stiffness,
            half_gap,
            damping,
            ..JointChanges::default()
        };
        let Base::Sliders(sliders) = &self.base else { return None };
        // Many springs behind one play are no springs with a play each.
        let together = half_gap > 0.0 && (sliders.len() > 1 || residual_stiffness != 0.0);
        if plain != self.changes || together {
            return None;
        }
        if normal_load > 0.0 {
            sliders.pieces(normal_load, half_gap, out);
        }
        if residual_stiffness != 0.0 {
            out.push(Slider::linear(residual_stiffness));
        }
        Some(damping)
    }
}

/// `one` as sliders of equal stiffness whose yield displacements are spread evenly over `1 ± spread` times its own.
fn spread_out(one: &Element, spread: f64, count: usize) -> Result<ParallelSliders, LawError> {
    let fraction = 1.0 / count as f64;
    let slider = |index: usize| {
        let place = (2 * index + 1) as f64 * fraction - 1.0;
        (one.stiffness * fraction, one.friction * fraction * (1.0 + spread * place))
    };
    ParallelSliders::new(&(0..count).map(slider).collect::<Vec<_>>())
}

fn check(changes: &JointChanges) -> Result<(), LawError> {
    let legal = |quantity: &Quantity, value| {
        let end = |end: Option<f64>| match end {
            None => Bound::Unbounded,
            Some(end) if quantity.open => Bound::Excluded(end),
            Some(end) => Bound::Included(end),
        };
        let bounds = Bounds { lower: end(quantity.min), upper: end(quantity.max) };
        checked(quantity.name, quantity.unit, value, bounds).map(|_| ())
    };
    legal(&v::SPREAD, changes.spread)?;
    legal(&v::RESIDUAL_STIFFNESS, changes.residual_stiffness)?;
    legal(&v::CONTACT_DAMPING, changes.damping)?;
    legal(&v::CUBIC_STIFFNESS, changes.cubic_stiffness)?;
    legal(&v::RATE, changes.wear)?;
    legal(&v::ASYMMETRY, changes.asymmetry)?;
    legal(&v::HALF_GAP, changes.half_gap)?;
    if let Some((excess, scale)) = changes.weakening {
        legal(&v::WEAKENING, excess)?;
        legal(&v::WEAKENING_VELOCITY, scale)?;
    }
    Ok(())
}
