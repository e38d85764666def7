//! The classical Runge–Kutta scheme in equal steps for every element: what the integrator is not for, and an independent
//! check of harmonic balance.
//!
//! In comes a modal [`System`]; out go its motion and energies, step after step. motion.rs: where it is; acting.rs: what acts at its
//! ports and what that remembers; equations.rs: the accelerations.

mod acting;
mod equations;
mod motion;

use super::SystemError;
use super::plant::{ModalPort, check_shortening, dot, modal_port};
use crate::contact::SlipSlapWork;
use crate::system::{Core, System};
use acting::{Acting, Inertia, elements_of};
pub use motion::{ContactInTwo, Energies, SteppedMotion};

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
    inertia: Option<Inertia>,
    buffers: Buffers,
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
    /// A system without modal coordinates, with flexibilities in series with ports or more than one [`Element::Inertia`](crate::system::Element::Inertia).
    pub fn new(system: &System) -> Result<Self, SystemError> {
        let system = system.expanded();
        let Core::Modal { angular_frequency, damping_ratio } = &system.core else {
            return Err(SystemError::NotLinear);
        };
        let size = angular_frequency.len();
        check_shortening(&system, size, false)?;
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
        let (elements, inertia) = elements_of(&system)?;
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
        self.elements.iter().for_each(|element| element.remember_rest(&mut memory));
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
}

/// Value at `part` of the way of the parabola through these at its start, middle and end.
fn parabola([start, middle, end]: [f64; 3], part: f64) -> f64 {
    let bow = middle - 0.5 * (start + end);
    start + part * (end - start) + 4.0 * part * (1.0 - part) * bow
}
