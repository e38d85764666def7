//! The classical Runge–Kutta scheme in equal steps for every element: what the integrator is not for, and an independent
//! check of harmonic balance.

use std::sync::Arc;

use nalgebra::{Matrix2, Vector2};

use super::SystemError;
use super::plant::{ModalPort, check_shortening, dot, modal_port};
use crate::contact::{ContactLaw, Inputs, SlipSlap, SlipSlapInputs, SlipSlapWork, SlipState};
use crate::system::{Core, Element, System};

/// Weights of the four stages, and where in the step they are.
const STAGES: [(f64, f64, usize); 4] =
    [(1.0 / 6.0, 0.0, 0), (1.0 / 3.0, 0.5, 1), (1.0 / 3.0, 0.5, 1), (1.0 / 6.0, 1.0, 2)];

/// Longest step times the fastest rate: the scheme is stable to 2.8, and a contact may carry some times its load at rest.
const LONGEST: f64 = 0.6;
/// What a step times the rate of a contact's normal direction comes to at most: the scheme is stable up to 2.7.
const STABLE: f64 = 1.5;
/// Most parts of a step.
const MOST_PARTS: f64 = 256.0;

/// A modal [`System`] in equal steps: laws, contacts in two directions, springs, and masses that move with two ports.
///
/// Within a step every law starts from its memory at the beginning of the step. Corners and reversals lie within steps, so
/// that the error falls with the second power of the step where there are some, with the fourth elsewhere. The step
/// must be below 2.8 over the highest angular frequency.
#[derive(Debug, Clone)]
pub struct ClassicalSteps {
    angular_frequency: Vec<f64>,
    damping_ratio: Vec<f64>,
    shortening: Vec<f64>,
    ports: Vec<ModalPort>,
    driven: Vec<f64>,
    elements: Vec<Acting>,
    inertia: Option<([usize; 2], Matrix2<f64>)>,
    buffers: Buffers,
}

/// Where a system is, and what its contacts remember.
#[derive(Debug, Clone, PartialEq)]
pub struct SteppedMotion {
    /// Modal displacements (kg^1/2 m) and velocities.
    pub displacement: Vec<f64>,
    /// See `displacement`.
    pub velocity: Vec<f64>,
    /// Memory of the laws, element after element.
    memory: Vec<f64>,
    /// Energies (J) since the beginning.
    pub energies: Energies,
    /// What the contacts in two directions do, in their order.
    pub contacts: Vec<ContactInTwo>,
}

/// Energies (J).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Work of the exciters, and of forces from outside.
    pub work: f64,
    /// Dissipated by the modes' damping.
    pub viscous: f64,
    /// Dissipated by friction.
    pub friction: f64,
    /// Dissipated by impacts.
    pub impact: f64,
}

/// A contact in two directions at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactInTwo {
    /// ξ and η (m).
    pub displacement: [f64; 2],
    /// S and N (N).
    pub force: [f64; 2],
    /// N_c (N).
    pub normal_force: f64,
    /// Distance of the bodies (m).
    pub separation: f64,
    /// What it does.
    pub slip_state: SlipState,
    /// ∂S/∂ξ (N/m) there.
    pub tangent: f64,
}

impl SteppedMotion {
    /// Numbers that [`SteppedMotion::write_state`] writes.
    pub(crate) fn state_len(&self) -> usize {
        2 * self.displacement.len() + self.memory.len()
    }

    /// Writes what the motion goes on from: modes and memories.
    pub(crate) fn write_state(&self, state: &mut [f64]) {
        let numbers = self.displacement.iter().chain(&self.velocity).chain(&self.memory);
        state.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
    }

    /// Takes over what a state has; energies begin anew, and contacts are known after the next step.
    pub(crate) fn read_state(&mut self, state: &[f64]) {
        let numbers = self.displacement.iter_mut().chain(&mut self.velocity).chain(&mut self.memory);
        numbers.zip(state).for_each(|(to, from)| *to = *from);
        self.energies = Energies::default();
    }
}

#[derive(Debug, Clone)]
enum Acting {
    Law {
        port: usize,
        law: Arc<dyn ContactLaw>,
        normal_load: f64,
    },
    SlipSlap {
        ports: [usize; 2],
        contact: Arc<SlipSlap>,
    },
    Springs {
        ports: [usize; 2],
        stiffness: [[f64; 2]; 2],
    },
    /// The force given from outside, counted among those.
    Outside {
        port: usize,
        place: usize,
    },
}

#[derive(Debug, Clone, Default)]
struct Buffers {
    q: Vec<f64>,
    v: Vec<f64>,
    pull: Vec<f64>,
    pull_rate: Vec<f64>,
    motions: Vec<(f64, f64)>,
    forces: Vec<f64>,
    rates: [[Vec<f64>; 2]; 4],
    next: Vec<f64>,
    work: SlipSlapWork,
    outside: Vec<f64>,
}

impl ClassicalSteps {
    /// The scheme for `system`.
    ///
    /// # Errors
    /// A system without modal coordinates, with flexibilities in series with ports or more than one [`Element::Inertia`].
    pub fn new(system: &System) -> Result<Self, SystemError> {
        let Core::Modal { angular_frequency, damping_ratio } = &system.core else {
            return Err(SystemError::NotLinear);
        };
        let size = angular_frequency.len();
        check_shortening(system, size, false)?;
        let ports =
            system.ports.iter().map(|port| modal_port(port, size, None)).collect::<Result<Vec<_>, _>>()?;
        if let Some(port) = system.ports.iter().find(|port| port.flexibility != 0.0) {
            let field = format!("flexibility of port {}", port.name);
            return Err(SystemError::Value { field, value: port.flexibility });
        }
        let mut driven = vec![0.0; size];
        for port in &system.driven {
            driven.iter_mut().zip(&ports[*port].row).for_each(|(sum, b)| *sum += b);
        }
        let (mut elements, mut inertia, mut outside) = (Vec::new(), None, 0);
        for element in &system.elements {
            match element {
                Element::Law { port, law, normal_load } => {
                    elements.push(Acting::Law { port: *port, law: law.clone(), normal_load: *normal_load });
                }
                Element::SlipSlap { ports, contact } => {
                    elements.push(Acting::SlipSlap { ports: *ports, contact: contact.clone() });
                }
                Element::Springs { ports, stiffness } => {
                    elements.push(Acting::Springs { ports: *ports, stiffness: *stiffness });
                }
                Element::Inertia { ports, mass: [[a, b], [c, d]] } if inertia.is_none() => {
                    inertia = Some((*ports, Matrix2::new(*a, *b, *c, *d)));
                }
                Element::Inertia { .. } => return Err(SystemError::InertiaAtPorts),
                Element::Outside { port } => {
                    elements.push(Acting::Outside { port: *port, place: outside });
                    outside += 1;
                }
            }
        }
        let zero = || vec![0.0; size];
        let buffers = Buffers {
            q: zero(),
            v: zero(),
            pull: zero(),
            pull_rate: zero(),
            motions: vec![(0.0, 0.0); ports.len()],
            forces: vec![0.0; ports.len()],
            rates: std::array::from_fn(|_| [zero(), zero()]),
            ..Buffers::default()
        };
        Ok(Self {
            angular_frequency: angular_frequency.clone(),
            damping_ratio: damping_ratio.clone(),
            shortening: system.shortening.clone(),
            ports,
            driven,
            elements,
            inertia,
            buffers,
        })
    }

    /// At modal displacements and velocities; contacts carry no tangential force at rest, and are brought from there to
    /// where they are at once.
    pub fn moving(&mut self, displacement: &[f64], velocity: &[f64]) -> SteppedMotion {
        let mut memory = Vec::new();
        for element in &self.elements {
            let begin = memory.len();
            match element {
                Acting::Law { law, normal_load, .. } => {
                    memory.resize(begin + law.state_len(), 0.0);
                    law.set_state(0.0, *normal_load, 0.0, &mut memory[begin..]);
                }
                Acting::SlipSlap { contact, .. } => {
                    memory.resize(begin + contact.state_len(), 0.0);
                    contact.set_state([0.0; 2], 0.0, &mut memory[begin..]);
                }
                Acting::Springs { .. } | Acting::Outside { .. } => {}
            }
        }
        let mut motion = SteppedMotion {
            displacement: displacement.to_vec(),
            velocity: velocity.to_vec(),
            memory,
            energies: Energies::default(),
            contacts: Vec::new(),
        };
        self.commit(&mut motion);
        motion.energies = Energies::default();
        motion
    }

    /// At rest without forces.
    pub fn rest(&mut self) -> SteppedMotion {
        let zero = vec![0.0; self.angular_frequency.len()];
        self.moving(&zero, &zero)
    }

    /// Goes on by `step` (s) under a force (N) on the driven ports at its start, middle and end.
    pub fn advance(&mut self, motion: &mut SteppedMotion, step: f64, force: [f64; 3]) {
        self.advance_under(motion, step, force, &[]);
    }

    /// As [`ClassicalSteps::advance`], under restoring forces (N) from outside at start, middle and end besides, in the order
    /// of the elements; zero where there are none.
    ///
    /// In an impact that presses a contact together so much harder than its load at rest that the scheme would not be stable,
    /// the step is divided.
    pub fn advance_under(
        &mut self,
        motion: &mut SteppedMotion,
        step: f64,
        force: [f64; 3],
        outside: &[[f64; 3]],
    ) {
        let parts = self.parts(motion, step);
        if parts == 1 {
            return self.advance_once(motion, step, force, outside);
        }
        for k in 0..parts {
            let at = |line: [f64; 3]| {
                [0.0, 0.5, 1.0].map(|part| parabola(line, (f64::from(k) + part) / f64::from(parts)))
            };
            let outside: Vec<[f64; 3]> = outside.iter().map(|line| at(*line)).collect();
            self.advance_once(motion, step / f64::from(parts), at(force), &outside);
        }
    }

    /// How many steps are to be made of one.
    fn parts(&mut self, motion: &SteppedMotion, step: f64) -> u32 {
        if !self.elements.iter().any(|element| matches!(element, Acting::SlipSlap { .. })) {
            return 1;
        }
        let mut buffers = std::mem::take(&mut self.buffers);
        buffers.q.copy_from_slice(&motion.displacement);
        buffers.v.copy_from_slice(&motion.velocity);
        self.look(&mut buffers);
        let rate = |element: &Acting| match element {
            Acting::SlipSlap { ports: [_, normal], contact } => {
                let (displacement, velocity) = buffers.motions[*normal];
                let mobility: f64 = self.ports[*normal].row.iter().map(|b| b * b).sum();
                contact.normal().rate(displacement.min(displacement + step * velocity), mobility)
            }
            _ => 0.0,
        };
        let rate = self.elements.iter().map(rate).fold(0.0, f64::max);
        self.buffers = buffers;
        (step * rate / STABLE).ceil().clamp(1.0, MOST_PARTS) as u32
    }

    fn advance_once(&mut self, motion: &mut SteppedMotion, step: f64, force: [f64; 3], outside: &[[f64; 3]]) {
        let size = motion.displacement.len();
        let mut buffers = std::mem::take(&mut self.buffers);
        for (stage, (weight, fraction, at)) in STAGES.into_iter().enumerate() {
            for i in 0..size {
                let [by_q, by_v] =
                    if stage == 0 { [0.0; 2] } else { [0, 1].map(|part| buffers.rates[stage - 1][part][i]) };
                buffers.q[i] = motion.displacement[i] + fraction * step * by_q;
                buffers.v[i] = motion.velocity[i] + fraction * step * by_v;
            }
            let mut rates = std::mem::take(&mut buffers.rates[stage]);
            rates[0].copy_from_slice(&buffers.v);
            buffers.outside.clear();
            buffers.outside.extend(outside.iter().map(|line| line[at]));
            self.accelerations(&motion.memory, force[at], &mut buffers, &mut rates[1]);
            let part = weight * step;
            motion.energies.work += part * (force[at] * dot(&self.driven, &buffers.v) + self.power(&buffers));
            for (i, v) in buffers.v.iter().enumerate() {
                let rate = 2.0 * self.damping_ratio[i] * self.angular_frequency[i];
                motion.energies.viscous += part * rate * v * v;
            }
            buffers.rates[stage] = rates;
        }
        for (stage, (weight, ..)) in STAGES.into_iter().enumerate() {
            let [of_q, of_v] = &buffers.rates[stage];
            motion.displacement.iter_mut().zip(of_q).for_each(|(q, rate)| *q += weight * step * rate);
            motion.velocity.iter_mut().zip(of_v).for_each(|(v, rate)| *v += weight * step * rate);
        }
        self.buffers = buffers;
        self.commit(motion);
    }

    /// Moves the modes at once, displacements then velocities, and the contacts with them.
    pub(crate) fn move_to(&mut self, motion: &mut SteppedMotion, modes: &[f64]) {
        let (displacement, velocity) = modes.split_at(motion.displacement.len());
        motion.displacement.copy_from_slice(displacement);
        motion.velocity.copy_from_slice(velocity);
        self.commit(motion);
    }

    /// Accelerations of the modes where [`ClassicalSteps::accelerations_of_ports`] was asked last.
    pub(crate) fn modal_accelerations(&self) -> &[f64] {
        &self.buffers.rates[0][1]
    }

    /// A step (s) that is short enough for the highest mode and for the impact damping of contacts under the load at rest.
    pub fn longest_step(&self) -> f64 {
        let highest = self.angular_frequency.iter().copied().fold(0.0, f64::max);
        let damped = |element: &Acting| match element {
            Acting::SlipSlap { ports: [_, normal], contact } => {
                let direction = contact.normal();
                let mobility: f64 = self.ports[*normal].row.iter().map(|b| b * b).sum();
                direction.impact_damping() * direction.preload() * mobility
            }
            _ => 0.0,
        };
        LONGEST / (highest + self.elements.iter().map(damped).sum::<f64>())
    }

    /// Displacements (m) and velocities (m/s) of all ports where `motion` is.
    pub fn motions_of_ports(&mut self, motion: &SteppedMotion, out: &mut Vec<(f64, f64)>) {
        let mut buffers = std::mem::take(&mut self.buffers);
        buffers.q.copy_from_slice(&motion.displacement);
        buffers.v.copy_from_slice(&motion.velocity);
        self.look(&mut buffers);
        out.clone_from(&buffers.motions);
        self.buffers = buffers;
    }

    /// Accelerations (m/s²) of all ports where `motion` is, under a force (N) on the driven ports and forces from `outside`.
    pub fn accelerations_of_ports(
        &mut self,
        motion: &SteppedMotion,
        force: f64,
        outside: &[f64],
        out: &mut Vec<f64>,
    ) {
        let mut buffers = std::mem::take(&mut self.buffers);
        buffers.outside.clear();
        buffers.outside.extend(outside);
        buffers.q.copy_from_slice(&motion.displacement);
        buffers.v.copy_from_slice(&motion.velocity);
        let mut modal = std::mem::take(&mut buffers.rates[0][1]);
        self.accelerations(&motion.memory, force, &mut buffers, &mut modal);
        out.clear();
        let quadratic = dot(&buffers.pull_rate, &buffers.v);
        out.extend(
            self.ports.iter().map(|port| port.along(&modal, &buffers.pull) - port.shortening * quadratic),
        );
        buffers.rates[0][1] = modal;
        self.buffers = buffers;
    }

    /// Displacements and velocities of all ports at `q` and `v`, and G q, G v.
    fn look(&self, buffers: &mut Buffers) {
        let Buffers { q, v, pull, pull_rate, motions, .. } = buffers;
        if !self.shortening.is_empty() {
            let size = q.len();
            for (i, row) in self.shortening.chunks_exact(size).enumerate() {
                (pull[i], pull_rate[i]) = (dot(row, q), dot(row, v));
            }
        }
        motions.iter_mut().zip(&self.ports).for_each(|(motion, port)| *motion = port.motion(q, v, pull));
    }

    fn accelerations(&self, memory: &[f64], force: f64, buffers: &mut Buffers, out: &mut [f64]) {
        self.look(buffers);
        self.forces(memory, buffers);
        let Buffers { q, v, pull, pull_rate, forces, .. } = buffers;
        for (i, out) in out.iter_mut().enumerate() {
            let omega = self.angular_frequency[i];
            let own = omega * omega * q[i] + 2.0 * self.damping_ratio[i] * omega * v[i];
            *out = force * self.driven[i] - own;
        }
        for (port, force) in self.ports.iter().zip(forces.iter()).filter(|(_, force)| **force != 0.0) {
            port.push(-force, pull, out);
        }
        let Some((places, mass)) = &self.inertia else { return };
        // ü = J q̈ − γ q̇ᵀG q̇, and q̈ = r − Jᵀ M ü.
        let ports = places.map(|place| &self.ports[place]);
        let quadratic = dot(pull_rate, v);
        let free = ports.map(|port| port.along(out, pull) - port.shortening * quadratic);
        let yielding = Matrix2::from_fn(|i, j| ports[i].across(ports[j], pull));
        let whole = Matrix2::identity() + yielding * mass;
        let moved = whole.lu().solve(&Vector2::from(free)).unwrap_or(Vector2::repeat(f64::NAN));
        let inertial = mass * moved;
        ports.iter().zip(inertial.iter()).for_each(|(port, force)| port.push(-force, pull, out));
    }

    /// Restoring forces at all ports, but those of inertia.
    fn forces(&self, memory: &[f64], buffers: &mut Buffers) {
        let Buffers { motions, forces, next, work, outside, .. } = buffers;
        forces.fill(0.0);
        let mut begin = 0;
        for element in &self.elements {
            match element {
                Acting::Law { port, law, normal_load } => {
                    let (displacement, velocity) = motions[*port];
                    let inputs = Inputs { displacement, velocity, normal_load: *normal_load };
                    next.resize(law.state_len(), 0.0);
                    forces[*port] += law.step(&memory[begin..begin + next.len()], inputs, next).force;
                    begin += next.len();
                }
                Acting::SlipSlap { ports, contact } => {
                    next.resize(contact.state_len(), 0.0);
                    let memory = &memory[begin..begin + next.len()];
                    let response = contact.step(memory, inputs_at(motions, *ports), next, work);
                    ports.iter().zip(response.force).for_each(|(port, force)| forces[*port] += force);
                    begin += next.len();
                }
                Acting::Springs { ports, stiffness } => {
                    for (to, row) in ports.iter().zip(stiffness) {
                        forces[*to] += row[0] * motions[ports[0]].0 + row[1] * motions[ports[1]].0;
                    }
                }
                Acting::Outside { port, place } => {
                    forces[*port] += outside.get(*place).copied().unwrap_or(0.0);
                }
            }
        }
    }

    /// Power (W) of the forces from outside at the motion last looked at.
    fn power(&self, buffers: &Buffers) -> f64 {
        let of = |element: &Acting| match element {
            Acting::Outside { port, place } => {
                -buffers.outside.get(*place).copied().unwrap_or(0.0) * buffers.motions[*port].1
            }
            _ => 0.0,
        };
        self.elements.iter().map(of).sum()
    }

    /// Takes the memories on to where `motion` has come.
    fn commit(&mut self, motion: &mut SteppedMotion) {
        let mut buffers = std::mem::take(&mut self.buffers);
        buffers.q.copy_from_slice(&motion.displacement);
        buffers.v.copy_from_slice(&motion.velocity);
        self.look(&mut buffers);
        let Buffers { motions, next, work, .. } = &mut buffers;
        let mut begin = 0;
        motion.contacts.clear();
        for element in &self.elements {
            match element {
                Acting::Law { port, law, normal_load } => {
                    let (displacement, velocity) = motions[*port];
                    let inputs = Inputs { displacement, velocity, normal_load: *normal_load };
                    next.resize(law.state_len(), 0.0);
                    let memory = &mut motion.memory[begin..begin + next.len()];
                    motion.energies.friction += law.step(memory, inputs, next).dissipated_energy;
                    memory.copy_from_slice(next);
                    begin += next.len();
                }
                Acting::SlipSlap { ports, contact } => {
                    next.resize(contact.state_len(), 0.0);
                    let memory = &mut motion.memory[begin..begin + next.len()];
                    let inputs = inputs_at(motions, *ports);
                    let response = contact.step(memory, inputs, next, work);
                    memory.copy_from_slice(next);
                    motion.energies.friction += response.friction_energy;
                    motion.energies.impact += response.impact_energy;
                    motion.contacts.push(ContactInTwo {
                        displacement: inputs.displacement,
                        force: response.force,
                        normal_force: response.normal_force,
                        separation: response.separation,
                        slip_state: response.slip_state,
                        tangent: response.by_displacement[0][0],
                    });
                    begin += next.len();
                }
                Acting::Springs { .. } | Acting::Outside { .. } => {}
            }
        }
        self.buffers = buffers;
    }
}

/// Value at `part` of the way of the parabola through these at its start, middle and end.
fn parabola([start, middle, end]: [f64; 3], part: f64) -> f64 {
    let bow = middle - 0.5 * (start + end);
    start + part * (end - start) + 4.0 * part * (1.0 - part) * bow
}

fn inputs_at(motions: &[(f64, f64)], [a, b]: [usize; 2]) -> SlipSlapInputs {
    SlipSlapInputs { displacement: [motions[a].0, motions[b].0], velocity: [motions[a].1, motions[b].1] }
}

impl ModalPort {
    /// Adds what a force (N) at the port does to the modes; `pull` is G q.
    fn push(&self, force: f64, pull: &[f64], out: &mut [f64]) {
        for ((out, b), g) in out.iter_mut().zip(&self.row).zip(pull) {
            *out += force * (b - self.shortening * g);
        }
    }

    /// `J J'ᵀ` with another port.
    fn across(&self, other: &Self, pull: &[f64]) -> f64 {
        let lever = |port: &Self, i: usize| port.row[i] - port.shortening * pull[i];
        (0..pull.len()).map(|i| lever(self, i) * lever(other, i)).sum()
    }
}
