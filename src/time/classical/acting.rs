//! What acts at the ports of a system in equal steps, and what it remembers.

use std::sync::Arc;

use nalgebra::Matrix2;

use super::{Buffers, ClassicalSteps, ContactInTwo, SteppedMotion};
use crate::contact::{ContactLaw, Inputs, SlipSlap, SlipSlapInputs};
use crate::system::{Element, System};
use crate::time::SystemError;

/// An element, at places of ports.
#[derive(Debug, Clone)]
pub(super) enum Acting {
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

/// Masses that move with two ports.
pub(super) type Inertia = ([usize; 2], Matrix2<f64>);

/// The elements of `system` and, apart, its inertia.
///
/// # Errors
/// More than one [`Element::Inertia`].
pub(super) fn elements_of(system: &System) -> Result<(Vec<Acting>, Option<Inertia>), SystemError> {
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
            Element::Resonator { .. } => {} // in the expanded form there are none
            Element::Outside { port } => {
                elements.push(Acting::Outside { port: *port, place: outside });
                outside += 1;
            }
        }
    }
    Ok((elements, inertia))
}

impl Acting {
    /// Adds what the element remembers at rest without forces.
    pub fn remember_rest(&self, memory: &mut Vec<f64>) {
        let begin = memory.len();
        match self {
            Self::Law { law, normal_load, .. } => {
                memory.resize(begin + law.state_len(), 0.0);
                law.set_state(0.0, *normal_load, 0.0, &mut memory[begin..]);
            }
            Self::SlipSlap { contact, .. } => {
                memory.resize(begin + contact.state_len(), 0.0);
                contact.set_state([0.0; 2], 0.0, &mut memory[begin..]);
            }
            Self::Springs { .. } | Self::Outside { .. } => {}
        }
    }
}

impl ClassicalSteps {
    /// Restoring forces at all ports, but those of inertia.
    pub(super) fn forces(&self, memory: &[f64], buffers: &mut Buffers) {
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
    pub(super) fn power(&self, buffers: &Buffers) -> f64 {
        let of = |element: &Acting| match element {
            Acting::Outside { port, place } => {
                -buffers.outside.get(*place).copied().unwrap_or(0.0) * buffers.motions[*port].1
            }
            _ => 0.0,
        };
        self.elements.iter().map(of).sum()
    }

    /// Takes the memories on to where `motion` has come.
    pub(super) fn commit(&mut self, motion: &mut SteppedMotion) {
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

fn inputs_at(motions: &[(f64, f64)], [a, b]: [usize; 2]) -> SlipSlapInputs {
    SlipSlapInputs { displacement: [motions[a].0, motions[b].0], velocity: [motions[a].1, motions[b].1] }
}
