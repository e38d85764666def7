//! The periodic state of a law with memory, from turning point to turning point.
//!
//! Between two turning points a law's step is exact however long it is. So a period is as many steps as there are
//! turning points, and its periodic state the root of a small system. All derivatives are linear in the
//! displacements at the turning points, which take the place of the Fourier coefficients here.

use crate::contact::{Inputs, Response, StateTangents};
use crate::harmonic::HarmonicError;
use crate::harmonic::period::PeriodicContact;
use crate::harmonic::period::closure::{Closure, Marched, add_scaled};
use crate::harmonic::period::motion::Turning;
use crate::numeric::implicit::Implicit;

/// Fraction of the largest force left as error of the implicit step through the series spring: rounding, since a
/// slowly fading memory magnifies it.
pub(super) const STEP_TOLERANCE: f64 = 1e-15;
/// Change of force (fraction of the largest) below which the state is periodic.
const PERIODIC: f64 = 1e-13;
/// The same where rounding, which a slowly fading memory magnifies, stops the progress: a Newton step this small
/// leaves its square.
const LINEAR_FINISH: f64 = 1e-5;
const MAX_CYCLES: usize = 60;

/// States at the turning points, with their derivatives.
#[derive(Debug, Default)]
pub(super) struct Chain {
    n: usize,
    points: usize,
    /// State at each point, one after the other; the last is that of the first a period later.
    states: Vec<f64>,
    /// Their derivatives by the displacements at the points and by the state at the first: `n` rows
    /// each, of `points + n`.
    sensitivities: Vec<f64>,
    /// Force at each point (N).
    pub force: Vec<f64>,
    force_row: Vec<f64>,
    /// Derivatives of the force by the state at the first point, one row per step.
    force_by_start: Vec<f64>,
    pub dissipated_energy: f64,
    /// Largest force (N) met so far.
    pub force_scale: f64,
    scale: Vec<f64>,
    without_history: Vec<f64>,
    next: Vec<f64>,
    closure: Closure,
    tangents: StateTangents,
}

/// A step of the law through the series spring, from `state` to `inputs.displacement` of both together;
/// `guess` is the force to start from (N), `tolerance` the error left, as a fraction of the force and of `scale` (N).
/// Writes the next state and leaves the contact's own displacement in
/// `inputs`.
pub(super) fn spring_step(
    contact: &PeriodicContact,
    state: &[f64],
    inputs: &mut Inputs,
    guess: f64,
    scale: f64,
    tolerance: f64,
    next: &mut [f64],
) -> Response {
    let total = inputs.displacement;
    let mut implicit = Implicit::new(guess);
    loop {
        inputs.displacement = total - contact.compliance * implicit.force;
        let response = contact.law.step(state, *inputs, next);
        let gradient = 1.0 + contact.compliance * response.tangents.displacement;
        let tolerance = tolerance * gradient * scale.max(response.force.abs());
        if implicit.accept(response.force, gradient, contact.compliance, tolerance) {
            return response;
        }
    }
}

impl Chain {
    fn reserve(&mut self, n: usize, points: usize) {
        let columns = points + n;
        self.n = n;
        self.points = points;
        let fill = |vector: &mut Vec<f64>, len: usize| {
            vector.clear();
            vector.resize(len, 0.0);
        };
        fill(&mut self.states, (points + 1) * n);
        fill(&mut self.sensitivities, (points + 1) * n * columns);
        fill(&mut self.force, points + 1);
        fill(&mut self.force_row, columns);
        fill(&mut self.force_by_start, points * n);
        for vector in [&mut self.scale, &mut self.without_history, &mut self.next] {
            fill(vector, n);
        }
    }

    /// State at a point.
    pub fn state(&self, point: usize) -> &[f64] {
        &self.states[point * self.n..(point + 1) * self.n]
    }

    /// Derivatives of a component of the state at a point by the displacements at the points.
    pub fn by_points(&self, point: usize, component: usize) -> &[f64] {
        let columns = self.points + self.n;
        let from = (point * self.n + component) * columns;
        &self.sensitivities[from..from + self.points]
    }

    /// Finds the periodic states along `path`, whose last point is the first a period later.
    pub fn solve(&mut self, contact: &PeriodicContact, path: &[Turning]) -> Result<(), HarmonicError> {
        self.reserve(contact.law.state_len(), path.len() - 1);
        self.start_virgin(contact, path[0].value);
        let (mut last_change, mut plain) = (f64::INFINITY, false);
        for _ in 0..MAX_CYCLES {
            self.march(contact, path);
            if self.n == 0 {
                return Ok(());
            }
            let change = self.close();
            let stalled = change <= LINEAR_FINISH * self.force_scale && change >= 0.25 * last_change;
            if change <= PERIODIC * self.force_scale || stalled {
                self.correct(true);
                self.march(contact, path);
                return Ok(());
            }
            // Newton may overshoot where the loop bends sharply; plain marching always contracts.
            plain = !change.is_finite() || change > last_change && !plain;
            last_change = change;
            if plain {
                self.restart_at_end();
            } else {
                self.correct(false);
            }
        }
        Err(HarmonicError::ContactNotPeriodic { cycles: MAX_CYCLES })
    }

    /// The unloaded contact loaded to the first point.
    fn start_virgin(&mut self, contact: &PeriodicContact, displacement: f64) {
        contact.law.set_state(0.0, contact.normal_load, 0.0, &mut self.without_history);
        self.force_scale = 0.0;
        let mut inputs = Inputs { displacement, velocity: 0.0, normal_load: contact.normal_load };
        let response = spring_step(
            contact,
            &self.without_history,
            &mut inputs,
            0.0,
            0.0,
            STEP_TOLERANCE,
            &mut self.next,
        );
        self.states[..self.n].copy_from_slice(&self.next);
        self.force_scale = response.force.abs();
        contact.law.state_tangents(&self.without_history, inputs, &mut self.tangents);
        let homotopy_compliance = 1.0 / (1.0 + contact.compliance * response.tangents.displacement);
        let columns = self.points + self.n;
        for i in 0..self.n {
            self.sensitivities[i * columns] = self.tangents.next_by_displacement[i] * homotopy_compliance;
        }
    }

    /// Steps through all points from the state at the first.
    fn march(&mut self, contact: &PeriodicContact, path: &[Turning]) {
        let (n, columns) = (self.n, self.points + self.n);
        for i in 0..n {
            let row = &mut self.sensitivities[i * columns..(i + 1) * columns];
            row[self.points..].fill(0.0);
            row[self.points + i] = 1.0;
            self.scale[i] = self.states[i].abs();
        }
        self.dissipated_energy = 0.0;
        let mut largest = 0.0_f64;
        for j in 0..self.points {
            let mut inputs =
                Inputs { displacement: path[j + 1].value, velocity: 0.0, normal_load: contact.normal_load };
            let (before, after) = self.states.split_at_mut((j + 1) * n);
            let state = &before[j * n..];
            let (guess, scale) = (self.force[j + 1], self.force_scale);
            let response =
                spring_step(contact, state, &mut inputs, guess, scale, STEP_TOLERANCE, &mut after[..n]);
            contact.law.state_tangents(state, inputs, &mut self.tangents);
            for (scale, x) in self.scale.iter_mut().zip(&after[..n]) {
                *scale = scale.max(x.abs());
            }
            self.force[j + 1] = response.force;
            self.dissipated_energy += response.dissipated_energy;
            largest = largest.max(response.force.abs());
            self.carry(contact, j, &response);
        }
        self.force[0] = self.force[self.points];
        self.force_scale = largest;
    }

    /// Carries the derivatives through step `j`.
    fn carry(&mut self, contact: &PeriodicContact, j: usize, response: &Response) {
        let (n, points) = (self.n, self.points);
        let columns = points + n;
        let ahead = (j + 1) % points;
        let stiffness = response.tangents.displacement;
        let (before, after) = self.sensitivities.split_at_mut((j + 1) * n * columns);
        let before = &before[j * n * columns..];
        let row = &mut self.force_row;
        // dT (1 + a ∂T/∂u) = ∂T/∂u du + ∂T/∂state dstate, and the contact itself moves by du − a dT.
        row.fill(0.0);
        row[ahead] = stiffness;
        for (weight, source) in self.tangents.force_by_state.iter().zip(before.chunks_exact(columns)) {
            add_scaled(row, *weight, source);
        }
        let homotopy_compliance = 1.0 / (1.0 + contact.compliance * stiffness);
        row.iter_mut().for_each(|r| *r *= homotopy_compliance);
        self.force_by_start[j * n..(j + 1) * n].copy_from_slice(&row[points..]);
        row.iter_mut().for_each(|r| *r *= -contact.compliance);
        row[ahead] += 1.0;
        for (i, target) in after[..n * columns].chunks_exact_mut(columns).enumerate() {
            target.fill(0.0);
            add_scaled(target, self.tangents.next_by_displacement[i], row);
            let weights = &self.tangents.next_by_state[i * n..(i + 1) * n];
            for (weight, source) in weights.iter().zip(before.chunks_exact(columns)) {
                add_scaled(target, *weight, source);
            }
        }
    }

    /// Finds what makes the state at the first point periodic; returns the largest change of force it makes.
    fn close(&mut self) -> f64 {
        let (n, points) = (self.n, self.points);
        let (last, columns) = (points * n, points + n);
        let marched = Marched {
            start: &self.states[..n],
            end: &self.states[last..last + n],
            start_sensitivity: &self.sensitivities[..n * columns],
            end_sensitivity: &self.sensitivities[last * columns..(last + n) * columns],
        };
        self.closure.solve(&marched, points, &mut self.scale);
        self.closure.force_change(self.force_by_start.chunks_exact(n))
    }

    /// Changes the start; the derivatives' part only counts at the periodic state.
    fn correct(&mut self, derivatives: bool) {
        self.closure.correct(&mut self.states[..self.n], &mut self.sensitivities, derivatives);
    }

    fn restart_at_end(&mut self) {
        let (n, columns) = (self.n, self.points + self.n);
        let (start, rest) = self.states.split_at_mut(n);
        start.copy_from_slice(&rest[(self.points - 1) * n..]);
        let (start, rest) = self.sensitivities.split_at_mut(n * columns);
        start.copy_from_slice(&rest[(self.points - 1) * n * columns..]);
    }
}
