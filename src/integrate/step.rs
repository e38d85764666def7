//! One trial step: collocation, correction, error estimate and events.

use super::contact_point::ContactPoint;
use super::events::{self, Reversal};
use super::motion::BeamMotion;
use super::propagator::{NODES, Propagator};
use super::{BeamInputs, Contact};
use crate::contact::SlipState;
use crate::structure::ModalBeam;

/// Nodes of the quadratic through the forcing.
const MIDDLE: usize = 2;
const END: usize = 4;
/// Sweeps before a step counts as not converging; convergence is about a digit a sweep or better.
const SWEEPS: usize = 12;
/// No finer than this part of the limit is the force asked to follow a normal load that varies within
/// a step: there a law may be accurate to first order in the step only.
const FINEST_PATH: f64 = 1e-4;
/// Amplitudes below this are set to zero: denormal numbers are ten times slower.
const NEGLIGIBLE: f64 = 1e-150;

/// The contact at one node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeContact {
    pub force: f64,
    pub tangent: f64,
    pub load_tangent: f64,
    pub slip_state: SlipState,
    pub normal_load: f64,
    /// u (m).
    pub displacement: f64,
    /// u + a T (m) and its derivative (m/s): what the modes alone give.
    pub geometric_displacement: f64,
    pub geometric_velocity: f64,
}

impl NodeContact {
    const REST: Self = Self {
        force: 0.0,
        tangent: 0.0,
        load_tangent: 0.0,
        slip_state: SlipState::Stick,
        normal_load: 0.0,
        displacement: 0.0,
        geometric_displacement: 0.0,
        geometric_velocity: 0.0,
    };

    /// u̇ (m/s) for a normal load that changes at `load_rate` (N/s), `flexibility` a (m/N).
    pub fn velocity(&self, flexibility: f64, load_rate: f64) -> f64 {
        (self.geometric_velocity - flexibility * self.load_tangent * load_rate)
            / (1.0 + flexibility * self.tangent)
    }
}

/// The part of a communication step that a trial step covers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span<'a> {
    pub inputs: &'a BeamInputs<'a>,
    /// Length of the trial step (s).
    pub step: f64,
    /// Its ends as fractions of the communication step.
    pub from: f64,
    pub to: f64,
    /// Rate of the normal load (N/s).
    pub load_rate: f64,
}

impl Span<'_> {
    fn fraction(&self, node: f64) -> f64 {
        if node >= 1.0 { self.to } else { self.from + node * (self.to - self.from) }
    }
}

/// What a trial step found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Trial {
    /// No convergence, or the law gave no finite force: try a shorter step.
    Diverged,
    /// Error estimate relative to the tolerance, and the first event as a fraction of the step.
    Done { error: f64, event: Option<f64> },
}

/// The working state and the buffers of a step. After construction nothing allocates.
#[derive(Debug, Clone)]
pub(crate) struct StepSolver {
    pub beam: ModalBeam,
    /// Modal displacements, velocities and forcing at the five nodes; node 0 is the state.
    pub q: [Vec<f64>; 5],
    pub v: [Vec<f64>; 5],
    forcing: [Vec<f64>; 5],
    pub nodes: [NodeContact; 5],
    /// Contact memory at the start; behind the middle; behind the end.
    pub contact: Vec<f64>,
    contact_middle: Vec<f64>,
    contact_next: Vec<f64>,
    pub dissipated_energy: f64,
    /// Energy norm of the state, and of the contact shape.
    energy_norm: f64,
    shape_norm: f64,
    /// Energy norm of the modal displacements under a unit contact force.
    compliance_norm: f64,
    /// The part of the node states due to the start of the step.
    q_start: [Vec<f64>; 5],
    v_start: [Vec<f64>; 5],
    q_end: Vec<f64>,
    v_end: Vec<f64>,
    /// c − G q at the node evaluated last.
    direction: Vec<f64>,
    /// Coefficients for the two step sizes used last.
    propagators: [Propagator; 2],
    current: usize,
}

impl StepSolver {
    pub fn new(beam: &ModalBeam) -> Self {
        let modes = beam.angular_frequency.len();
        let per_node = || std::array::from_fn(|_| vec![0.0; modes]);
        Self {
            beam: beam.clone(),
            q: per_node(),
            v: per_node(),
            forcing: per_node(),
            nodes: [NodeContact::REST; 5],
            contact: Vec::new(),
            contact_middle: Vec::new(),
            contact_next: Vec::new(),
            dissipated_energy: 0.0,
            energy_norm: 0.0,
            shape_norm: norm(beam.contact_shape.iter().copied()),
            compliance_norm: norm(
                beam.contact_shape.iter().zip(&beam.angular_frequency).map(|(c, omega)| c / omega),
            ),
            q_start: per_node(),
            v_start: per_node(),
            q_end: vec![0.0; modes],
            v_end: vec![0.0; modes],
            direction: vec![0.0; modes],
            propagators: [Propagator::new(modes), Propagator::new(modes)],
            current: 0,
        }
    }

    /// Makes room for a contact memory; allocates only when it grows.
    pub fn reserve_contact(&mut self, len: usize) {
        for buffer in [&mut self.contact, &mut self.contact_middle, &mut self.contact_next] {
            buffer.resize(len, 0.0);
        }
    }

    /// Fills node 0 from its modal state and the contact force at the start of `span`. Under friction
    /// a jump of the normal load since the last step is taken here. False if the law fails.
    pub fn prepare(&mut self, span: &Span) -> bool {
        self.geometry(0);
        let fraction = span.from;
        match span.inputs.contact {
            Contact::Force(force) => {
                self.nodes[0] = NodeContact {
                    force: force.at(fraction),
                    tangent: 0.0,
                    load_tangent: 0.0,
                    slip_state: SlipState::Stick,
                    normal_load: 0.0,
                    ..self.nodes[0]
                };
            }
            Contact::Friction { law, normal_load } => {
                let load = normal_load.at(fraction);
                if load != self.nodes[0].normal_load {
                    let point = self.point(0, load, 0.0);
                    let Some((response, displacement)) =
                        point.solve(law, &self.contact, &mut self.contact_next)
                    else {
                        return false;
                    };
                    self.store(0, response, displacement, load);
                    self.dissipated_energy += response.dissipated_energy;
                    std::mem::swap(&mut self.contact, &mut self.contact_next);
                } else {
                    let contact = &mut self.nodes[0];
                    contact.displacement -= self.beam.axial_flexibility * contact.force;
                }
            }
        }
        self.force_modes(0, span.inputs.excitation.at(fraction));
        self.energy_norm = self.energy(&self.q[0], &self.v[0]);
        true
    }

    /// Tries a step of `span.step` to the relative `tolerance`.
    pub fn attempt(&mut self, span: &Span, tolerance: f64) -> Trial {
        self.select_propagator(span.step);
        self.begin();
        if !self.collocate(span, tolerance) {
            return Trial::Diverged;
        }
        for node in [1, 3] {
            self.place(node);
            if self.evaluate(node, span, 0.0).is_none() {
                return Trial::Diverged;
            }
        }
        let error = self.correct(span, tolerance);
        if !error.is_finite() {
            return Trial::Diverged;
        }
        Trial::Done { error, event: self.event(span, tolerance) }
    }

    /// Commits the step tried last: node 0 and the contact memory move to its end. False, with the
    /// state no longer usable, if the law fails or the state is not finite.
    pub fn commit(&mut self, span: &Span) -> bool {
        std::mem::swap(&mut self.q[0], &mut self.q_end);
        std::mem::swap(&mut self.v[0], &mut self.v_end);
        for value in self.q[0].iter_mut().chain(&mut self.v[0]) {
            if !value.is_finite() {
                return false;
            }
            if value.abs() < NEGLIGIBLE {
                *value = 0.0;
            }
        }
        self.geometry(0);
        match span.inputs.contact {
            Contact::Force(force) => self.nodes[0].force = force.at(span.to),
            Contact::Friction { law, normal_load } => {
                if normal_load.start != normal_load.end {
                    // Two straight pieces follow a curved path in displacement and load better.
                    let middle = self.nodes[MIDDLE];
                    let inputs = crate::contact::Inputs {
                        displacement: middle.displacement,
                        velocity: middle.geometric_velocity,
                        normal_load: middle.normal_load,
                    };
                    let response = law.step(&self.contact, inputs, &mut self.contact_middle);
                    self.dissipated_energy += response.dissipated_energy;
                    std::mem::swap(&mut self.contact, &mut self.contact_middle);
                }
                let load = normal_load.at(span.to);
                self.nodes[0].force = self.nodes[END].force;
                self.nodes[0].tangent = self.nodes[END].tangent;
                let point = self.point(0, load, 0.0);
                let Some((response, displacement)) = point.solve(law, &self.contact, &mut self.contact_next)
                else {
                    return false;
                };
                self.store(0, response, displacement, load);
                self.dissipated_energy += response.dissipated_energy;
                std::mem::swap(&mut self.contact, &mut self.contact_next);
            }
        }
        self.force_modes(0, span.inputs.excitation.at(span.to));
        self.energy_norm = self.energy(&self.q[0], &self.v[0]);
        true
    }

    /// Computes the modal accelerations at node 0; they last until the next attempt.
    pub fn accelerate(&mut self) {
        let (omega, zeta) = (&self.beam.angular_frequency, &self.beam.damping_ratio);
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
    pub fn load(&mut self, motion: &BeamMotion) {
        self.q[0].copy_from_slice(motion.modal_displacement());
        self.v[0].copy_from_slice(motion.modal_velocity());
        self.contact.copy_from_slice(motion.contact_state());
        self.dissipated_energy = motion.dissipated_energy();
        let slip_state = motion.slip_state();
        self.nodes[0] = NodeContact {
            force: motion.contact_force(),
            tangent: motion.tangent(),
            load_tangent: motion.load_tangent(),
            slip_state: [SlipState::Stick, SlipState::Slip, SlipState::Separated]
                .into_iter()
                .find(|&state| f64::from(state as i32) == slip_state)
                .unwrap_or(SlipState::Stick),
            normal_load: motion.normal_load(),
            displacement: motion.displacement(),
            ..NodeContact::REST
        };
    }

    /// Hands the state back to `motion`, the contact's memory only if it took part.
    pub fn unload(&self, motion: &mut BeamMotion, friction: bool) {
        let contact = &self.nodes[0];
        motion.modal_displacement_mut().copy_from_slice(&self.q[0]);
        motion.modal_velocity_mut().copy_from_slice(&self.v[0]);
        motion.set_contact_force(contact.force);
        motion.set_displacement(contact.geometric_displacement - self.beam.axial_flexibility * contact.force);
        if friction {
            motion.contact_state_mut().copy_from_slice(&self.contact);
            motion.set_tangent(contact.tangent);
            motion.set_load_tangent(contact.load_tangent);
            motion.set_normal_load(contact.normal_load);
            motion.set_slip_state(f64::from(contact.slip_state as i32));
            motion.set_dissipated_energy(self.dissipated_energy);
        }
    }

    fn select_propagator(&mut self, step: f64) {
        if self.propagators[self.current].is_for(step) {
            return;
        }
        self.current = 1 - self.current;
        let propagator = &mut self.propagators[self.current];
        if !propagator.is_for(step) {
            propagator.fill(&self.beam.angular_frequency, &self.beam.damping_ratio, step);
        }
    }

    /// What the state and the forcing at the start contribute to the nodes.
    fn begin(&mut self) {
        let (q, v, p) = (&self.q[0], &self.v[0], &self.forcing[0]);
        for node in 1..=END {
            let rows = self.propagators[self.current].node(node);
            weigh(&mut self.q_start[node], rows.q_start, [q, v, p]);
            weigh(&mut self.v_start[node], rows.v_start, [q, v, p]);
        }
        let (first, rest) = self.forcing.split_at_mut(1);
        rest[MIDDLE - 1].copy_from_slice(&first[0]);
        rest[END - 1].copy_from_slice(&first[0]);
        for node in 1..=END {
            self.nodes[node] = self.nodes[0];
        }
    }

    /// Modal state at a node from the quadratic forcing.
    fn place(&mut self, node: usize) {
        let rows = self.propagators[self.current].node(node);
        let forcing = [&self.forcing[MIDDLE][..], &self.forcing[END][..]];
        add_weighed(&mut self.q[node], &self.q_start[node], rows.q_forcing, forcing);
        add_weighed(&mut self.v[node], &self.v_start[node], rows.v_forcing, forcing);
    }

    /// Solves the collocation equations by sweeps; false if they do not converge.
    fn collocate(&mut self, span: &Span, tolerance: f64) -> bool {
        let mut previous = f64::INFINITY;
        for sweep in 0..SWEEPS {
            self.place(MIDDLE);
            let yielding = self.own_flexibility(MIDDLE);
            let Some(middle) = self.evaluate(MIDDLE, span, yielding) else { return false };
            if sweep == 0 {
                self.extrapolate_end();
            }
            self.place(END);
            let yielding = self.own_flexibility(END);
            let Some(end) = self.evaluate(END, span, yielding) else { return false };
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
        self.nodes[END] = self.nodes[MIDDLE];
        self.nodes[END].force = 2.0 * self.nodes[MIDDLE].force - self.nodes[0].force;
    }

    /// How far a unit force at a node, spread by the quadratic, moves the same node: with it the
    /// force answers to itself within a sweep. Zero is always legal, only slower.
    fn own_flexibility(&self, node: usize) -> f64 {
        let rows = self.propagators[self.current].node(node).q_forcing;
        let own = if node == MIDDLE { rows[0] } else { rows[1] };
        let shape = &self.beam.contact_shape;
        shape.iter().zip(own).map(|(c, w)| c * c * w).sum::<f64>().max(0.0)
    }

    /// Contact and forcing at a placed node; squared change of the forcing, or `None` if the law
    /// fails. `yielding` (m/N) is the node's own flexibility.
    fn evaluate(&mut self, node: usize, span: &Span, yielding: f64) -> Option<f64> {
        self.geometry(node);
        let fraction = span.fraction(NODES[node]);
        match span.inputs.contact {
            Contact::Force(force) => self.nodes[node].force = force.at(fraction),
            Contact::Friction { law, normal_load } => {
                let load = normal_load.at(fraction);
                let point = self.point(node, load, yielding);
                let (response, displacement) = point.solve(law, &self.contact, &mut self.contact_next)?;
                self.store(node, response, displacement, load);
            }
        }
        Some(self.force_modes(node, span.inputs.excitation.at(fraction)))
    }

    /// c − G q, and the contact's displacement and velocity as the modes give them.
    pub fn geometry(&mut self, node: usize) {
        let (q, v) = (&self.q[node][..], &self.v[node][..]);
        let shape = &self.beam.contact_shape[..];
        let direction = &mut self.direction[..];
        direction.copy_from_slice(shape);
        // Symmetric, so a column is a row, and the inner loop runs over neighbours.
        for (column, &amplitude) in self.beam.shortening.chunks_exact(q.len()).zip(q) {
            for (d, g) in direction.iter_mut().zip(column) {
                *d -= g * amplitude;
            }
        }
        let (mut displacement, mut velocity) = (0.0, 0.0);
        for (((&d, &c), &q), &v) in direction.iter().zip(shape).zip(q).zip(v) {
            // c·q − ½ qᵀGq = ½ (c + d)·q
            displacement += 0.5 * (c + d) * q;
            velocity += d * v;
        }
        let contact = &mut self.nodes[node];
        contact.geometric_displacement = displacement;
        contact.geometric_velocity = velocity;
        contact.displacement = displacement;
    }

    fn point(&self, node: usize, normal_load: f64, yielding: f64) -> ContactPoint {
        let contact = &self.nodes[node];
        ContactPoint {
            displacement: contact.geometric_displacement + yielding * contact.force,
            velocity: contact.geometric_velocity / (1.0 + self.beam.axial_flexibility * contact.tangent),
            flexibility: self.beam.axial_flexibility + yielding,
            normal_load,
            guess: contact.force,
        }
    }

    fn store(&mut self, node: usize, response: crate::contact::Response, displacement: f64, load: f64) {
        let contact = &mut self.nodes[node];
        contact.force = response.force;
        contact.tangent = response.tangents.displacement;
        contact.load_tangent = response.tangents.normal_load;
        contact.slip_state = response.slip_state;
        contact.normal_load = load;
        contact.displacement = displacement;
    }

    /// Modal forcing at the node whose geometry was computed last; squared change.
    fn force_modes(&mut self, node: usize, excitation: f64) -> f64 {
        let force = self.nodes[node].force;
        let mut change = 0.0;
        let shapes = self.beam.excitation_shape.iter().zip(&self.direction);
        for (p, (phi, d)) in self.forcing[node].iter_mut().zip(shapes) {
            let value = excitation * phi - force * d;
            change += (value - *p) * (value - *p);
            *p = value;
        }
        change
    }

    /// End state from the quartic through all five nodes; returns the error estimate relative to
    /// the tolerance.
    fn correct(&mut self, span: &Span, tolerance: f64) -> f64 {
        let propagator = &self.propagators[self.current];
        let start = propagator.node(END);
        let (q_rows, v_rows) = (propagator.quartic_q(), propagator.quartic_v());
        let p: [&[f64]; 5] = std::array::from_fn(|j| &self.forcing[j][..]);
        let (mut error, mut norm) = (0.0, 0.0);
        for (i, &omega) in self.beam.angular_frequency.iter().enumerate() {
            let (q0, v0) = (self.q[0][i], self.v[0][i]);
            let mut q = start.q_start[0][i] * q0 + start.q_start[1][i] * v0;
            let mut v = start.v_start[0][i] * q0 + start.v_start[1][i] * v0;
            for j in 0..5 {
                q += q_rows[j][i] * p[j][i];
                v += v_rows[j][i] * p[j][i];
            }
            self.q_end[i] = q;
            self.v_end[i] = v;
            let (dq, dv) = (omega * (q - self.q[END][i]), v - self.v[END][i]);
            error += dq * dq + dv * dv;
            norm += omega * omega * q * q + v * v;
        }
        let scale = self.energy_norm.max(norm.sqrt());
        let modal = if error == 0.0 { 0.0 } else { error.sqrt() / (tolerance * scale) };
        modal.max(self.path_error(span, tolerance))
    }

    /// A law takes displacement and normal load to run linearly together within a step, but they
    /// curve; what a stop at the middle changes in the force, relative to the tolerance and the limit.
    fn path_error(&mut self, span: &Span, tolerance: f64) -> f64 {
        let Contact::Friction { law, normal_load } = span.inputs.contact else { return 0.0 };
        if normal_load.start == normal_load.end {
            return 0.0;
        }
        let inputs = |contact: &NodeContact| crate::contact::Inputs {
            displacement: contact.displacement,
            velocity: contact.geometric_velocity,
            normal_load: contact.normal_load,
        };
        law.step(&self.contact, inputs(&self.nodes[MIDDLE]), &mut self.contact_middle);
        let end = &self.nodes[END];
        let direct = law.step(&self.contact, inputs(end), &mut self.contact_next).force;
        let bent = law.step(&self.contact_middle, inputs(end), &mut self.contact_next).force;
        let limit = law.limit(end.normal_load).max(law.limit(self.nodes[0].normal_load));
        // About to lift off the limit vanishes; what then counts is what a force does to the beam.
        let scale = limit.max(end.force.abs()).max(0.01 * self.energy_norm / self.compliance_norm);
        if direct == bent { 0.0 } else { (direct - bent).abs() / (tolerance.max(FINEST_PATH) * scale) }
    }

    /// The first event of the step tried, unless it is its end.
    fn event(&mut self, span: &Span, tolerance: f64) -> Option<f64> {
        let Contact::Friction { law, normal_load } = span.inputs.contact else { return None };
        let flexibility = self.beam.axial_flexibility;
        let velocity = self.nodes.map(|node| node.velocity(flexibility, span.load_rate));
        let displacement = self.nodes.map(|node| node.displacement);
        // Motion this small is invisible at the tolerance; what is left of it may be rounding.
        let norm = self.shape_norm * self.energy_norm;
        let floor = (1e-6 * tolerance).max(1e-13) * norm;
        let size = displacement.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        let rounding = 64.0 * f64::EPSILON * size + 1e-7 * span.step * floor;
        let mut first = match events::reversal(&velocity, &displacement, floor, rounding) {
            Reversal::None => f64::INFINITY,
            Reversal::At(fraction) => fraction,
            Reversal::Hidden => 0.5,
        };
        let mut slip = self.nodes.map(|node| node.slip_state);
        let nodes = self.nodes;
        let constant = normal_load.start == normal_load.end;
        let (contact, before, next) = (&self.contact, &mut self.contact_middle, &mut self.contact_next);
        let point = |node: usize, at: f64| {
            let (u, v) = hermite(&nodes[node], &nodes[node + 1], span.step, (at - NODES[node]) * 4.0);
            ContactPoint {
                displacement: u,
                velocity: v,
                flexibility,
                normal_load: normal_load.at(span.fraction(at)),
                guess: nodes[node].force,
            }
        };
        let mut probe = |node: usize, at: f64| {
            let mut from = contact;
            if !constant {
                point(node, at - events::LOOK_BACK).solve(law, contact, before)?;
                from = before;
            }
            point(node, at).solve(law, from, next).map(|(response, _)| response.slip_state)
        };
        // The state committed belongs to the step before: a contact that slipped up to a reversal sticks.
        if let Some(state) = probe(0, events::JUST_BEHIND_START) {
            slip[0] = state;
        }
        let parts = if constant { 1 } else { events::PROBES };
        if let Some(fraction) = events::corner(&slip, parts, probe) {
            first = first.min(fraction);
        }
        (first < 1.0).then_some(first)
    }

    /// √Σ(ω²q² + v²)
    fn energy(&self, q: &[f64], v: &[f64]) -> f64 {
        let terms = self.beam.angular_frequency.iter().zip(q).zip(v);
        terms.map(|((omega, q), v)| omega * omega * q * q + v * v).sum::<f64>().sqrt()
    }
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| x * x).sum::<f64>().sqrt()
}

fn weigh(out: &mut [f64], rows: [&[f64]; 3], by: [&Vec<f64>; 3]) {
    let n = out.len();
    let rows = rows.map(|row| &row[..n]);
    let by = by.map(|values| &values[..n]);
    for i in 0..n {
        out[i] = rows[0][i] * by[0][i] + rows[1][i] * by[1][i] + rows[2][i] * by[2][i];
    }
}

fn add_weighed(out: &mut [f64], start: &[f64], rows: [&[f64]; 2], by: [&[f64]; 2]) {
    let n = out.len();
    let start = &start[..n];
    let rows = rows.map(|row| &row[..n]);
    let by = by.map(|values| &values[..n]);
    for i in 0..n {
        out[i] = start[i] + rows[0][i] * by[0][i] + rows[1][i] * by[1][i];
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
