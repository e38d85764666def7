//! A trial step: collocation by sweeps, correction, error estimate and events.

use super::contact_point::{ContactPoint, EXACT};
use super::events::{self, Reversal};
use super::node::{Answer, NodeContact};
use super::propagator::{END, MIDDLE, NODES, weighed};
use super::step::{NEGLIGIBLE, Span, StepSolver};

/// Sweeps before a step counts as not converging; convergence is about a digit a sweep or better.
const SWEEPS: usize = 12;
/// No finer than this part of the limit is the force asked to follow a normal load that varies within
/// a step: a law may be accurate to second order in the step only, so that the number of steps grows
/// with the cube root of what is asked.
const FINEST_PATH: f64 = 1e-5;

/// What a trial step found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Trial {
    /// No convergence, or the law gave no finite force: try a shorter step.
    Diverged,
    /// Error estimate relative to the tolerance, and the first event as a fraction of the step.
    Done { error: f64, event: Option<f64> },
}

impl StepSolver {
    /// Tries a step of `span.step` to the relative `tolerance`.
    pub fn attempt(&mut self, span: &Span, tolerance: f64) -> Trial {
        self.select_propagator(span.step);
        self.begin(&[1, 2, 3, END]);
        if !self.collocate(span, tolerance) {
            return Trial::Diverged;
        }
        for node in [1, 3] {
            self.place(node);
            if self.evaluate(node, span, [0.0, 0.0]).is_none() {
                return Trial::Diverged;
            }
        }
        let error = self.correct(tolerance);
        if !error.is_finite() {
            return Trial::Diverged;
        }
        Trial::Done { error, event: self.event(span, tolerance) }
    }

    pub fn select_propagator(&mut self, step: f64) {
        if self.propagators[self.current].is_for(step) {
            return;
        }
        self.current = 1 - self.current;
        let propagator = &mut self.propagators[self.current];
        if !propagator.is_for(step) {
            propagator.fill(&self.plant.angular_frequency, &self.plant.damping_ratio, step);
        }
    }

    /// What the state and the forcing at the start contribute to `nodes`, the last of them the end.
    pub fn begin(&mut self, nodes: &[usize]) {
        for &node in nodes {
            let rows = self.propagators[self.current].node(node);
            let start = self.q[0].iter().zip(&self.v[0]).zip(&self.forcing[0]);
            for ((due, row), ((q, v), p)) in self.due_to_start[node].iter_mut().zip(rows).zip(start) {
                *due = weighed(&row[..3], &[*q, *v, *p]);
            }
        }
        let (first, rest) = self.forcing.split_at_mut(1);
        rest[MIDDLE - 1].copy_from_slice(&first[0]);
        rest[END - 1].copy_from_slice(&first[0]);
        for [start, behind @ ..] in &mut self.nodes {
            start.begin();
            behind.fill(*start);
        }
    }

    /// Modal state at a node from the quadratic forcing.
    pub fn place(&mut self, node: usize) {
        let known = self.propagators[self.current].node(node).iter().zip(&self.due_to_start[node]);
        let forcing = self.forcing[MIDDLE].iter().zip(&self.forcing[END]);
        let state = self.q[node].iter_mut().zip(&mut self.v[node]);
        for ((([.., middle, end], due), (p2, p4)), (q, v)) in known.zip(forcing).zip(state) {
            *q = due[0] + middle[0] * p2 + end[0] * p4;
            *v = due[1] + middle[1] * p2 + end[1] * p4;
        }
    }

    /// Solves the collocation equations by sweeps; false if they do not converge.
    fn collocate(&mut self, span: &Span, tolerance: f64) -> bool {
        let mut previous = f64::INFINITY;
        for sweep in 0..SWEEPS {
            self.place(MIDDLE);
            let Some(middle) = self.evaluate(MIDDLE, span, [1.0, 0.0]) else { return false };
            if sweep == 0 {
                self.extrapolate_end();
            }
            self.place(END);
            let Some(end) = self.evaluate(END, span, [0.0, 1.0]) else { return false };
            let change = (middle + end).sqrt() * span.step;
            let scale = self.energy_norm.max(self.energy(&self.q[END], &self.v[END]));
            if change <= 0.02 * tolerance * scale || change <= NEGLIGIBLE {
                return true;
            }
            if !change.is_finite() || (sweep > 2 && change > 0.9 * previous) {
                return false;
            }
            previous = change;
        }
        false
    }

    /// First guess at the end of the step: straight on from start and middle.
    fn extrapolate_end(&mut self) {
        let (before, last) = self.forcing.split_at_mut(END);
        for ((end, middle), start) in last[0].iter_mut().zip(&before[MIDDLE]).zip(&before[0]) {
            *end = 2.0 * middle - start;
        }
        for [start, _, middle, _, end] in &mut self.nodes {
            *end = NodeContact { force: 2.0 * middle.force - start.force, ..*middle };
        }
    }

    /// Laws and forcing at a placed node; squared change of the forcing, or `None` if a law fails. Every force answers
    /// to what it does to its own port at the node by so much of it at the middle and at the end of the step, as `weights`
    /// tell; without, the evaluation is explicit.
    fn evaluate(&mut self, node: usize, span: &Span, weights: [f64; 2]) -> Option<f64> {
        self.geometry(node);
        let fraction = span.fraction(NODES[node]);
        for e in 0..self.plant.contacts.len() {
            let implicit = weights != [0.0, 0.0] && self.plant.contacts[e].law.is_some();
            let yielding = if implicit { self.yielding(e, node, weights) } else { 0.0 };
            self.ask(e, node, fraction, Answer { yielding, ..Answer::NONE })?;
        }
        Some(self.force_modes(node, fraction))
    }

    /// A law or an outside force at a placed node, at `fraction` of the communication step. `None` if a law fails.
    pub fn ask(&mut self, e: usize, node: usize, fraction: f64, answer: Answer) -> Option<()> {
        let contact = &self.plant.contacts[e];
        let input = self.ramps[contact.input].at(fraction);
        let nodes = &mut self.nodes[e];
        let Some(law) = contact.law.as_deref() else {
            nodes[node].force = input;
            return Some(());
        };
        let flexibility = self.plant.ports[contact.port].flexibility;
        let mut point = nodes[node].point(input, flexibility, contact.series, answer);
        if let Some(from) = answer.from {
            point.guess = nodes[from].going_on(&point);
        }
        let place = contact.memory.clone();
        let (before, next) = (&self.memory[place.clone()], &mut self.memory_next[place]);
        nodes[node].store(point.solve(law, before, next)?, input);
        Some(())
    }

    /// End state from the quartic through all five nodes; returns the error estimate relative to
    /// the tolerance.
    fn correct(&mut self, tolerance: f64) -> f64 {
        let propagator = &self.propagators[self.current];
        let rows = propagator.node(END).iter().zip(&propagator.quartic);
        let p: [&[f64]; 5] = std::array::from_fn(|j| &self.forcing[j][..]);
        let (mut error, mut norm) = (0.0, 0.0);
        for (i, (&omega, (start, forced))) in self.plant.angular_frequency.iter().zip(rows).enumerate() {
            let [mut q, mut v] = weighed(&start[..2], &[self.q[0][i], self.v[0][i]]);
            for (p, [by_q, by_v]) in p.iter().zip(forced) {
                q += by_q * p[i];
                v += by_v * p[i];
            }
            self.q_end[i] = q;
            self.v_end[i] = v;
            let (dq, dv) = (omega * (q - self.q[END][i]), v - self.v[END][i]);
            error += dq * dq + dv * dv;
            norm += omega * omega * q * q + v * v;
        }
        let scale = self.energy_norm.max(norm.sqrt());
        let modal = if error == 0.0 { 0.0 } else { error.sqrt() / (tolerance * scale) };
        (0..self.plant.contacts.len()).fold(modal, |error, e| error.max(self.path_error(e, tolerance)))
    }

    /// A law takes displacement and normal load to run linearly together within a step, but they
    /// curve; what a stop at the middle changes in the force, relative to the tolerance and the limit.
    fn path_error(&mut self, e: usize, tolerance: f64) -> f64 {
        let contact = &self.plant.contacts[e];
        let Some(law) = contact.law.as_deref().filter(|_| contact.remembers) else { return 0.0 };
        let normal_load = self.ramps[contact.input];
        if normal_load.is_held() {
            return 0.0;
        }
        let place = contact.memory.clone();
        let before = &self.memory[place.clone()];
        let (middle, next) = (&mut self.memory_middle[place.clone()], &mut self.memory_next[place]);
        law.step(before, self.nodes[e][MIDDLE].inputs(), middle);
        let end = &self.nodes[e][END];
        let direct = law.step(before, end.inputs(), next).force;
        let bent = law.step(middle, end.inputs(), next).force;
        let limit = law.limit(end.normal_load).max(law.limit(self.nodes[e][0].normal_load));
        // About to lift off the limit vanishes; what then counts is what a force does to the beam.
        let scale = limit.max(end.force.abs()).max(0.01 * self.energy_norm / self.compliance_norm[e]);
        if direct == bent { 0.0 } else { (direct - bent).abs() / (tolerance.max(FINEST_PATH) * scale) }
    }

    /// The first event of the step tried, unless it is its end.
    fn event(&mut self, span: &Span, tolerance: f64) -> Option<f64> {
        let events = 0..self.plant.contacts.len();
        let first = events.fold(f64::INFINITY, |first, e| first.min(self.event_of(e, span, tolerance)));
        (first < 1.0).then_some(first)
    }

    /// The first event of a law; infinite if there is none.
    fn event_of(&mut self, e: usize, span: &Span, tolerance: f64) -> f64 {
        let contact = &self.plant.contacts[e];
        let Some(law) = contact.law.as_deref() else { return f64::INFINITY };
        let (normal_load, nodes) = (self.ramps[contact.input], &self.nodes[e]);
        let (flexibility, series) = (self.plant.ports[contact.port].flexibility, contact.series);
        let mut first = f64::INFINITY;
        if contact.remembers {
            let rate = |at: usize| span.rate_at(normal_load, NODES[at]);
            let displacement = nodes.each_ref().map(|node| node.displacement);
            // A force that follows the velocity has u reverse before what the modes give does.
            let velocity = if flexibility > 0.0 && nodes.iter().any(|node| node.damping != 0.0) {
                events::rates(&displacement, span.step)
            } else {
                std::array::from_fn(|at| nodes[at].own_velocity(flexibility, rate(at)))
            };
            // Motion this small is invisible at the tolerance; the rest may be rounding.
            let norm = self.row_norm[e] * self.energy_norm;
            let floor = (1e-6 * tolerance).max(1e-13) * norm;
            let size = displacement.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            let rounding = 64.0 * f64::EPSILON * size + 1e-7 * span.step * floor;
            first = match events::reversal(&velocity, &displacement, floor, rounding) {
                Reversal::None => f64::INFINITY,
                Reversal::At(fraction) => fraction,
                Reversal::Hidden => 0.5,
            };
        }
        let mut slip = nodes.each_ref().map(|node| node.slip_state);
        let constant = normal_load.is_held();
        let place = contact.memory.clone();
        let memory = &self.memory[place.clone()];
        let (before, next) = (&mut self.memory_middle[place.clone()], &mut self.memory_next[place]);
        let point = |node: usize, at: f64| {
            let (u, v) = hermite(&nodes[node], &nodes[node + 1], span.step, (at - NODES[node]) * 4.0);
            ContactPoint {
                displacement: u,
                velocity: v,
                flexibility,
                series,
                began: nodes[node].began,
                slowing: 0.0,
                tangent: 0.0,
                falls: nodes[node].damping < 0.0,
                normal_load: normal_load.at(span.fraction(at)),
                placed: nodes[node].force,
                guess: nodes[node].force,
                precision: EXACT,
            }
        };
        let mut probe = |node: usize, at: f64| {
            let mut from = memory;
            if !constant {
                point(node, at - events::LOOK_BACK).solve(law, memory, before)?;
                from = before;
            }
            point(node, at).solve(law, from, next).map(|answered| answered.response.slip_state)
        };
        // The state committed belongs to the step before: a contact that slipped up to a reversal sticks.
        if let Some(state) = probe(0, events::JUST_BEHIND_START) {
            slip[0] = state;
        }
        let parts = if constant { 1 } else { events::PROBES };
        events::corner(&slip, parts, probe).map_or(first, |fraction| first.min(fraction))
    }
}

/// Cubic through displacement and velocity of two neighbouring nodes, `x` from 0 to 1 between them,
/// a quarter of `step` (s) apart: displacement (m) and velocity (m/s).
fn hermite(a: &NodeContact, b: &NodeContact, step: f64, x: f64) -> (f64, f64) {
    let width = 0.25 * step;
    let rise = b.geometric_displacement - a.geometric_displacement;
    let (va, vb) = (a.geometric_velocity * width, b.geometric_velocity * width);
    let (c2, c3) = (3.0 * rise - 2.0 * va - vb, va + vb - 2.0 * rise);
    let u = a.geometric_displacement + x * (va + x * (c2 + x * c3));
    (u, (va + x * (2.0 * c2 + 3.0 * x * c3)) / width)
}
