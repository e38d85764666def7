//! Integrals over the legs between turning points, panel by panel.

use super::chain::spring_step;
use super::jump::Jump;
use super::{SmoothCycle, Sums};
use crate::contact::{Inputs, SlipState};
use crate::harmonic::period::PeriodicContact;

/// Largest half-width of a panel in radians of the highest harmonic.
const WIDEST: f64 = 7.0;
/// Error of the step through the series spring at a node, as a fraction of the force.
const NODE_TOLERANCE: f64 = 1e-12;
/// Times a panel is halved at most.
const MAX_HALVINGS: u32 = 14;

impl SmoothCycle {
    /// Integrates over the leg from point `leg`.
    pub(super) fn integrate_leg(&mut self, contact: &PeriodicContact, angular_frequency: f64, leg: usize) {
        for (component, depends) in self.depends.iter_mut().enumerate() {
            *depends = self.chain.by_points(leg, component).iter().any(|d| *d != 0.0);
        }
        let (from, to) = (self.path.points[leg], self.path.points[leg + 1]);
        let scratch = (self.next.as_mut_slice(), &mut self.tangents);
        self.jump = Jump::find(contact, self.chain.state(leg), &self.motion, (&from, &to), scratch);
        let (from, to) = (from.phase, to.phase);
        let Some(jump) = &self.jump else {
            self.integrate_part(contact, angular_frequency, leg, (from, to));
            return;
        };
        let (mut first, mut last) = (jump.phase, jump.phase);
        if contact.compliance == 0.0 {
            self.add_jump(angular_frequency);
        } else {
            let other = jump.other_end(contact, angular_frequency, &self.motion, (from, to));
            (first, last) = (first.min(other), last.max(other));
        }
        for part in [(from, first), (first, last), (last, to)] {
            self.integrate_part(contact, angular_frequency, leg, part);
        }
    }

    fn integrate_part(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        leg: usize,
        (from, to): (f64, f64),
    ) {
        let width = to - from;
        if width <= 0.0 {
            return;
        }
        let panels = (0.5 * width * self.set.highest() as f64 / WIDEST).ceil().max(1.0);
        for panel in 0..panels as usize {
            let left = from + width * (panel as f64 / panels);
            self.integrate_panel(
                contact,
                angular_frequency,
                leg,
                (left, left + width / panels),
                MAX_HALVINGS,
            );
        }
    }

    fn integrate_panel(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        leg: usize,
        (left, right): (f64, f64),
        halvings: u32,
    ) {
        self.visit(contact, angular_frequency, leg, left, right);
        // A drag has no force at the turning points, by which the chain measures.
        let nodes = self.nodes.iter();
        let scale = nodes.fold(self.chain.force_scale, |scale, node| scale.max(node.force.abs()));
        if halvings > 0 && self.rule.too_wide(&self.nodes, scale) {
            let middle = 0.5 * (left + right);
            self.integrate_panel(contact, angular_frequency, leg, (left, middle), halvings - 1);
            self.integrate_panel(contact, angular_frequency, leg, (middle, right), halvings - 1);
            return;
        }
        self.add(angular_frequency, 0.5 * (right - left));
    }

    /// Evaluates the law at the nodes of a panel.
    fn visit(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        leg: usize,
        left: f64,
        right: f64,
    ) {
        let n = self.next.len();
        // Force, stiffness and displacement at the node before, to start the next one from.
        let mut before = (self.chain.force[leg], 0.0, 0.0);
        for (i, node) in self.nodes.iter_mut().enumerate() {
            node.phase = 0.5 * ((left + right) + (right - left) * self.rule.nodes[i]);
            let (displacement, slope) = self.motion.value_and_slope(node.phase);
            node.slope = slope;
            let mut inputs = Inputs {
                displacement,
                velocity: angular_frequency * slope,
                normal_load: contact.normal_load,
            };
            let (scale, state) = (self.chain.force_scale, self.chain.state(leg));
            let by_state = &mut self.by_state[i * n..(i + 1) * n];
            if contact.compliance != 0.0
                && let Some(jump) = &self.jump
                && let Some(force) = jump.taken_up(contact.compliance, displacement, inputs.velocity)
            {
                (node.force, node.stiffness) = (force, 1.0 / contact.compliance);
                (node.damping, node.stuck) = (0.0, true);
                before = (force, node.stiffness, displacement);
                let scaled = jump.by_state.iter().map(|by_state| by_state / contact.compliance);
                by_state.iter_mut().zip(scaled).for_each(|(to, from)| *to = from);
                continue;
            }
            if self.alone && contact.compliance == 0.0 {
                // A law of many sliders has a tenth of the work with it.
                self.next.copy_from_slice(state);
                node.force = contact.law.advance(&mut self.next, inputs);
                continue;
            }
            let response = if contact.compliance == 0.0 {
                contact.law.force_and_tangents(state, inputs, &mut self.next, &mut self.tangents)
            } else {
                let guess = before.0 + before.1 * (displacement - before.2);
                let response =
                    spring_step(contact, state, &mut inputs, guess, scale, NODE_TOLERANCE, &mut self.next);
                contact.law.state_tangents(state, inputs, &mut self.tangents);
                response
            };
            let homotopy_compliance = 1.0 / (1.0 + contact.compliance * response.tangents.displacement);
            node.force = response.force;
            node.stiffness = homotopy_compliance * response.tangents.displacement;
            before = (node.force, node.stiffness, displacement);
            node.damping = homotopy_compliance * response.tangents.velocity;
            node.stuck = response.slip_state == SlipState::Stick;
            for (to, from) in by_state.iter_mut().zip(&self.tangents.force_by_state) {
                *to = homotopy_compliance * from;
            }
        }
    }

    /// Adds a panel's nodes to the sums.
    fn add(&mut self, angular_frequency: f64, half_width: f64) {
        if self.alone {
            let nodes = self.nodes.iter().zip(&self.rule.weights);
            let weighted = nodes.map(|(node, weight)| (half_width * weight, node));
            self.history.extend(weighted.map(|(weight, node)| (node.phase, weight * node.force, weight)));
            return;
        }
        let n = self.next.len();
        let sums = &mut self.sums;
        for (i, node) in self.nodes.iter().enumerate() {
            let weight = half_width * self.rule.weights[i];
            sums.waves.fill(node.phase);
            sums.force.add(weight * node.force, &sums.waves);
            sums.stiffness.add(weight * node.stiffness, &sums.waves);
            if node.damping != 0.0 {
                self.rated = true;
                sums.damping.add(weight * angular_frequency * node.damping, &sums.waves);
                sums.by_frequency.add(weight * node.damping * node.slope, &sums.waves);
            }
            add_by_state(sums, weight, &self.by_state[i * n..(i + 1) * n], &self.depends);
            let marked = if node.stuck { -weight } else { weight };
            self.history.push((node.phase, weight * node.force, marked));
        }
    }

    /// Adds what the coefficients change by as the jump moves.
    fn add_jump(&mut self, angular_frequency: f64) {
        let (Some(jump), sums) = (&self.jump, &mut self.sums) else { return };
        let weight = angular_frequency * jump.damping.abs();
        sums.waves.fill(jump.phase);
        sums.stiffness.add(weight, &sums.waves);
        add_by_state(sums, weight, &jump.by_state, &self.depends);
    }
}

/// Adds derivatives by the state behind, of the components that depend on the motion.
fn add_by_state(sums: &mut Sums, weight: f64, by_state: &[f64], depends: &[bool]) {
    for (sum, (by_state, depends)) in sums.by_state.iter_mut().zip(by_state.iter().zip(depends)) {
        if *depends && *by_state != 0.0 {
            sum.add(weight * by_state, &sums.waves);
        }
    }
}
