//! What becomes of a small change of the inputs as the beam goes through a communication step.

use super::motion::BeamMotion;
use super::propagator::NODES;
use super::step::{Span, StepSolver};
use super::trial::{END, MIDDLE};
use super::{Contact, Ramp};
use crate::contact::{Carried, ContactLaw, Inputs, Tangents};

/// Sweeps over the weak terms of the linear collocation equations; each gains several digits.
const SWEEPS: usize = 30;
/// Change of the forcing, relative, at which the sweeps end.
const SETTLED: f64 = 1e-13;

/// Change of the inputs of a beam over a communication step, to first order.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BeamInputChange<'a> {
    /// Of the exciter's force (N).
    pub excitation: Ramp,
    /// Of the contact force, or of the normal load where the beam has a contact (N).
    pub contact: Ramp,
    /// Of the forces at the contact points (N).
    pub at_points: &'a [Ramp],
}

/// Change of the motion, to first order: the linearised step, with the coefficients of the step itself.
#[derive(Debug, Clone, Default)]
pub(crate) struct BeamChange {
    /// Of the modal displacements and velocities at the nodes; node 0 is the present.
    q: [Vec<f64>; 5],
    v: [Vec<f64>; 5],
    /// Of the forcing: all of it, and without the contact force.
    p: [Vec<f64>; 5],
    rest: [Vec<f64>; 5],
    start_q: [Vec<f64>; 5],
    start_v: [Vec<f64>; 5],
    /// c − G q and G q̇ at the nodes.
    direction: [Vec<f64>; 5],
    turning: [Vec<f64>; 5],
    /// Modal accelerations at the end.
    pub acceleration: Vec<f64>,
    product: Vec<f64>,
    carried: Carried,
    unused: Vec<f64>,
    /// Of the contact force (N), of ∂T/∂u (N/m) and of the dissipated energy (J).
    pub force: f64,
    pub tangent: f64,
    pub dissipated_energy: f64,
}

/// The contact at a node to first order: `δT = tangents · δinputs + by_memory`.
#[derive(Debug, Clone, Copy, Default)]
struct NodeChange {
    tangents: Tangents,
    by_memory: f64,
    load: f64,
    force: f64,
}

impl BeamChange {
    /// No change of `motion` yet, which `solver` has loaded but not prepared.
    pub fn begin(&mut self, solver: &StepSolver, motion: &BeamMotion) {
        let n = solver.q[0].len();
        let lists = [&mut self.q, &mut self.v, &mut self.p, &mut self.rest, &mut self.start_q];
        let more = [&mut self.start_v, &mut self.direction, &mut self.turning];
        let single = [&mut self.acceleration, &mut self.product];
        for list in lists.into_iter().chain(more).flatten().chain(single) {
            list.clear();
            list.resize(n, 0.0);
        }
        self.unused.clear();
        self.unused.resize(motion.contact_state().len(), 0.0);
        self.carried.begin(motion.contact_state());
        (self.force, self.tangent, self.dissipated_energy) = (0.0, 0.0, 0.0);
    }

    /// At rest, with a contact that remembers nothing but its load (N).
    pub fn begin_at_rest(&mut self, law: &dyn ContactLaw, load: f64, load_change: f64) {
        self.carried.rest(law, load, load_change);
    }

    /// A jump of the normal load, or of its change, at the start of the communication step; `solver` is prepared.
    pub fn jump(&mut self, solver: &StepSolver, contact: &Contact, by: &BeamInputChange, jumped: bool) {
        let Contact::Friction { law, normal_load } = contact else {
            self.force = by.contact.start;
            return;
        };
        if jumped || by.contact.start != 0.0 {
            self.contact_step(solver, *law, 0, normal_load.start, (0.0, 0.0, by.contact.start));
        }
    }

    /// The law's step to node `node`, with the inputs' change `(geometric displacement, its rate, load)`.
    fn contact_step(
        &mut self,
        solver: &StepSolver,
        law: &dyn ContactLaw,
        node: usize,
        load: f64,
        (displacement, velocity, load_change): (f64, f64, f64),
    ) {
        let flexibility = solver.beam.axial_flexibility;
        let inputs = inputs(solver, node, load);
        let t = law.step(&self.carried.memory, inputs, &mut self.unused).tangents;
        let by_memory = self.carried.force_by_memory(law, inputs);
        let slope = 1.0 + flexibility * t.displacement;
        let velocity = velocity / slope;
        let force =
            (t.displacement * displacement + t.velocity * velocity + t.normal_load * load_change + by_memory)
                / slope;
        let by =
            Inputs { displacement: displacement - flexibility * force, velocity, normal_load: load_change };
        let change = self.carried.step(law, inputs, by);
        self.force = force;
        self.tangent = change.tangent;
        self.dissipated_energy += change.dissipated_energy;
    }

    /// Goes through the step that `solver` has tried with success and not yet committed.
    pub fn through(&mut self, solver: &StepSolver, span: &Span, by: &BeamInputChange) {
        for node in 0..=END {
            times(&solver.beam.shortening, &solver.q[node], &mut self.product);
            let shape = solver.beam.contact_shape.iter().zip(&self.product);
            self.direction[node].iter_mut().zip(shape).for_each(|(d, (c, g))| *d = c - g);
            times(&solver.beam.shortening, &solver.v[node], &mut self.turning[node]);
        }
        let at = |ramp: Ramp, node: usize| ramp.at(span.fraction(NODES[node]));
        self.force_without_contact(solver, 0, by, span.from);
        self.add_contact(0, self.force);
        let mut nodes = [NodeChange::default(); 5];
        for (node, contact) in nodes.iter_mut().enumerate().skip(1) {
            contact.load = at(by.contact, node);
            if let Contact::Friction { law, normal_load } = span.inputs.contact {
                let inputs = inputs(solver, node, normal_load.at(span.fraction(NODES[node])));
                contact.tangents = law.step(&self.carried.memory, inputs, &mut self.unused).tangents;
                contact.by_memory = self.carried.force_by_memory(law, inputs);
            } else {
                contact.force = contact.load;
            }
        }
        self.start(solver);
        self.collocate(solver, span, by, &mut nodes);
        for node in [1, 3] {
            self.place(solver, node, |change| &change.p);
            if let Contact::Friction { .. } = span.inputs.contact {
                let own = self.own_force(&nodes[node], node);
                nodes[node].force =
                    own / (1.0 + solver.beam.axial_flexibility * nodes[node].tangents.displacement);
            }
            self.force_without_contact(solver, node, by, span.fraction(NODES[node]));
            self.add_contact(node, nodes[node].force);
        }
        self.finish(solver, span, &nodes);
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
        for node in [MIDDLE, END] {
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

    /// Middle and end of the step: the contact forces solved for, the weak terms by sweeps.
    fn collocate(
        &mut self,
        solver: &StepSolver,
        span: &Span,
        by: &BeamInputChange,
        nodes: &mut [NodeChange; 5],
    ) {
        let pair = [MIDDLE, END];
        let friction = matches!(span.inputs.contact, Contact::Friction { .. });
        let rows = pair.map(|node| solver.propagators[solver.current].node(node).q_forcing);
        // How far unit forces at both nodes move the contact at both.
        let yielding = pair.map(|j| {
            let row = usize::from(j == END);
            [0, 1].map(|k| -> f64 {
                let (a, b) = (&self.direction[j], &self.direction[pair[k]]);
                a.iter().zip(b).zip(rows[row][k]).map(|((a, b), w)| a * b * w).sum()
            })
        });
        for _ in 0..SWEEPS {
            let mut moved = 0.0_f64;
            for node in pair {
                self.force_without_contact(solver, node, by, span.fraction(NODES[node]));
            }
            if friction {
                for node in pair {
                    self.place(solver, node, |change| &change.rest);
                }
                let free = pair.map(|node| self.own_force(&nodes[node], node));
                let tangent = pair.map(|node| nodes[node].tangents.displacement);
                let a = solver.beam.axial_flexibility;
                let m: [[f64; 2]; 2] = std::array::from_fn(|j| {
                    std::array::from_fn(|k| {
                        let own = if j == k { 1.0 + a * tangent[j] } else { 0.0 };
                        own + tangent[j] * yielding[j][k]
                    })
                });
                let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
                nodes[MIDDLE].force = (m[1][1] * free[0] - m[0][1] * free[1]) / determinant;
                nodes[END].force = (m[0][0] * free[1] - m[1][0] * free[0]) / determinant;
            }
            let mut size = 0.0_f64;
            for node in pair {
                for (p, (rest, d)) in
                    self.p[node].iter_mut().zip(self.rest[node].iter().zip(&self.direction[node]))
                {
                    let value = rest - nodes[node].force * d;
                    moved = moved.max((value - *p).abs());
                    size = size.max(value.abs());
                    *p = value;
                }
            }
            for node in pair {
                self.place(solver, node, |change| &change.p);
            }
            if moved <= SETTLED * size {
                return;
            }
        }
    }

    /// The law's part of the change of force at a node, its own yielding left out (N).
    fn own_force(&self, contact: &NodeChange, node: usize) -> f64 {
        let (displacement, velocity) = self.geometric(node);
        let t = contact.tangents;
        t.displacement * displacement
            + t.velocity * velocity
            + t.normal_load * contact.load
            + contact.by_memory
    }

    /// Changes of the contact's geometric displacement and velocity at a node.
    fn geometric(&self, node: usize) -> (f64, f64) {
        let along = |direction: &[f64], change: &[f64]| dot(direction, change);
        let displacement = along(&self.direction[node], &self.q[node]);
        (
            displacement,
            along(&self.direction[node], &self.v[node]) - along(&self.turning[node], &self.q[node]),
        )
    }

    /// Change of the forcing at a node, at `fraction` of the communication step, but for that of the contact force.
    fn force_without_contact(
        &mut self,
        solver: &StepSolver,
        node: usize,
        by: &BeamInputChange,
        fraction: f64,
    ) {
        let (beam, force) = (&solver.beam, solver.nodes[node].force);
        let mut excitation = by.excitation.at(fraction);
        if beam.quadratic_damping != 0.0 {
            let speed = dot(&beam.excitation_shape, &solver.v[node]);
            excitation -=
                2.0 * beam.quadratic_damping * speed.abs() * dot(&beam.excitation_shape, &self.v[node]);
        }
        times(&beam.shortening, &self.q[node], &mut self.product);
        let (mut tension, mut shortened) = ((0.0, 0.0), 0.0);
        if beam.pulls_along() {
            let pull = beam.contact_shape.iter().zip(&self.direction[node]).map(|(c, d)| c - d);
            let sums = pull.zip(solver.q[node].iter().zip(&self.q[node]));
            let (twice, change) = sums.fold((0.0, 0.0), |sum, (g, (q, dq))| (sum.0 + g * q, sum.1 + g * dq));
            tension.0 = beam.stretching_stiffness * twice - beam.string_pull(&solver.q[node]);
            tension.1 = 2.0 * beam.stretching_stiffness * change - beam.string_pull(&self.q[node]);
            shortened = change;
        }
        let rest = &mut self.rest[node];
        beam.push(excitation, by.at_points.iter().map(|ramp| ramp.at(fraction)), rest);
        for (i, rest) in rest.iter_mut().enumerate() {
            let pull = beam.contact_shape[i] - self.direction[node][i];
            *rest = *rest + (force - tension.0) * self.product[i] - tension.1 * pull;
        }
        for (rest, s) in rest.iter_mut().zip(&beam.string_stretch) {
            *rest += beam.string_stiffness * shortened * s;
        }
    }

    fn add_contact(&mut self, node: usize, force: f64) {
        let parts = self.rest[node].iter().zip(&self.direction[node]);
        self.p[node].iter_mut().zip(parts).for_each(|(p, (rest, d))| *p = rest - force * d);
    }

    /// The end of the step from the quartic, and the middle of a step under a load that runs.
    fn finish(&mut self, solver: &StepSolver, span: &Span, nodes: &[NodeChange; 5]) {
        if let Contact::Friction { law, normal_load } = span.inputs.contact
            && normal_load.start != normal_load.end
        {
            let (displacement, velocity) = self.geometric(MIDDLE);
            let load = solver.nodes[MIDDLE].normal_load;
            self.contact_step(solver, law, MIDDLE, load, (displacement, velocity, nodes[MIDDLE].load));
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

    /// The contact and the forcing at the end of the step, which `solver` has committed.
    pub fn arrive(&mut self, solver: &StepSolver, contact: &Contact, fraction: f64, by: &BeamInputChange) {
        times(&solver.beam.shortening, &solver.v[0], &mut self.turning[0]);
        self.direction[0].copy_from_slice(&solver.direction);
        match contact {
            Contact::Force(_) => self.force = by.contact.at(fraction),
            Contact::Friction { law, normal_load } => {
                let (displacement, velocity) = self.geometric(0);
                let change = (displacement, velocity, by.contact.at(fraction));
                self.contact_step(solver, *law, 0, normal_load.at(fraction), change);
            }
        }
        self.force_without_contact(solver, 0, by, fraction);
        self.add_contact(0, self.force);
    }

    /// Computes the change of the accelerations, and gives those of displacement (m) and velocity (m/s) of the
    /// contact, whose load changes at `load_rate` (N/s). `rate_change` is the change of that rate, or of the rate of
    /// an external force (N/s).
    pub fn outputs(
        &mut self,
        solver: &StepSolver,
        contact: &Contact,
        load_rate: f64,
        rate_change: f64,
    ) -> (f64, f64) {
        let beam = &solver.beam;
        for i in 0..self.acceleration.len() {
            let (omega, zeta) = (beam.angular_frequency[i], beam.damping_ratio[i]);
            self.acceleration[i] =
                self.p[0][i] - 2.0 * zeta * omega * self.v[0][i] - omega * omega * self.q[0][i];
        }
        let (displacement, velocity) = self.geometric(0);
        let a = beam.axial_flexibility;
        let velocity = match contact {
            Contact::Force(_) => velocity - a * rate_change,
            Contact::Friction { .. } => {
                let node = &solver.nodes[0];
                let slope = 1.0 + a * node.tangent;
                let yielded = self.tangent * node.velocity(a, load_rate) + node.load_tangent * rate_change;
                (velocity - a * yielded) / slope
            }
        };
        (displacement - a * self.force, velocity)
    }

    /// Change of what a sensor of this shape reads: displacement, velocity, acceleration.
    pub fn sensor(&self, shape: &[f64]) -> [f64; 3] {
        [dot(shape, &self.q[0]), dot(shape, &self.v[0]), dot(shape, &self.acceleration)]
    }
}

fn inputs(solver: &StepSolver, node: usize, normal_load: f64) -> Inputs {
    let contact = &solver.nodes[node];
    let velocity = contact.geometric_velocity / (1.0 + solver.beam.axial_flexibility * contact.tangent);
    Inputs { displacement: contact.displacement, velocity, normal_load }
}

/// `out = G x`, G symmetric.
fn times(matrix: &[f64], x: &[f64], out: &mut [f64]) {
    for (out, row) in out.iter_mut().zip(matrix.chunks_exact(x.len())) {
        *out = dot(row, x);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
