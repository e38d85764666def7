//! What becomes of a small change of the inputs as a system goes through a communication step, by the linearised steps.

mod controlled;
mod equal;

use super::Ramp;
use super::node::NodeContact;
use super::plant::{add_product, dot};
use super::propagator::{END, MIDDLE, weighed};
use super::step::{Span, StepSolver, bent_energy};
use crate::contact::{Inputs, StateSensitivity, Tangents};

/// Nodes whose forces are solved for.
const PAIR: [usize; 2] = [MIDDLE, END];

/// Change of a motion, to first order: the linearised step, with the coefficients of the step itself.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tangent {
    /// Of the modal displacements and velocities at the nodes; node 0 is the present.
    q: [Vec<f64>; 5],
    v: [Vec<f64>; 5],
    /// Of the forcing: all of it, and without the forces of laws.
    p: [Vec<f64>; 5],
    rest: [Vec<f64>; 5],
    /// Of `q` and `v`, due to the start.
    due_to_start: [Vec<[f64; 2]>; 5],
    /// G q and G q̇ at the nodes.
    pull: [Vec<f64>; 5],
    turning: [Vec<f64>; 5],
    /// Modal accelerations at the end.
    acceleration: Vec<f64>,
    product: Vec<f64>,
    nodes: [Vec<NodeChange>; 5],
    sensitivity: Vec<StateSensitivity>,
    unused: Vec<f64>,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// Of each law or outside force at the present.
    pub contacts: Vec<ContactChange>,
    /// Normal loads before a jump.
    loads: Vec<f64>,
    /// Of an equal step: what laws see of their ports at its end, and rates of their forces at its two ends.
    seen: Vec<[f64; 2]>,
    rates: Vec<[f64; 2]>,
}

/// Change of a law or an outside force.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactChange {
    /// Of the force (N).
    pub force: f64,
    /// Of ∂T/∂u (N/m).
    tangent: f64,
    /// Of the energy taken (J).
    pub dissipated_energy: f64,
    /// Of displacement (m) and velocity (m/s).
    pub displacement: f64,
    pub velocity: f64,
    /// Of the energy taken before a step whose path bends, and of that on a straight line to its end.
    bent: Option<[f64; 2]>,
}

/// A law at a node to first order: `δT = tangents · δinputs + by_memory`.
#[derive(Debug, Clone, Copy, Default)]
struct NodeChange {
    tangents: Tangents,
    by_memory: f64,
    load: f64,
    force: f64,
}

impl Tangent {
    /// No change yet of the motion that `solver` has loaded.
    pub fn begin(&mut self, solver: &StepSolver) {
        let (n, contacts) = (solver.plant.size(), solver.plant.contacts.len());
        let lists =
            [&mut self.q, &mut self.v, &mut self.p, &mut self.rest, &mut self.pull, &mut self.turning];
        let single = [&mut self.acceleration, &mut self.product];
        for list in lists.into_iter().flatten().chain(single) {
            list.clear();
            list.resize(n, 0.0);
        }
        self.due_to_start.iter_mut().for_each(|list| list.resize(n, [0.0; 2]));
        for node in &mut self.nodes {
            node.clear();
            node.resize(contacts, NodeChange::default());
        }
        self.contacts.clear();
        self.contacts.resize(contacts, ContactChange::default());
        for list in [&mut self.seen, &mut self.rates] {
            list.clear();
            list.resize(contacts, [0.0; 2]);
        }
        self.unused.clear();
        self.unused.resize(solver.plant.memory_len, 0.0);
        self.sensitivity.resize(contacts, StateSensitivity::default());
        for (carried, contact) in self.sensitivity.iter_mut().zip(&solver.plant.contacts) {
            carried.begin(&solver.memory[contact.memory.clone()]);
        }
    }

    /// At rest, with laws that remember nothing but their loads.
    pub fn rest(&mut self, solver: &StepSolver, by: &[Ramp]) {
        for (carried, contact) in self.sensitivity.iter_mut().zip(&solver.plant.contacts) {
            if let Some(law) = contact.law.as_deref() {
                carried.rest(law, solver.ramps[contact.input].start, by[contact.input].start);
            }
        }
    }

    pub fn before_jump(&mut self, solver: &StepSolver) {
        self.loads.clear();
        self.loads.extend(solver.nodes.iter().map(|[at, ..]| at.normal_load));
    }

    /// Jumps of the normal loads, or of their changes, at the start of the communication step; `solver` is prepared.
    pub fn jump(&mut self, solver: &StepSolver, by: &[Ramp]) {
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            let change = by[contact.input].start;
            if contact.law.is_none() {
                self.contacts[e].force = change;
            } else if solver.nodes[e][0].normal_load != self.loads[e] || change != 0.0 {
                let load = solver.ramps[contact.input].start;
                self.contact_step(solver, e, 0, load, (0.0, 0.0, change));
            }
        }
    }

    /// A law's step to node `node`, with the inputs' change `(geometric displacement, its rate, load)`.
    fn contact_step(
        &mut self,
        solver: &StepSolver,
        e: usize,
        node: usize,
        load: f64,
        (displacement, velocity, normal_load): (f64, f64, f64),
    ) {
        let contact = &solver.plant.contacts[e];
        let Some(law) = contact.law.as_deref() else { return };
        let flexibility = solver.plant.ports[contact.port].flexibility;
        let inputs = inputs(&solver.nodes[e][node], contact.series, load);
        let carried = &mut self.sensitivity[e];
        let t = law.step(&carried.memory, inputs, &mut self.unused[contact.memory.clone()]).tangents;
        let by_memory = carried.force_by_memory(law, inputs);
        let slope = 1.0 + flexibility * t.displacement;
        let velocity = velocity / (1.0 + contact.series * t.displacement);
        let force =
            (t.displacement * displacement + t.velocity * velocity + t.normal_load * normal_load + by_memory)
                / slope;
        let by = Inputs { displacement: displacement - flexibility * force, velocity, normal_load };
        let change = carried.step(law, inputs, by);
        let at = &mut self.contacts[e];
        (at.force, at.tangent) = (force, change.tangent);
        at.dissipated_energy += change.dissipated_energy;
    }

    /// What the changes at the start contribute to the nodes.
    fn start(&mut self, solver: &StepSolver) {
        for node in 1..=END {
            let rows = solver.propagators[solver.current].node(node);
            for (i, (due, row)) in self.due_to_start[node].iter_mut().zip(rows).enumerate() {
                *due = weighed(&row[..3], &[self.q[0][i], self.v[0][i], self.p[0][i]]);
            }
        }
        for node in PAIR {
            for i in 0..self.q[0].len() {
                self.q[node][i] = self.q[0][i];
                self.v[node][i] = self.v[0][i];
                self.p[node][i] = 0.0;
            }
        }
    }

    /// Modal changes at a node from the start and the forcing at the middle and the end.
    fn place(&mut self, solver: &StepSolver, node: usize, forcing: impl Fn(&Self) -> &[Vec<f64>; 5]) {
        let rows = solver.propagators[solver.current].node(node);
        for (i, [.., middle, end]) in rows.iter().enumerate() {
            let (due, p2, p4) = (self.due_to_start[node][i], forcing(self)[MIDDLE][i], forcing(self)[END][i]);
            self.q[node][i] = due[0] + middle[0] * p2 + end[0] * p4;
            self.v[node][i] = due[1] + middle[1] * p2 + end[1] * p4;
        }
    }

    /// A law at a node, at `inputs`, or a force from outside, whose own input changes by `change`.
    fn linearise_at(&mut self, solver: &StepSolver, (e, node): (usize, usize), inputs: Inputs, change: f64) {
        let contact = &solver.plant.contacts[e];
        let at = &mut self.nodes[node][e];
        at.load = change;
        let Some(law) = contact.law.as_deref() else {
            at.force = change;
            return;
        };
        let unused = &mut self.unused[contact.memory.clone()];
        at.tangents = law.step(&self.sensitivity[e].memory, inputs, unused).tangents;
        at.by_memory = self.sensitivity[e].force_by_memory(law, inputs);
    }

    /// Change of the force of a law or from outside at a node that is placed (N).
    fn answer(&self, solver: &StepSolver, e: usize, node: usize) -> f64 {
        let (contact, at) = (&solver.plant.contacts[e], &self.nodes[node][e]);
        if contact.law.is_none() {
            return at.force;
        }
        let flexibility = solver.plant.ports[contact.port].flexibility;
        self.own_force(solver, e, node) / (1.0 + flexibility * at.tangents.displacement)
    }

    /// A law's part of the change of its force at a node, the yielding left out (N).
    fn own_force(&self, solver: &StepSolver, e: usize, node: usize) -> f64 {
        let (displacement, velocity) = self.geometric(solver, e, node);
        let NodeChange { tangents: t, by_memory, load, .. } = self.nodes[node][e];
        t.displacement * displacement + t.velocity * velocity + t.normal_load * load + by_memory
    }

    /// Changes of a port's geometric displacement and velocity at a node.
    fn geometric(&self, solver: &StepSolver, e: usize, node: usize) -> (f64, f64) {
        let port = &solver.plant.ports[solver.plant.contacts[e].port];
        let turned = if port.shortening == 0.0 {
            0.0
        } else {
            port.shortening * dot(&self.turning[node], &self.q[node])
        };
        let along = |x: &[f64]| port.along(x, &self.pull[node]);
        (along(&self.q[node]), along(&self.v[node]) - turned)
    }

    /// Change of the forcing at a node, at `fraction` of the communication step, but for that of the laws' forces.
    fn force_without_laws(&mut self, solver: &StepSolver, node: usize, by: &[Ramp], fraction: f64) {
        let plant = &solver.plant;
        let (q, v, pull) = (&self.q[node], &self.v[node], &self.pull[node]);
        let rest = &mut self.rest[node];
        rest.fill(0.0);
        // Σ γ F: what pulls along with the shortening.
        let mut tension = 0.0;
        let mut push = |port: usize, change: f64, force: f64| {
            let port = &plant.ports[port];
            tension += port.shortening * force;
            let parts = port.row.iter().zip(pull);
            rest.iter_mut().zip(parts).for_each(|(rest, (b, g))| *rest -= change * (b - port.shortening * g));
        };
        for (port, ramp) in plant.driven.iter().zip(by) {
            push(*port, -ramp.at(fraction), 0.0);
        }
        for (e, contact) in plant.contacts.iter().enumerate() {
            let change = if contact.law.is_none() { by[contact.input].at(fraction) } else { 0.0 };
            push(contact.port, change, solver.nodes[e][node].force);
        }
        for springs in &plant.springs {
            let ports = springs.ports.map(|port| &plant.ports[port]);
            let forces =
                springs.forces(ports.map(|port| port.motion(&solver.q[node], &solver.v[node], pull).0));
            let changes = springs.forces(ports.map(|port| port.along(q, pull)));
            for ((port, change), force) in springs.ports.iter().zip(changes).zip(forces) {
                push(*port, change, force);
            }
        }
        if tension != 0.0 {
            plant.shorten(q, &mut self.product);
            rest.iter_mut().zip(&self.product).for_each(|(rest, g)| *rest += tension * g);
        }
        if !plant.damping.is_empty() {
            self.product.fill(0.0);
            add_product(&plant.damping, v, &mut self.product);
            rest.iter_mut().zip(&self.product).for_each(|(rest, lost)| *rest -= lost);
        }
    }

    fn add_laws(&mut self, solver: &StepSolver, node: usize) {
        let p = &mut self.p[node];
        p.copy_from_slice(&self.rest[node]);
        for (contact, at) in solver.plant.contacts.iter().zip(&self.nodes[node]) {
            if contact.law.is_some() {
                let port = &solver.plant.ports[contact.port];
                let parts = port.row.iter().zip(&self.pull[node]);
                p.iter_mut().zip(parts).for_each(|(p, (b, g))| *p -= at.force * (b - port.shortening * g));
            }
        }
    }

    /// The laws and the forcing at the end of the step, which `solver` has committed.
    pub fn arrive(&mut self, solver: &StepSolver, fraction: f64, by: &[Ramp]) {
        solver.plant.shorten(&solver.v[0], &mut self.turning[0]);
        self.pull[0].copy_from_slice(&solver.pull);
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            let change = by[contact.input].at(fraction);
            if contact.law.is_none() {
                self.contacts[e].force = change;
            } else {
                let (displacement, velocity) = self.geometric(solver, e, 0);
                let load = solver.ramps[contact.input].at(fraction);
                self.contact_step(solver, e, 0, load, (displacement, velocity, change));
            }
            let at = &mut self.contacts[e];
            if let Some([before, straight]) = at.bent.take() {
                at.dissipated_energy = before + bent_energy(at.dissipated_energy - before, straight);
            }
            self.nodes[0][e].force = self.contacts[e].force;
        }
        self.force_without_laws(solver, 0, by, fraction);
        self.add_laws(solver, 0);
    }

    /// Of the modal displacements, velocities and accelerations at the end.
    pub fn present(&self) -> [&[f64]; 3] {
        [&self.q[0], &self.v[0], &self.acceleration]
    }

    /// Changes of the accelerations and of the ports' displacements and velocities at the end, for the rates of `inputs`
    /// and of their changes.
    pub fn finish(&mut self, solver: &StepSolver, span: &Span, inputs: &[Ramp], by: &[Ramp]) {
        let plant = &solver.plant;
        for i in 0..self.acceleration.len() {
            let (omega, zeta) = (plant.angular_frequency[i], plant.damping_ratio[i]);
            self.acceleration[i] =
                self.p[0][i] - 2.0 * zeta * omega * self.v[0][i] - omega * omega * self.q[0][i];
        }
        for (e, contact) in plant.contacts.iter().enumerate() {
            let (displacement, velocity) = self.geometric(solver, e, 0);
            let a = plant.ports[contact.port].flexibility;
            let (rate, rate_change) = (span.rate(inputs[contact.input]), span.rate(by[contact.input]));
            let at = &mut self.contacts[e];
            at.displacement = displacement - a * at.force;
            at.velocity = if contact.law.is_none() {
                velocity - a * rate_change
            } else {
                let node = &solver.nodes[e][0];
                let yielded = at.tangent * node.own_velocity(a, rate) + node.load_tangent * rate_change;
                (velocity - a * yielded) / (1.0 + a * node.tangent)
            };
        }
    }
}

/// What a law was asked at a node, its velocity behind the compliance `series` (m/N).
fn inputs(contact: &NodeContact, series: f64, normal_load: f64) -> Inputs {
    let velocity = contact.geometric_velocity / (1.0 + series * contact.tangent);
    Inputs { displacement: contact.displacement, velocity, normal_load }
}
