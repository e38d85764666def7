//! The state within a communication step: what is at its start, and taking over a step.

use super::Ramp;
use super::coefficients::EqualSteps;
use super::motion::{ContactMotion, Motion};
use super::node::{Answer, NodeContact};
use super::plant::{Plant, add_product};
use super::propagator::{END, MIDDLE, NODES, Propagator};

/// Amplitudes below this are set to zero: denormal numbers are ten times slower.
pub(crate) const NEGLIGIBLE: f64 = 1e-150;

/// The part of a communication step that a trial step covers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    /// Length of the trial step (s).
    pub step: f64,
    /// Its ends as fractions of the communication step.
    pub from: f64,
    pub to: f64,
    /// Length of the communication step (s).
    pub duration: f64,
}

impl Span {
    /// The beginning of a communication step.
    pub const START: Self = Self { step: 0.0, from: 0.0, to: 0.0, duration: f64::INFINITY };

    pub fn fraction(&self, node: f64) -> f64 {
        if node >= 1.0 { self.to } else { self.from + node * (self.to - self.from) }
    }

    /// An input at the start, the middle and the end.
    pub fn values(&self, input: &Ramp) -> [f64; 3] {
        [self.from, self.fraction(NODES[MIDDLE]), self.to].map(|fraction| input.at(fraction))
    }

    /// Rate of an input that runs on a straight line (1/s).
    pub fn rate(&self, ramp: Ramp) -> f64 {
        if ramp.start == ramp.end { 0.0 } else { (ramp.end - ramp.start) / self.duration }
    }

    /// Rate of an input (1/s) at a node, as a fraction of the trial step.
    pub fn rate_at(&self, ramp: Ramp, node: f64) -> f64 {
        if ramp.is_held() { 0.0 } else { ramp.slope(self.fraction(node)) / self.duration }
    }
}

/// The working state and the buffers of a step, which allocates nothing unless equal steps have a new length.
#[derive(Debug, Clone)]
pub(crate) struct StepSolver {
    pub plant: Plant,
    /// Inputs over the communication step.
    pub ramps: Vec<Ramp>,
    /// Modal displacements, velocities and forcing at the five nodes; node 0 is the state, whose forcing equal steps of a linear
    /// plant leave behind.
    pub q: [Vec<f64>; 5],
    pub v: [Vec<f64>; 5],
    pub forcing: [Vec<f64>; 5],
    /// Each law and outside force at the nodes.
    pub nodes: Vec<[NodeContact; 5]>,
    /// What the laws remember at the start; behind the middle; behind the end.
    pub memory: Vec<f64>,
    pub memory_middle: Vec<f64>,
    pub memory_next: Vec<f64>,
    pub dissipated_energy: Vec<f64>,
    /// Energy norm of the state, of each contact's row, and of the modal displacements under its unit force.
    pub energy_norm: f64,
    pub row_norm: Vec<f64>,
    pub compliance_norm: Vec<f64>,
    /// The part of the node states, `q` and `v` of each mode, due to the start of the step.
    pub due_to_start: [Vec<[f64; 2]>; 5],
    pub q_end: Vec<f64>,
    pub v_end: Vec<f64>,
    /// G q at the node evaluated last.
    pub pull: Vec<f64>,
    /// Room for the forcing.
    pub pushed: Vec<f64>,
    /// Coefficients for the two step sizes used last.
    pub propagators: [Propagator; 2],
    pub current: usize,
    /// Coefficients for the equal steps used last.
    pub equal: EqualSteps,
}

impl StepSolver {
    pub fn new(plant: Plant) -> Self {
        let modes = plant.size();
        let per_node = || std::array::from_fn(|_| vec![0.0; modes]);
        let memory = || vec![0.0; plant.memory_len];
        let norms = |scale: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let rows = plant.contacts.iter().map(|contact| &plant.ports[contact.port].row);
            rows.map(|row| norm(row.iter().enumerate().map(|(i, b)| b * scale(i)))).collect()
        };
        let slowness =
            |i: usize| if plant.angular_frequency[i] > 0.0 { 1.0 / plant.angular_frequency[i] } else { 0.0 };
        Self {
            ramps: vec![Ramp::held(0.0); plant.inputs()],
            q: per_node(),
            v: per_node(),
            forcing: per_node(),
            nodes: vec![[NodeContact::REST; 5]; plant.contacts.len()],
            memory: memory(),
            memory_middle: memory(),
            memory_next: memory(),
            dissipated_energy: vec![0.0; plant.contacts.len()],
            energy_norm: 0.0,
            row_norm: norms(&|_| 1.0),
            compliance_norm: norms(&slowness),
            due_to_start: std::array::from_fn(|_| vec![[0.0; 2]; modes]),
            q_end: vec![0.0; modes],
            v_end: vec![0.0; modes],
            pull: vec![0.0; modes],
            pushed: vec![0.0; modes],
            propagators: [Propagator::new(modes), Propagator::new(modes)],
            current: 0,
            equal: EqualSteps::new(&plant),
            plant,
        }
    }

    /// Completes node 0 from its modal state under the inputs at the start of `span`. A jump of a normal load since
    /// the last step is taken here. False if a law fails.
    pub fn prepare(&mut self, span: &Span) -> bool {
        self.begin_at(span, |at, input| at.normal_load != input)
    }

    /// Takes all laws to where the modal state of node 0 is. False if a law fails.
    pub fn settle(&mut self) -> bool {
        self.begin_at(&Span::START, |_, _| true)
    }

    /// Completes node 0; laws that have `moved` take a step.
    fn begin_at(&mut self, span: &Span, moved: impl Fn(&NodeContact, f64) -> bool) -> bool {
        self.geometry(0);
        for (e, contact) in self.plant.contacts.iter().enumerate() {
            let input = self.ramps[contact.input].at(span.from);
            let flexibility = self.plant.ports[contact.port].flexibility;
            let at = &mut self.nodes[e][0];
            let Some(law) = contact.law.as_deref() else {
                at.force = input;
                continue;
            };
            at.began = [at.geometric_displacement; 2];
            if !moved(at, input) {
                at.displacement = at.geometric_displacement - flexibility * at.force;
                continue;
            }
            let place = contact.memory.clone();
            let (before, next) = (&mut self.memory[place.clone()], &mut self.memory_next[place]);
            let Some(answered) =
                at.point(input, flexibility, contact.series, Answer::NONE).solve(law, before, next)
            else {
                return false;
            };
            at.store(answered, input);
            self.dissipated_energy[e] += answered.response.dissipated_energy;
            before.copy_from_slice(next);
        }
        self.force_modes(0, span.from);
        self.energy_norm = self.energy(&self.q[0], &self.v[0]);
        true
    }

    /// Commits the step tried last: node 0 and the memories move to its end. False, with the state no longer usable,
    /// if a law fails or the state is not finite.
    pub fn commit(&mut self, span: &Span) -> bool {
        std::mem::swap(&mut self.q[0], &mut self.q_end);
        std::mem::swap(&mut self.v[0], &mut self.v_end);
        if !self.drop_negligible() {
            return false;
        }
        self.geometry(0);
        for e in 0..self.plant.contacts.len() {
            if !self.commit_contact(e, span) {
                return false;
            }
        }
        std::mem::swap(&mut self.memory, &mut self.memory_next);
        self.force_modes(0, span.to);
        self.energy_norm = self.energy(&self.q[0], &self.v[0]);
        true
    }

    /// Sets what is negligible in the state to zero. False if the state is not finite.
    pub fn drop_negligible(&mut self) -> bool {
        for (q, v) in self.q[0].iter_mut().zip(&mut self.v[0]) {
            for value in [q, v] {
                if !value.is_finite() {
                    return false;
                }
                if value.abs() < NEGLIGIBLE {
                    *value = 0.0;
                }
            }
        }
        true
    }

    fn commit_contact(&mut self, e: usize, span: &Span) -> bool {
        let contact = &self.plant.contacts[e];
        let ramp = self.ramps[contact.input];
        let (middle, end) = (self.nodes[e][MIDDLE], self.nodes[e][END]);
        let at = &mut self.nodes[e][0];
        let Some(law) = contact.law.as_deref() else {
            at.force = ramp.at(span.to);
            return true;
        };
        let place = contact.memory.clone();
        let start = &self.memory[place.clone()];
        let bends = contact.remembers && !ramp.is_held();
        let (mut before, mut energy) = (start, 0.0);
        if bends {
            // Two straight pieces follow a curved path in displacement and load better.
            let bent = &mut self.memory_middle[place.clone()];
            energy = law.step(start, middle.inputs(), bent).dissipated_energy;
            before = bent;
        }
        let load = ramp.at(span.to);
        (at.force, at.tangent) = (end.force, end.tangent);
        let flexibility = self.plant.ports[contact.port].flexibility;
        let point = at.point(load, flexibility, contact.series, Answer::NONE);
        let next = &mut self.memory_next[place.clone()];
        let Some(answered) = point.solve(law, before, next) else { return false };
        at.store(answered, load);
        energy += answered.response.dissipated_energy;
        if bends {
            let straight = law.step(start, at.inputs(), &mut self.memory_middle[place]).dissipated_energy;
            energy = bent_energy(energy, straight).max(0.0);
        }
        self.dissipated_energy[e] += energy;
        true
    }

    /// Computes the modal accelerations at node 0; they last until the next attempt.
    pub fn accelerate(&mut self) {
        let (omega, zeta) = (&self.plant.angular_frequency, &self.plant.damping_ratio);
        for i in 0..omega.len() {
            self.v_end[i] = self.forcing[0][i]
                - 2.0 * zeta[i] * omega[i] * self.v[0][i]
                - omega[i] * omega[i] * self.q[0][i];
        }
    }

    /// What [`StepSolver::accelerate`] computed last.
    pub fn accelerations(&self) -> &[f64] {
        &self.v_end
    }

    /// Takes over the state of `motion`, whose lengths fit.
    pub fn load(&mut self, motion: &Motion) {
        self.q[0].copy_from_slice(motion.modal_displacement());
        self.v[0].copy_from_slice(motion.modal_velocity());
        self.memory.copy_from_slice(motion.memory());
        for (e, at) in self.nodes.iter_mut().enumerate() {
            let ContactMotion {
                force,
                tangent,
                load_tangent,
                displacement,
                normal_load,
                slip_state,
                dissipated_energy,
            } = motion.contact(e);
            self.dissipated_energy[e] = dissipated_energy;
            let known = NodeContact { force, tangent, load_tangent, slip_state, ..NodeContact::REST };
            at[0] = NodeContact { normal_load, displacement, ..known };
        }
    }

    /// Hands the state back to `motion`.
    pub fn unload(&self, motion: &mut Motion) {
        let (q, v) = motion.modal_mut();
        q.copy_from_slice(&self.q[0]);
        v.copy_from_slice(&self.v[0]);
        motion.memory_mut().copy_from_slice(&self.memory);
        for (e, [at, ..]) in self.nodes.iter().enumerate() {
            let flexibility = self.plant.ports[self.plant.contacts[e].port].flexibility;
            let contact = ContactMotion {
                force: at.force,
                tangent: at.tangent,
                load_tangent: at.load_tangent,
                displacement: at.geometric_displacement - flexibility * at.force,
                normal_load: at.normal_load,
                slip_state: at.slip_state,
                dissipated_energy: self.dissipated_energy[e],
            };
            motion.set_contact(e, &contact);
        }
    }

    /// G q, and displacement and velocity of the port of every law and outside force as the modes give them.
    pub fn geometry(&mut self, node: usize) {
        let (q, v) = (&self.q[node][..], &self.v[node][..]);
        if !self.plant.shortening.is_empty() {
            self.plant.shorten(q, &mut self.pull);
        }
        for (contact, nodes) in self.plant.contacts.iter().zip(&mut self.nodes) {
            let (at, port) = (&mut nodes[node], &self.plant.ports[contact.port]);
            (at.geometric_displacement, at.geometric_velocity) = port.motion(q, v, &self.pull);
        }
    }

    /// Modal forcing at the node whose geometry was computed last, at `fraction` of the communication step; squared
    /// change.
    pub fn force_modes(&mut self, node: usize, fraction: f64) -> f64 {
        let plant = &self.plant;
        let (q, v) = (&self.q[node], &self.v[node]);
        self.pushed.fill(0.0);
        let mut push = |port: usize, by: f64| {
            let port = &plant.ports[port];
            if port.shortening == 0.0 {
                self.pushed.iter_mut().zip(&port.row).for_each(|(p, b)| *p += by * b);
            } else {
                let gain = by * port.shortening;
                let parts = port.row.iter().zip(&self.pull);
                self.pushed.iter_mut().zip(parts).for_each(|(p, (b, g))| *p += by * b - gain * g);
            }
        };
        for (port, ramp) in plant.driven.iter().zip(&self.ramps) {
            push(*port, ramp.at(fraction));
        }
        for (contact, nodes) in plant.contacts.iter().zip(&self.nodes) {
            push(contact.port, -nodes[node].force);
        }
        for springs in &plant.springs {
            let u = springs.ports.map(|port| plant.ports[port].motion(q, v, &self.pull).0);
            for (port, force) in springs.ports.iter().zip(springs.forces(u)) {
                push(*port, -force);
            }
        }
        if !plant.damping.is_empty() {
            // Not yet needed: the accelerations at the end of a step.
            self.q_end.fill(0.0);
            add_product(&plant.damping, v, &mut self.q_end);
            self.pushed.iter_mut().zip(&self.q_end).for_each(|(p, d)| *p -= d);
        }
        let mut change = 0.0;
        for (p, value) in self.forcing[node].iter_mut().zip(&self.pushed) {
            change += (value - *p) * (value - *p);
            *p = *value;
        }
        change
    }

    /// √Σ(ω²q² + v²)
    pub fn energy(&self, q: &[f64], v: &[f64]) -> f64 {
        let terms = self.plant.angular_frequency.iter().zip(q).zip(v);
        terms.map(|((omega, q), v)| omega * omega * q * q + v * v).sum::<f64>().sqrt()
    }

    /// How far a law's port at a node yields to its unit force, spread over the step by its `weights` at the middle and at
    /// the end.
    pub fn yielding(&self, e: usize, node: usize, weights: [f64; 2]) -> f64 {
        let rows = self.propagators[self.current].node(node).iter();
        let by = rows.map(|[.., [middle, _], [end, _]]| weights[0] * middle + weights[1] * end);
        let row = &self.plant.ports[self.plant.contacts[e].port].row;
        row.iter().zip(by).map(|(b, w)| b * b * w).sum::<f64>().max(0.0)
    }
}

/// Energy (J) taken on a path that bends, from those on two straight pieces and on one: their errors are of the square of
/// a piece's length.
pub(crate) fn bent_energy(two: f64, one: f64) -> f64 {
    two + (two - one) / 3.0
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| x * x).sum::<f64>().sqrt()
}
