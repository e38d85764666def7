//! A contact in two directions at once: friction under the normal force that the normal motion makes.
//!
//! normal.rs: the normal direction; way.rs: the way of a step and the instant at which the bodies part or meet;
//! carried.rs: derivatives carried over that instant.

mod carried;
mod normal;
mod way;

use std::sync::Arc;

use super::{ContactLaw, Response, SlipState, StateTangents};
pub(super) use normal::polynomial;
pub use normal::{NormalDirection, NormalLaw};
pub use way::SlipSlapInputs;
use way::{MOTION, Piece, Way};

/// A contact that slips along ξ and slaps along η.
///
/// ```text
///   ξ ──► law of friction, limit μ N_c ──► S
///                      ▲
///   η ──► N_el(δ0 − η) (1 − λ η̇)₊ = N_c ──► N = N0 − N_c
/// ```
///
/// # Law
/// The tangential force S is that of any [`ContactLaw`] under the normal load N_c that [`NormalDirection`] gives. Both
/// forces are restoring, and `S dξ + N dη` is what the contact takes from the structure; the preload N0, which the
/// structure carries at rest, is taken off. In stick a change of N_c creates no tangential force; where the bodies part
/// (`N_c = 0`) the law forgets, and the next touch starts without force.
///
/// # Step
/// Displacements and rates run linearly from the end of the last step. A step in which the bodies part or meet is
/// divided there, so that friction ends or begins at that very instant, N_c = 0. Within each part the law of friction
/// takes N_c as running linearly between its exact values at both ends: the limit at the end of a step is exact, N too,
/// and what lies between differs by the curvature of N_c. So forces and the energy of friction converge with order
/// two in the step; where N_c is linear in the step (linear law, no damping), a piecewise linear law of friction is
/// exact. The energy of impacts is `∫ (N_c − N_el) dδ` along the step, by Gauss' quadrature between the corners of the
/// integrand: with [`NormalDirection::stored_energy`] it closes `∫ (N_c − N0) dδ` to round-off.
///
/// # State
/// `[ξ, η, ξ̇, η̇]` at the end of the last step, then the memory of the law of friction.
///
/// # Limits of validity
/// Those of both laws. Where slip sets in gradually or by many sliders, a step falls behind order two, towards one, after
/// the bodies have met, where the limit grows manyfold in a step. A step must not contain a reversal of ξ. Bodies that
/// meet and part in one step do not touch.
///
/// # Reference
/// Beam with a pin that slips and slaps on its support: tangential and normal contact under dual-mode excitation.
///
/// ```
/// use std::sync::Arc;
/// use stickslip::contact::{Jenkins, NormalDirection, NormalLaw, SlipSlap, SlipSlapInputs, SlipSlapWork};
/// let normal = NormalDirection::new(NormalLaw::Linear, 60.0, 2e7, 0.0)?;
/// let contact = SlipSlap::new(Arc::new(Jenkins::new(4e6, 0.5)?), normal);
/// let (mut state, mut next) = (vec![0.0; contact.state_len()], vec![0.0; contact.state_len()]);
/// contact.set_state([0.0; 2], 0.0, &mut state);
/// // It opens by a third of the static approach while it slides: two thirds of the preload are left.
/// let inputs = SlipSlapInputs { displacement: [20e-6, 1e-6], velocity: [0.0; 2] };
/// let response = contact.step(&state, inputs, &mut next, &mut SlipSlapWork::default());
/// assert!((response.normal_force - 40.0).abs() < 1e-9);
/// assert!((response.force[0] - 0.5 * 40.0).abs() < 1e-9 && (response.force[1] - 20.0).abs() < 1e-9);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone)]
pub struct SlipSlap {
    law: Arc<dyn ContactLaw>,
    normal: NormalDirection,
    /// Fraction of the change of N_c that reaches the friction.
    load_gain: f64,
}

/// Result of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlipSlapResponse {
    /// Restoring forces S and N (N); N is the dynamic part, `N0 − N_c`.
    pub force: [f64; 2],
    /// N_c (N), never below zero.
    pub normal_force: f64,
    /// Distance between the bodies (m), zero in contact.
    pub separation: f64,
    /// Stick, slip, or separated: N_c = 0.
    pub slip_state: SlipState,
    /// ∂force/∂displacement (N/m) at fixed state, by rows: S by ξ and η, then N.
    pub by_displacement: [[f64; 2]; 2],
    /// ∂force/∂velocity (N s/m).
    pub by_velocity: [[f64; 2]; 2],
    /// Energy that friction dissipates in this step (J), never negative.
    pub friction_energy: f64,
    /// Energy that the impact damping dissipates in this step (J), never negative.
    pub impact_energy: f64,
}

/// Derivatives of one step by the previous state of n numbers, and of the next state. Row-major.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SlipSlapTangents {
    /// ∂force/∂state, 2 × n.
    pub force_by_state: Vec<f64>,
    /// ∂next/∂state, n × n.
    pub next_by_state: Vec<f64>,
    /// ∂next/∂displacement, n × 2.
    pub next_by_displacement: Vec<f64>,
    /// ∂next/∂velocity, n × 2.
    pub next_by_velocity: Vec<f64>,
}

/// What a step needs of memory that the caller keeps: it is filled anew in every step and allocates in the first alone.
#[derive(Debug, Clone, Default)]
pub struct SlipSlapWork {
    /// Memory of the law where the bodies part or meet.
    middle: Vec<f64>,
    tangents: StateTangents,
    /// Its derivatives by inputs, own state and the law's memory before.
    carried: Vec<f64>,
    /// One of its rows after the step.
    row: Vec<f64>,
}

impl SlipSlap {
    /// The law of friction `law` under the normal force that `normal` gives.
    pub fn new(law: Arc<dyn ContactLaw>, normal: NormalDirection) -> Self {
        Self { law, normal, load_gain: 1.0 }
    }

    /// The same, but that only the fraction `load_gain` (1) of the change of N_c reaches the friction: its normal load is
    /// `N0 + load_gain (N_c − N0)`. At zero that is friction under a constant load, as a model in one direction has it. At
    /// less than one, friction goes on where the bodies are apart.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use stickslip::contact::{Jenkins, NormalDirection, NormalLaw, SlipSlap, SlipSlapInputs, SlipSlapWork};
    /// let normal = NormalDirection::new(NormalLaw::Linear, 60.0, 2e7, 0.0)?;
    /// let contact = SlipSlap::new(Arc::new(Jenkins::new(4e6, 0.5)?), normal).with_load_gain(0.0);
    /// let (mut state, mut next) = (vec![0.0; contact.state_len()], vec![0.0; contact.state_len()]);
    /// contact.set_state([0.0; 2], 0.0, &mut state);
    /// // It opens while it slides, and the limit stays.
    /// let inputs = SlipSlapInputs { displacement: [20e-6, 1e-6], velocity: [0.0; 2] };
    /// let response = contact.step(&state, inputs, &mut next, &mut SlipSlapWork::default());
    /// assert!((response.normal_force - 40.0).abs() < 1e-9 && (response.force[0] - 0.5 * 60.0).abs() < 1e-9);
    /// # Ok::<(), stickslip::contact::LawError>(())
    /// ```
    #[must_use]
    pub fn with_load_gain(self, load_gain: f64) -> Self {
        Self { load_gain, ..self }
    }

    /// The normal load (N) of the friction under the normal force `force` (N).
    fn acting(&self, force: f64) -> f64 {
        // Written so that all of it is all of it, to the last bit.
        if self.load_gain == 1.0 {
            return force;
        }
        self.normal.preload() + self.load_gain * (force - self.normal.preload())
    }

    /// The law of friction.
    pub fn law(&self) -> &Arc<dyn ContactLaw> {
        &self.law
    }

    /// The normal direction.
    pub fn normal(&self) -> &NormalDirection {
        &self.normal
    }

    /// Length of the state.
    pub fn state_len(&self) -> usize {
        MOTION + self.law.state_len()
    }

    /// Writes the state at rest at `displacement` ξ, η (m) with the tangential force `force` (N), cut to the limit there.
    pub fn set_state(&self, displacement: [f64; 2], force: f64, state: &mut [f64]) {
        let (motion, memory) = state.split_at_mut(MOTION);
        motion.copy_from_slice(&[displacement[0], displacement[1], 0.0, 0.0]);
        let load = self.acting(self.normal.force(displacement[1], 0.0));
        self.law.set_state(displacement[0], load, force, memory);
    }

    /// One step from `state` to `inputs`; writes the next state.
    pub fn step(
        &self,
        state: &[f64],
        inputs: SlipSlapInputs,
        next: &mut [f64],
        work: &mut SlipSlapWork,
    ) -> SlipSlapResponse {
        let way = Way::new(self, state, inputs);
        let memory = &state[MOTION..];
        let (end, before) = self.walk(memory, &way, next, work);
        let mut by = [0, 1, 2, 3].map(|input| way.end.force_by(&end, input));
        if let Some(event) = &way.event {
            self.law.state_tangents(memory, event.inputs, &mut work.tangents);
            carried::by_inputs(event, &work.tangents, &mut work.carried);
            self.law.state_tangents(&work.middle, way.end.inputs, &mut work.tangents);
            for (input, by) in by.iter_mut().enumerate() {
                *by += carried::product(&work.tangents.force_by_state, &work.carried, MOTION, input);
            }
        }
        self.response(&way, state, by, (&end, before))
    }

    /// As [`SlipSlap::step`], with the derivatives by the previous state.
    pub fn step_and_tangents(
        &self,
        state: &[f64],
        inputs: SlipSlapInputs,
        next: &mut [f64],
        out: &mut SlipSlapTangents,
        work: &mut SlipSlapWork,
    ) -> SlipSlapResponse {
        let way = Way::new(self, state, inputs);
        let memory = &state[MOTION..];
        let (end, before) = self.walk(memory, &way, next, work);
        let by = match &way.event {
            None => {
                carried::begin(memory.len(), &mut work.carried);
                self.law.state_tangents(memory, way.end.inputs, &mut work.tangents);
                carried::write(&way.end, &end, work, out)
            }
            Some(event) => {
                self.law.state_tangents(memory, event.inputs, &mut work.tangents);
                carried::over(event, &work.tangents, &mut work.carried);
                self.law.state_tangents(&work.middle, way.end.inputs, &mut work.tangents);
                carried::write(&way.end, &end, work, out)
            }
        };
        self.response(&way, state, by, (&end, before))
    }

    /// The law's response at the end of the way, and the energy (J) it dissipates before the bodies part or meet.
    fn walk(&self, memory: &[f64], way: &Way, next: &mut [f64], work: &mut SlipSlapWork) -> (Response, f64) {
        let (motion, after) = next.split_at_mut(MOTION);
        motion.copy_from_slice(&way.to);
        match &way.event {
            None => (self.law.step(memory, way.end.inputs, after), 0.0),
            Some(event) => {
                work.middle.resize(memory.len(), 0.0);
                let before = self.law.step(memory, event.inputs, &mut work.middle).dissipated_energy;
                (self.law.step(&work.middle, way.end.inputs, after), before)
            }
        }
    }

    /// `by`: of S by ξ, η and their rates; `end` and the energy (J) dissipated before are the law's.
    fn response(
        &self,
        way: &Way,
        state: &[f64],
        by: [f64; 4],
        (end, before): (&Response, f64),
    ) -> SlipSlapResponse {
        let [normal_force, by_opening, by_rate] = way.normal;
        SlipSlapResponse {
            force: [end.force, self.normal.preload() - normal_force],
            normal_force,
            separation: (way.to[1] - self.normal.static_approach()).max(0.0),
            slip_state: if normal_force > 0.0 { end.slip_state } else { SlipState::Separated },
            by_displacement: [[by[0], by[1]], [0.0, -by_opening]],
            by_velocity: [[by[2], by[3]], [0.0, -by_rate]],
            friction_energy: before + end.dissipated_energy,
            impact_energy: self.normal.impact_energy([state[1], state[3]], [way.to[1], way.to[3]]),
        }
    }
}

impl Piece {
    /// Derivative of the law's force by what the way begins or ends with, at fixed memory.
    fn force_by(&self, response: &Response, column: usize) -> f64 {
        let tangents = &response.tangents;
        tangents.displacement * self.by[0][column]
            + tangents.velocity * self.by[1][column]
            + tangents.normal_load * self.by[2][column]
    }
}
