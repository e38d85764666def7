//! An implicit integrator for any law: the structure exactly, the contact forces by collocation.

use nalgebra::{DMatrix, DVector};

use super::exact::polynomial::{DEGREE, Series};
use super::exact::system::{System, dot};
use super::{Excitation, OscillatorError};
use crate::contact::LoadedContact;
use crate::contact::{Inputs, Response};
use crate::system::LinearStructure;

/// Interior nodes and end of a step, as shares of it.
const NODES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Newton steps on the contact forces before the step is halved.
const NEWTON: usize = 15;
/// Part of the tolerance that one step may use.
const SHARE: f64 = 0.1;

/// Integrates a [`LinearStructure`] with contacts of any law under constant normal loads.
///
/// Over a step the contact forces are a quadratic through start, middle and end (Lobatto's points, order
/// 4), found by Newton's method on the forces alone; the structure answers exactly, by operators computed
/// once per step size. A quartic through the quarter points as well gives the end (order 5), and the
/// difference the error estimate, in the norm of energy. Reversals of a contact with memory end a step;
/// corners are met by small steps.
///
/// Every law is evaluated from the state at the start of the step, and nothing is kept between calls
/// but operators: a rejected step leaves no trace.
pub struct OscillatorIntegrator<'a> {
    system: System,
    /// The structure driven by each contact's force.
    driven: Vec<System>,
    contacts: Vec<LoadedContact<'a>>,
    tolerance: f64,
    step_limit: usize,
    operators: Operators,
    trial: Trial,
}

/// State of an oscillator with contacts of any law: a value, to be copied at will.
#[derive(Debug, Clone, PartialEq)]
pub struct OscillatorState {
    time: f64,
    x: Vec<f64>,
    v: Vec<f64>,
    laws: Vec<Vec<f64>>,
    force: Vec<f64>,
    dissipated_energy: Vec<f64>,
    /// Contacts whose velocity was brought to zero here.
    turned: Vec<bool>,
    suggested: f64,
}

impl OscillatorState {
    /// Time (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Restoring force of every contact (N).
    pub fn contact_forces(&self) -> &[f64] {
        &self.force
    }

    /// Energy taken by every contact since the start (J).
    pub fn dissipated_energy(&self) -> &[f64] {
        &self.dissipated_energy
    }
}

/// Displacement and velocity in inner coordinates.
type Moved = (Vec<f64>, Vec<f64>);

/// Answers of the structure at the nodes to contact forces `sᵏ`, `k = 1 … 4`, over a step of `h`.
#[derive(Debug, Default)]
struct Operators {
    h: f64,
    /// `[contact][power − 1][node]`: displacement, velocity.
    answer: Vec<[[Moved; 4]; 4]>,
}

/// A step tried.
#[derive(Debug, Default)]
struct Trial {
    /// At the nodes, without the change of the contact forces.
    free: [Moved; 4],
    /// Change of the forces at the middle and the end, contact by contact in pairs.
    change: Vec<f64>,
    /// Velocity of each contact at the nodes.
    velocity: Vec<[f64; 4]>,
    x: Vec<f64>,
    v: Vec<f64>,
    next: Vec<Vec<f64>>,
    responses: Vec<Option<Response>>,
    error: f64,
}

impl std::fmt::Debug for OscillatorIntegrator<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OscillatorIntegrator").field("contacts", &self.contacts).finish_non_exhaustive()
    }
}

impl<'a> OscillatorIntegrator<'a> {
    /// An integrator of `structure` with `contacts` in the same order, whose steps err by less than
    /// `tolerance`, between 1e-13 and 0.1, of the motion.
    ///
    /// # Errors
    /// A structure without mass somewhere or with entries out of place, a list of contacts of another
    /// length, an illegal tolerance or load.
    pub fn new(
        structure: &LinearStructure,
        contacts: &[LoadedContact<'a>],
        tolerance: f64,
    ) -> Result<Self, OscillatorError> {
        let system = System::new(structure)?;
        let (expected, found) = (system.contacts.len(), contacts.len());
        if expected != found {
            return Err(OscillatorError::Length { name: "contacts", expected, found });
        }
        if !(1e-13..=0.1).contains(&tolerance) {
            return Err(OscillatorError::Input { name: "tolerance", value: tolerance });
        }
        if let Some(contact) = contacts.iter().find(|contact| !contact.normal_load.is_finite()) {
            return Err(OscillatorError::Input { name: "normal load", value: contact.normal_load });
        }
        let zero = vec![0.0; system.size];
        let trial = Trial {
            free: std::array::from_fn(|_| (zero.clone(), zero.clone())),
            change: vec![0.0; 2 * found],
            velocity: vec![[0.0; 4]; found],
            x: zero.clone(),
            v: zero.clone(),
            next: contacts.iter().map(|contact| vec![0.0; contact.law.state_len()]).collect(),
            responses: vec![None; found],
            error: 0.0,
        };
        Ok(Self {
            driven: (0..found).map(|i| system.driven_by_contact(i)).collect(),
            system,
            contacts: contacts.to_vec(),
            tolerance,
            step_limit: 1_000_000,
            operators: Operators::default(),
            trial,
        })
    }

    /// At rest without any force, at time 0; the contacts remember nothing.
    pub fn rest(&self) -> OscillatorState {
        let n = self.system.size;
        self.begin(vec![0.0; n], vec![0.0; n])
    }

    /// A state at time 0 with displacements (m) and velocities (m/s) given, the contacts free of force where
    /// they have memory.
    ///
    /// # Errors
    /// Lists of another length than the structure has degrees of freedom, numbers that are not finite.
    pub fn moving(&self, displacement: &[f64], velocity: &[f64]) -> Result<OscillatorState, OscillatorError> {
        for (name, list) in [("displacement", displacement), ("velocity", velocity)] {
            if list.len() != self.system.size {
                return Err(OscillatorError::Length { name, expected: self.system.size, found: list.len() });
            }
            if let Some(value) = list.iter().find(|value| !value.is_finite()) {
                return Err(OscillatorError::Input { name, value: *value });
            }
        }
        Ok(self.begin(self.system.inward(displacement), self.system.inward(velocity)))
    }

    fn begin(&self, x: Vec<f64>, v: Vec<f64>) -> OscillatorState {
        let (mut laws, mut force) = (Vec::new(), Vec::new());
        for (contact, row) in self.contacts.iter().zip(&self.system.contacts) {
            let (displacement, velocity) = (dot(row, &x), dot(row, &v));
            let mut state = vec![0.0; contact.law.state_len()];
            contact.law.set_state(displacement, contact.normal_load, 0.0, &mut state);
            let inputs = Inputs { displacement, velocity, normal_load: contact.normal_load };
            force.push(contact.law.step(&state, inputs, &mut state.clone()).force);
            laws.push(state);
        }
        let count = self.contacts.len();
        let (dissipated_energy, turned) = (vec![0.0; count], vec![false; count]);
        OscillatorState { time: 0.0, x, v, laws, force, dissipated_energy, turned, suggested: 0.0 }
    }

    /// Displacements of the degrees of freedom (m).
    pub fn displacement(&self, state: &OscillatorState) -> Vec<f64> {
        self.system.outward(&state.x)
    }

    /// Velocities of the degrees of freedom (m/s).
    pub fn velocity(&self, state: &OscillatorState) -> Vec<f64> {
        self.system.outward(&state.v)
    }

    /// Moves `state` by `duration` (s) under `excitation`; returns the number of steps accepted.
    ///
    /// # Errors
    /// Illegal numbers, a tolerance that no step meets, too many steps. `state` is then unchanged.
    pub fn advance(
        &mut self,
        state: &mut OscillatorState,
        duration: f64,
        excitation: &Excitation,
    ) -> Result<usize, OscillatorError> {
        excitation.check()?;
        if !(duration >= 0.0 && duration.is_finite()) {
            return Err(OscillatorError::Input { name: "duration", value: duration });
        }
        if state.x.len() != self.system.size || state.laws.len() != self.contacts.len() {
            let (expected, found) = (self.system.size, state.x.len());
            return Err(OscillatorError::Length { name: "state", expected, found });
        }
        let mut moved = state.clone();
        let steps = self.run(&mut moved, duration, excitation)?;
        *state = moved;
        Ok(steps)
    }

    fn run(
        &mut self,
        state: &mut OscillatorState,
        duration: f64,
        excitation: &Excitation,
    ) -> Result<usize, OscillatorError> {
        let longest = self.system.longest_step(&vec![0.0; self.contacts.len()], excitation.fastest());
        let end = state.time + duration;
        let smallest = 1e-14 * longest.min(duration).max(state.time * 1e-2);
        let mut wanted = if state.suggested > 0.0 { state.suggested } else { 0.05 * longest };
        let mut accepted = 0;
        for _ in 0..self.step_limit {
            let remaining = end - state.time;
            if remaining <= 0.0 {
                state.suggested = wanted;
                return Ok(accepted);
            }
            let whole = remaining.min(excitation.until_corner(state.time)).min(longest);
            // Powers of two of the longest step, so that operators serve again.
            let rounded = longest * 2f64.powf((wanted / longest).log2().floor());
            let (mut h, mut turned) = (whole.min(rounded), None);
            let mut tried = self.attempt(state, h, excitation);
            if tried
                && self.trial.error <= 1.0
                && let Some((shorter, contact)) = self.reversal(state, h, excitation)
            {
                (h, turned) = (shorter, Some(contact));
                tried = self.attempt(state, h, excitation);
            }
            let error = self.trial.error;
            if !(tried && error <= 1.0) {
                let factor =
                    if tried && error.is_finite() { (0.9 * error.powf(-0.2)).clamp(0.1, 0.5) } else { 0.25 };
                wanted = factor * h;
                if wanted < smallest {
                    return Err(OscillatorError::StepTooSmall { time: state.time, step: wanted });
                }
                continue;
            }
            self.commit(state, turned);
            state.time = if h == remaining { end } else { state.time + h };
            accepted += 1;
            // A step cut short, at an event or at the end, says little about the next.
            if h >= 0.5 * wanted {
                wanted = (h * (0.9 * error.max(1e-8).powf(-0.2)).clamp(0.3, 4.0)).min(longest);
            }
        }
        Err(OscillatorError::TooManySteps { limit: self.step_limit, time: state.time })
    }

    /// Tries a step of `h`; false where Newton's method fails.
    fn attempt(&mut self, state: &OscillatorState, h: f64, excitation: &Excitation) -> bool {
        self.prepare(h);
        let mut force: Series = [0.0; DEGREE + 1];
        excitation.expand(state.time, h, &mut force);
        let none = vec![0.0; self.contacts.len()];
        let mut series = self.system.series();
        self.system.expand(h, &state.x, &state.v, (&none, &state.force), Some(&force), &mut series);
        for (node, (x, v)) in NODES.iter().zip(&mut self.trial.free) {
            self.system.at(&series, h, *node, x, v);
        }
        if !self.collocate(state) {
            return false;
        }
        self.correct(state);
        self.trial.x.iter().chain(&self.trial.v).all(|value| value.is_finite())
    }

    /// Operators of steps of `h`.
    fn prepare(&mut self, h: f64) {
        if self.operators.h == h {
            return;
        }
        let n = self.system.size;
        let (zero, none) = (vec![0.0; n], vec![0.0; self.contacts.len()]);
        let mut series = self.system.series();
        self.operators.answer = self
            .driven
            .iter()
            .map(|driven| {
                std::array::from_fn(|power| {
                    let mut force: Series = [0.0; DEGREE + 1];
                    force[power + 1] = 1.0;
                    driven.expand(h, &zero, &zero, (&none, &none), Some(&force), &mut series);
                    std::array::from_fn(|node| {
                        let (mut x, mut v) = (zero.clone(), zero.clone());
                        driven.at(&series, h, NODES[node], &mut x, &mut v);
                        (x, v)
                    })
                })
            })
            .collect();
        self.operators.h = h;
    }

    /// Displacement and velocity of contact `i` at a node under changes of the forces with the given
    /// coefficients of `s … s⁴` per contact.
    fn seen(&self, i: usize, node: usize, coefficients: &[[f64; 4]]) -> (f64, f64) {
        let row = &self.system.contacts[i];
        let free = &self.trial.free[node];
        let (mut u, mut speed) = (dot(row, &free.0), dot(row, &free.1));
        for (answer, powers) in self.operators.answer.iter().zip(coefficients) {
            for (answer, factor) in answer.iter().zip(powers).filter(|(_, factor)| **factor != 0.0) {
                u += factor * dot(row, &answer[node].0);
                speed += factor * dot(row, &answer[node].1);
            }
        }
        (u, speed)
    }

    fn law(&mut self, state: &OscillatorState, i: usize, (displacement, velocity): (f64, f64)) -> Response {
        let contact = &self.contacts[i];
        let inputs = Inputs { displacement, velocity, normal_load: contact.normal_load };
        contact.law.step(&state.laws[i], inputs, &mut self.trial.next[i])
    }

    /// The quadratic through start, middle and end: Newton's method on the changes of the forces.
    fn collocate(&mut self, state: &OscillatorState) -> bool {
        let count = self.contacts.len();
        let powers_of = |change: &[f64]| -> Vec<[f64; 4]> {
            change.chunks_exact(2).map(|d| [4.0 * d[0] - d[1], 2.0 * d[1] - 4.0 * d[0], 0.0, 0.0]).collect()
        };
        self.trial.change.fill(0.0);
        for iteration in 0..NEWTON {
            let coefficients = powers_of(&self.trial.change);
            let mut residual = DVector::zeros(2 * count);
            let mut jacobian = DMatrix::identity(2 * count, 2 * count);
            let mut scale = 0.0_f64;
            for i in 0..count {
                for (half, node) in [(0, 1), (1, 3)] {
                    let place = 2 * i + half;
                    let response = self.law(state, i, self.seen(i, node, &coefficients));
                    residual[place] = state.force[i] + self.trial.change[place] - response.force;
                    scale = scale.max(response.force.abs()).max(state.force[i].abs());
                    let row = &self.system.contacts[i];
                    for (j, answer) in self.operators.answer.iter().enumerate() {
                        let gain = |power: usize| {
                            response.tangents.displacement * dot(row, &answer[power][node].0)
                                + response.tangents.velocity * dot(row, &answer[power][node].1)
                        };
                        jacobian[(place, 2 * j)] -= 4.0 * gain(0) - 4.0 * gain(1);
                        jacobian[(place, 2 * j + 1)] -= 2.0 * gain(1) - gain(0);
                    }
                }
            }
            let Some(step) = jacobian.lu().solve(&residual) else { return count == 0 };
            self.trial.change.iter_mut().zip(step.iter()).for_each(|(change, step)| *change -= step);
            if !step.iter().all(|step| step.is_finite()) {
                return false;
            }
            let size = step.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
            if size <= 1e-14 * scale || (iteration > 4 && size <= 1e-3 * self.tolerance * scale) {
                return true;
            }
        }
        count == 0
    }

    /// The quartic through all nodes, the end of the step and the estimate of its error.
    fn correct(&mut self, state: &OscillatorState) {
        let count = self.contacts.len();
        let quadratic: Vec<[f64; 4]> = self
            .trial
            .change
            .chunks_exact(2)
            .map(|d| [4.0 * d[0] - d[1], 2.0 * d[1] - 4.0 * d[0], 0.0, 0.0])
            .collect();
        let mut quartic = quadratic.clone();
        for (i, powers) in quartic.iter_mut().enumerate() {
            let mut values = [0.0; 4];
            for (node, value) in values.iter_mut().enumerate() {
                *value = self.law(state, i, self.seen(i, node, &quadratic)).force - state.force[i];
            }
            *powers = through(values);
        }
        let (mut x, mut v) = self.trial.free[3].clone();
        let (mut by_x, mut by_v) = (vec![0.0; x.len()], vec![0.0; v.len()]);
        for ((answer, fine), coarse) in self.operators.answer.iter().zip(&quartic).zip(&quadratic) {
            for power in 0..4 {
                let (to_x, to_v) = &answer[power][3];
                for k in 0..x.len() {
                    x[k] += fine[power] * to_x[k];
                    v[k] += fine[power] * to_v[k];
                    by_x[k] += (fine[power] - coarse[power]) * to_x[k];
                    by_v[k] += (fine[power] - coarse[power]) * to_v[k];
                }
            }
        }
        let h = self.operators.h;
        let size =
            |x: &[f64], v: &[f64]| (2.0 * self.system.energy(x, v).abs() + dot(x, x) / (h * h) * 1e-4).sqrt();
        let scale = size(&x, &v).max(size(&state.x, &state.v));
        let error = size(&by_x, &by_v);
        self.trial.error = if scale > 0.0 { error / (SHARE * self.tolerance * scale) } else { 0.0 };
        (self.trial.x, self.trial.v) = (x, v);
        for i in 0..count {
            for node in 0..3 {
                self.trial.velocity[i][node] = self.seen(i, node, &quartic).1;
            }
            let row = self.system.contacts[i].clone();
            let end = (dot(&row, &self.trial.x), dot(&row, &self.trial.v));
            self.trial.velocity[i][3] = end.1;
            self.trial.responses[i] = Some(self.law(state, i, end));
        }
    }

    /// The first reversal of a contact with memory within the step tried, as a shorter step that ends there.
    fn reversal(&mut self, state: &OscillatorState, h: f64, excitation: &Excitation) -> Option<(f64, usize)> {
        let (mut h, mut found) = (h, None);
        for _ in 0..2 * self.contacts.len() {
            let Some((contact, low, high, sign)) = self.first_reversal(state, found) else { break };
            let (mut low, mut high) = (low * h, high * h);
            let (mut f_low, mut f_high): (Option<f64>, Option<f64>) = (None, None);
            let scale = self.trial.velocity[contact].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let mut at = 0.5 * (low + high);
            for _ in 0..60 {
                if !self.attempt(state, at, excitation) {
                    return found.map(|contact| (h, contact));
                }
                let speed = sign * self.trial.velocity[contact][3];
                if speed.abs() <= 1e-14 * scale || high - low <= 1e-15 * h {
                    break;
                }
                if speed > 0.0 {
                    (low, f_low) = (at, Some(speed));
                    f_high = f_high.map(|f| 0.5 * f);
                } else {
                    (high, f_high) = (at, Some(speed));
                    f_low = f_low.map(|f| 0.5 * f);
                }
                at = match (f_low, f_high) {
                    (Some(f_low), Some(f_high)) => (low * f_high - high * f_low) / (f_high - f_low),
                    _ => 0.5 * (low + high),
                };
            }
            (h, found) = (at, Some(contact));
        }
        found.map(|contact| (h, contact))
    }

    /// The contact that reverses first between two nodes, the nodes, and the sign of its velocity before.
    fn first_reversal(
        &self,
        state: &OscillatorState,
        except: Option<usize>,
    ) -> Option<(usize, f64, f64, f64)> {
        let mut first: Option<(usize, f64, f64, f64)> = None;
        for (i, velocity) in self.trial.velocity.iter().enumerate() {
            if self.contacts[i].law.state_len() == 0 || except == Some(i) {
                continue;
            }
            let start = dot(&self.system.contacts[i], &state.v);
            let sign = if state.turned[i] || start == 0.0 { velocity[0].signum() } else { start.signum() };
            let Some(node) = velocity.iter().position(|v| v * sign < 0.0) else { continue };
            let low = if node == 0 { 0.0 } else { NODES[node - 1] };
            if first.is_none_or(|(_, earlier, ..)| low < earlier) {
                first = Some((i, low, NODES[node], sign));
            }
        }
        first
    }

    fn commit(&mut self, state: &mut OscillatorState, turned: Option<usize>) {
        state.x.copy_from_slice(&self.trial.x);
        state.v.copy_from_slice(&self.trial.v);
        for (i, response) in self.trial.responses.iter().enumerate() {
            state.laws[i].copy_from_slice(&self.trial.next[i]);
            if let Some(response) = response {
                state.force[i] = response.force;
                state.dissipated_energy[i] += response.dissipated_energy;
            }
            state.turned[i] = turned == Some(i);
        }
    }
}

/// Coefficients of `s … s⁴` of the quartic that is zero at 0 and takes `values` at the nodes.
fn through(values: [f64; 4]) -> [f64; 4] {
    let [a, b, c, d] = values;
    [
        16.0 * a - 12.0 * b + 16.0 / 3.0 * c - d,
        -208.0 / 3.0 * a + 76.0 * b - 112.0 / 3.0 * c + 22.0 / 3.0 * d,
        96.0 * a - 128.0 * b + 224.0 / 3.0 * c - 16.0 * d,
        -128.0 / 3.0 * a + 64.0 * b - 128.0 / 3.0 * c + 32.0 / 3.0 * d,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quartic_passes_through_its_nodes() {
        let values = [0.3, -1.2, 0.7, 2.1];
        let c = through(values);
        for (node, value) in NODES.iter().zip(values) {
            let at = node * (c[0] + node * (c[1] + node * (c[2] + node * c[3])));
            assert!((at - value).abs() < 1e-13, "{at} {value}");
        }
    }
}
