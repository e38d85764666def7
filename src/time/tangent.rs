//! What becomes of a small change of the inputs as a system goes through a communication step.

use super::integrator::Integrator;
use super::plant::{add_product, dot};
use super::propagator::NODES;
use super::solve::solve;
use super::step::{NodeContact, Span, StepSolver};
use super::trial::{END, MIDDLE};
use super::{IntegrationError, Motion, Ramp, Settings};
use crate::contact::{Carried, Inputs, Tangents};

/// Sweeps over the weak terms of the linear collocation equations; each gains several digits.
const SWEEPS: usize = 30;
/// Change of the forcing, relative, at which the sweeps end.
const SETTLED: f64 = 1e-13;
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
    start_q: [Vec<f64>; 5],
    start_v: [Vec<f64>; 5],
    /// G q and G q̇ at the nodes.
    pull: [Vec<f64>; 5],
    turning: [Vec<f64>; 5],
    /// Modal accelerations at the end.
    acceleration: Vec<f64>,
    product: Vec<f64>,
    nodes: [Vec<NodeChange>; 5],
    carried: Vec<Carried>,
    unused: Vec<f64>,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// Of each law or outside force at the present.
    pub contacts: Vec<ContactChange>,
    /// Normal loads before a jump.
    loads: Vec<f64>,
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
}

/// A law at a node to first order: `δT = tangents · δinputs + by_memory`.
#[derive(Debug, Clone, Copy, Default)]
struct NodeChange {
    tangents: Tangents,
    by_memory: f64,
    load: f64,
    force: f64,
}

impl Integrator {
    /// The step of [`Integrator::advance`] from `motion`, which stays, with the change `by` of the inputs; `tangent`
    /// becomes that of the end. Without a `duration` it is that of `motion` itself, at rest with laws that remember
    /// nothing.
    pub(crate) fn follow(
        &mut self,
        motion: &Motion,
        duration: Option<f64>,
        inputs: &[Ramp],
        settings: &Settings,
        (tangent, by): (&mut Tangent, &[Ramp]),
    ) -> Result<(), IntegrationError> {
        self.begin(motion, duration.unwrap_or(1.0), inputs, settings)?;
        tangent.begin(&self.solver);
        let Some(duration) = duration else {
            tangent.rest(&self.solver, by);
            if !self.solver.prepare(&Span::START) {
                return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
            }
            tangent.arrive(&self.solver, 0.0, by);
            tangent.finish(&self.solver, &Span::START, by);
            return Ok(());
        };
        let mut suggested = self.first_step(motion);
        self.run(duration, settings, &mut suggested, Some((tangent, by)))?;
        tangent.finish(&self.solver, &Span { duration, ..Span::START }, by);
        Ok(())
    }
}

impl Tangent {
    /// No change yet of the motion that `solver` has loaded.
    fn begin(&mut self, solver: &StepSolver) {
        let (n, contacts) = (solver.plant.size(), solver.plant.contacts.len());
        let lists = [&mut self.q, &mut self.v, &mut self.p, &mut self.rest, &mut self.start_q];
        let more = [&mut self.start_v, &mut self.pull, &mut self.turning];
        let single = [&mut self.acceleration, &mut self.product];
        for list in lists.into_iter().chain(more).flatten().chain(single) {
            list.clear();
            list.resize(n, 0.0);
        }
        for node in &mut self.nodes {
            node.clear();
            node.resize(contacts, NodeChange::default());
        }
        self.contacts.clear();
        self.contacts.resize(contacts, ContactChange::default());
        self.unused.clear();
        self.unused.resize(solver.plant.memory_len, 0.0);
        self.carried.resize(contacts, Carried::default());
        for (carried, contact) in self.carried.iter_mut().zip(&solver.plant.contacts) {
            carried.begin(&solver.memory[contact.memory.clone()]);
        }
    }

    /// At rest, with laws that remember nothing but their loads.
    fn rest(&mut self, solver: &StepSolver, by: &[Ramp]) {
        for (carried, contact) in self.carried.iter_mut().zip(&solver.plant.contacts) {
            if let Some(law) = contact.law.as_deref() {
                carried.rest(law, solver.ramps[contact.input].start, by[contact.input].start);
            }
        }
    }

    pub fn before_jump(&mut self, solver: &StepSolver) {
        self.loads.clear();
        self.loads.extend(solver.nodes[0].iter().map(|at| at.normal_load));
    }

    /// Jumps of the normal loads, or of their changes, at the start of the communication step; `solver` is prepared.
    pub fn jump(&mut self, solver: &StepSolver, by: &[Ramp]) {
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            let change = by[contact.input].start;
            if contact.law.is_none() {
                self.contacts[e].force = change;
            } else if solver.nodes[0][e].normal_load != self.loads[e] || change != 0.0 {
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
        let inputs = inputs(&solver.nodes[node][e], flexibility, load);
        let carried = &mut self.carried[e];
        let t = law.step(&carried.memory, inputs, &mut self.unused[contact.memory.clone()]).tangents;
        let by_memory = carried.force_by_memory(law, inputs);
        let slope = 1.0 + flexibility * t.displacement;
        let velocity = velocity / slope;
        let force =
            (t.displacement * displacement + t.velocity * velocity + t.normal_load * normal_load + by_memory)
                / slope;
        let by = Inputs { displacement: displacement - flexibility * force, velocity, normal_load };
        let change = carried.step(law, inputs, by);
        let at = &mut self.contacts[e];
        (at.force, at.tangent) = (force, change.tangent);
        at.dissipated_energy += change.dissipated_energy;
    }

    /// Goes through the step that `solver` has tried with success and not yet committed.
    pub fn through(&mut self, solver: &StepSolver, span: &Span, by: &[Ramp]) {
        let plant = &solver.plant;
        for node in 0..=END {
            plant.shorten(&solver.q[node], &mut self.pull[node]);
            plant.shorten(&solver.v[node], &mut self.turning[node]);
        }
        for (at, contact) in self.nodes[0].iter_mut().zip(&self.contacts) {
            at.force = contact.force;
        }
        self.force_without_laws(solver, 0, by, span.from);
        self.add_laws(solver, 0);
        for (node, at) in NODES.into_iter().enumerate().skip(1) {
            self.linearise(solver, node, span.fraction(at), by);
        }
        self.start(solver);
        self.collocate(solver, span, by);
        for node in [1, 3] {
            self.place(solver, node, |change| &change.p);
            for (e, contact) in plant.contacts.iter().enumerate().filter(|(_, contact)| contact.law.is_some())
            {
                let own = self.own_force(solver, e, node);
                let at = &mut self.nodes[node][e];
                at.force = own / (1.0 + plant.ports[contact.port].flexibility * at.tangents.displacement);
            }
            self.force_without_laws(solver, node, by, span.fraction(NODES[node]));
            self.add_laws(solver, node);
        }
        self.take_over(solver);
    }

    /// The laws at a node, at `fraction` of the communication step.
    fn linearise(&mut self, solver: &StepSolver, node: usize, fraction: f64, by: &[Ramp]) {
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            let at = &mut self.nodes[node][e];
            at.load = by[contact.input].at(fraction);
            let Some(law) = contact.law.as_deref() else {
                at.force = at.load;
                continue;
            };
            let load = solver.ramps[contact.input].at(fraction);
            let inputs = inputs(&solver.nodes[node][e], solver.plant.ports[contact.port].flexibility, load);
            let unused = &mut self.unused[contact.memory.clone()];
            at.tangents = law.step(&self.carried[e].memory, inputs, unused).tangents;
            at.by_memory = self.carried[e].force_by_memory(law, inputs);
        }
    }

    /// What the changes at the start contribute to the nodes.
    fn start(&mut self, solver: &StepSolver) {
        for node in 1..=END {
            let rows = solver.propagators[solver.current].node(node);
            for i in 0..self.q[0].len() {
                let by = [self.q[0][i], self.v[0][i], self.p[0][i]];
                self.start_q[node][i] = (0..3).map(|k| rows.q_start[k][i] * by[k]).sum();
                self.start_v[node][i] = (0..3).map(|k| rows.v_start[k][i] * by[k]).sum();
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
        for i in 0..self.q[0].len() {
            let (middle, end) = (forcing(self)[MIDDLE][i], forcing(self)[END][i]);
            self.q[node][i] =
                self.start_q[node][i] + rows.q_forcing[0][i] * middle + rows.q_forcing[1][i] * end;
            self.v[node][i] =
                self.start_v[node][i] + rows.v_forcing[0][i] * middle + rows.v_forcing[1][i] * end;
        }
    }

    /// Middle and end of the step: the forces of laws solved for, the weak terms by sweeps.
    fn collocate(&mut self, solver: &StepSolver, span: &Span, by: &[Ramp]) {
        for _ in 0..SWEEPS {
            for node in PAIR {
                self.force_without_laws(solver, node, by, span.fraction(NODES[node]));
            }
            for node in PAIR {
                self.place(solver, node, |change| &change.rest);
            }
            self.solve_laws(solver);
            let (mut moved, mut size) = (0.0_f64, 0.0_f64);
            for node in PAIR {
                self.product.copy_from_slice(&self.p[node]);
                self.add_laws(solver, node);
                for (p, before) in self.p[node].iter().zip(&self.product) {
                    moved = moved.max((p - before).abs());
                    size = size.max(p.abs());
                }
            }
            for node in PAIR {
                self.place(solver, node, |change| &change.p);
            }
            if moved <= SETTLED * size {
                return;
            }
        }
    }

    /// The changes of force of all laws at both nodes, which move all ports at both.
    fn solve_laws(&mut self, solver: &StepSolver) {
        let plant = &solver.plant;
        let laws = || plant.contacts.iter().enumerate().filter(|(_, contact)| contact.law.is_some());
        let count = 2 * laws().count();
        self.matrix.clear();
        self.right.clear();
        for (half, node) in PAIR.into_iter().enumerate() {
            let rows = solver.propagators[solver.current].node(node);
            for (e, contact) in laws() {
                let t = self.nodes[node][e].tangents;
                let (port, own) = (&plant.ports[contact.port], self.own_force(solver, e, node));
                self.right.push(own);
                for (other_half, other_node) in PAIR.into_iter().enumerate() {
                    let (by_q, by_v) = (rows.q_forcing[other_half], rows.v_forcing[other_half]);
                    for (other, pusher) in laws() {
                        let pusher = &plant.ports[pusher.port];
                        let (mut moved, mut sped) = (0.0, 0.0);
                        for i in 0..plant.size() {
                            let seen = port.row[i] - port.shortening * self.pull[node][i];
                            let pushed = pusher.row[i] - pusher.shortening * self.pull[other_node][i];
                            moved += seen * pushed * by_q[i];
                            sped += seen * pushed * by_v[i];
                        }
                        let itself = half == other_half && e == other;
                        let one = if itself { 1.0 + port.flexibility * t.displacement } else { 0.0 };
                        self.matrix.push(one + t.displacement * moved + t.velocity * sped);
                    }
                }
            }
        }
        // Forces that are not to be found stay as they were, and the sweeps go on.
        if count > 0 && solve(&mut self.matrix, &mut self.right) {
            for (half, node) in PAIR.into_iter().enumerate() {
                for (k, (e, _)) in laws().enumerate() {
                    self.nodes[node][e].force = self.right[half * (count / 2) + k];
                }
            }
        }
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
            push(contact.port, change, solver.nodes[node][e].force);
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

    /// The end of the step from the quartic, and the middle of a step under loads that run.
    fn take_over(&mut self, solver: &StepSolver) {
        for (e, contact) in solver.plant.contacts.iter().enumerate().filter(|(_, contact)| contact.remembers)
        {
            let ramp = solver.ramps[contact.input];
            if ramp.start != ramp.end {
                let (displacement, velocity) = self.geometric(solver, e, MIDDLE);
                let (load, change) = (solver.nodes[MIDDLE][e].normal_load, self.nodes[MIDDLE][e].load);
                self.contact_step(solver, e, MIDDLE, load, (displacement, velocity, change));
            }
        }
        let propagator = &solver.propagators[solver.current];
        let start = propagator.node(END);
        let (q_rows, v_rows) = (propagator.quartic_q(), propagator.quartic_v());
        for i in 0..self.q[0].len() {
            let (q, v) = (self.q[0][i], self.v[0][i]);
            let forced = |rows: &[&[f64]; 5]| (0..5).map(|j| rows[j][i] * self.p[j][i]).sum::<f64>();
            self.q[0][i] = start.q_start[0][i] * q + start.q_start[1][i] * v + forced(&q_rows);
            self.v[0][i] = start.v_start[0][i] * q + start.v_start[1][i] * v + forced(&v_rows);
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
            self.nodes[0][e].force = self.contacts[e].force;
        }
        self.force_without_laws(solver, 0, by, fraction);
        self.add_laws(solver, 0);
    }

    /// Changes of the accelerations and of the ports' displacements and velocities at the end of the lines.
    fn finish(&mut self, solver: &StepSolver, span: &Span, by: &[Ramp]) {
        let plant = &solver.plant;
        for i in 0..self.acceleration.len() {
            let (omega, zeta) = (plant.angular_frequency[i], plant.damping_ratio[i]);
            self.acceleration[i] =
                self.p[0][i] - 2.0 * zeta * omega * self.v[0][i] - omega * omega * self.q[0][i];
        }
        for (e, contact) in plant.contacts.iter().enumerate() {
            let (displacement, velocity) = self.geometric(solver, e, 0);
            let a = plant.ports[contact.port].flexibility;
            let (rate, rate_change) = (span.rate(solver.ramps[contact.input]), span.rate(by[contact.input]));
            let at = &mut self.contacts[e];
            at.displacement = displacement - a * at.force;
            at.velocity = if contact.law.is_none() {
                velocity - a * rate_change
            } else {
                let node = &solver.nodes[0][e];
                let yielded = at.tangent * node.velocity(a, rate) + node.load_tangent * rate_change;
                (velocity - a * yielded) / (1.0 + a * node.tangent)
            };
        }
    }

    /// Change of what sensor `sensor` reads: displacement, velocity, acceleration.
    pub fn sensor(&self, integrator: &Integrator, sensor: usize) -> [f64; 3] {
        let plant = &integrator.solver.plant;
        let row = &plant.ports[plant.sensors[sensor]].row;
        [dot(row, &self.q[0]), dot(row, &self.v[0]), dot(row, &self.acceleration)]
    }
}

fn inputs(contact: &NodeContact, flexibility: f64, normal_load: f64) -> Inputs {
    let velocity = contact.geometric_velocity / (1.0 + flexibility * contact.tangent);
    Inputs { displacement: contact.displacement, velocity, normal_load }
}
