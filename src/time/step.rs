//! The state within a communication step: what is at its start, and taking over a step.

use super::contact_point::ContactPoint;
use super::motion::BeamMotion;
use super::propagator::Propagator;
use super::trial::{END, MIDDLE};
use super::{BeamInputs, Contact};
use crate::contact::SlipState;
use crate::system::ModalBeam;

/// Amplitudes below this are set to zero: denormal numbers are ten times slower.
pub(crate) const NEGLIGIBLE: f64 = 1e-150;

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
    pub fn fraction(&self, node: f64) -> f64 {
        if node >= 1.0 { self.to } else { self.from + node * (self.to - self.from) }
    }
}

/// The working state and the buffers of a step. After construction nothing allocates.
#[derive(Debug, Clone)]
pub(crate) struct StepSolver {
    pub beam: ModalBeam,
    /// Modal displacements, velocities and forcing at the five nodes; node 0 is the state.
    pub q: [Vec<f64>; 5],
    pub v: [Vec<f64>; 5],
    pub forcing: [Vec<f64>; 5],
    pub nodes: [NodeContact; 5],
    /// Contact memory at the start; behind the middle; behind the end.
    pub contact: Vec<f64>,
    pub contact_middle: Vec<f64>,
    pub contact_next: Vec<f64>,
    pub dissipated_energy: f64,
    /// Energy norm of the state, and of the contact shape.
    pub energy_norm: f64,
    pub shape_norm: f64,
    /// Energy norm of the modal displacements under a unit contact force.
    pub compliance_norm: f64,
    /// The part of the node states due to the start of the step.
    pub q_start: [Vec<f64>; 5],
    pub v_start: [Vec<f64>; 5],
    pub q_end: Vec<f64>,
    pub v_end: Vec<f64>,
    /// c − G q at the node evaluated last.
    pub direction: Vec<f64>,
    /// f φ − Σ Tₖ φₖ at the node evaluated last, of a beam with contact points.
    pushed: Vec<f64>,
    /// Coefficients for the two step sizes used last.
    pub propagators: [Propagator; 2],
    pub current: usize,
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
            pushed: vec![0.0; modes],
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
        self.force_modes(0, span.inputs, fraction);
        self.energy_norm = self.energy(&self.q[0], &self.v[0]);
        true
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
        self.force_modes(0, span.inputs, span.to);
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

    pub fn point(&self, node: usize, normal_load: f64, yielding: f64) -> ContactPoint {
        let contact = &self.nodes[node];
        ContactPoint {
            displacement: contact.geometric_displacement + yielding * contact.force,
            velocity: contact.geometric_velocity / (1.0 + self.beam.axial_flexibility * contact.tangent),
            flexibility: self.beam.axial_flexibility + yielding,
            normal_load,
            guess: contact.force,
        }
    }

    pub fn store(&mut self, node: usize, response: crate::contact::Response, displacement: f64, load: f64) {
        let contact = &mut self.nodes[node];
        contact.force = response.force;
        contact.tangent = response.tangents.displacement;
        contact.load_tangent = response.tangents.normal_load;
        contact.slip_state = response.slip_state;
        contact.normal_load = load;
        contact.displacement = displacement;
    }

    /// Modal forcing at the node whose geometry was computed last, at `fraction` of the communication step; squared
    /// change.
    pub fn force_modes(&mut self, node: usize, inputs: &BeamInputs, fraction: f64) -> f64 {
        let beam = &self.beam;
        let mut excitation = inputs.excitation.at(fraction);
        if beam.quadratic_damping != 0.0 {
            let velocity: f64 = beam.excitation_shape.iter().zip(&self.v[node]).map(|(phi, v)| phi * v).sum();
            excitation -= beam.quadratic_damping * velocity.abs() * velocity;
        }
        let force = self.nodes[node].force;
        // Stretching and a string pull along G q = c − direction, by κ qᵀ G q − k Σ sᵢ qᵢ.
        let (mut tension, mut shortened) = (0.0, 0.0);
        if beam.pulls_along() {
            let lever = beam.contact_shape.iter().zip(&self.direction).zip(&self.q[node]);
            let twice = lever.map(|((c, d), q)| (c - d) * q).sum::<f64>();
            tension = beam.stretching_stiffness * twice - beam.string_pull(&self.q[node]);
            shortened = 0.5 * twice;
        }
        let mut across = &beam.excitation_shape;
        if !beam.contact_points.is_empty() {
            beam.push(excitation, inputs.at_points.iter().map(|ramp| ramp.at(fraction)), &mut self.pushed);
            (across, excitation) = (&self.pushed, 1.0);
        }
        let mut change = 0.0;
        let string = beam.string_stretch.iter().map(|s| beam.string_stiffness * shortened * s);
        let shapes = across.iter().zip(&self.direction).zip(&beam.contact_shape);
        let shapes = shapes.zip(string.chain(std::iter::repeat(0.0)));
        for (p, (((phi, d), c), string)) in self.forcing[node].iter_mut().zip(shapes) {
            let value = excitation * phi - force * d - tension * (c - d) + string;
            change += (value - *p) * (value - *p);
            *p = value;
        }
        change
    }

    /// √Σ(ω²q² + v²)
    pub fn energy(&self, q: &[f64], v: &[f64]) -> f64 {
        let terms = self.beam.angular_frequency.iter().zip(q).zip(v);
        terms.map(|((omega, q), v)| omega * omega * q * q + v * v).sum::<f64>().sqrt()
    }
}

impl ModalBeam {
    /// `f φᵢ(S) − Σ Tₖ φᵢ(xₖ)`: what `excitation` and the `forces` at the contact points do to the modes.
    pub(super) fn push(&self, excitation: f64, forces: impl Iterator<Item = f64>, out: &mut [f64]) {
        out.iter_mut().zip(&self.excitation_shape).for_each(|(out, phi)| *out = excitation * phi);
        for (force, point) in forces.zip(&self.contact_points) {
            out.iter_mut().zip(&point.shape).for_each(|(out, phi)| *out -= force * phi);
        }
    }
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| x * x).sum::<f64>().sqrt()
}
