//! A structure in a periodic motion, as a disturbance of it sees it: constant, with forces fed back along its channels.
//!
//! Where all ports are linear those of the laws are the channels. Else every mode is one: with `J = b − γ G q` the
//! displacement of a port is disturbed by `J·δq`, and its force F acts along J, which is disturbed itself: on the modes act
//! `J δF − γ F G δq`. A flexibility a in series with a law leaves it `δv = J·δq − a δF`.

use std::borrow::Cow;

use super::feedback::{Attachment, Feedback, Series};
use super::history::{history, jumps};
use super::impulse;
use super::signal::{evaluate, turning_points};
use super::step::Step;
use crate::harmonic::modal_system::{ModalPort, ModalSystem};
use crate::system::{Element, LinearStructure};
use crate::time::exact::system::{System, dot};
use crate::time::{LoadedContact, OscillatorError};

/// A structure in its periodic motion.
pub(super) struct Disturbed<'a> {
    /// The structure; its contacts are the channels.
    pub system: Cow<'a, System>,
    /// Fundamental Ω (rad/s) of the motion.
    pub angular_frequency: f64,
    /// Numbers that the laws remember.
    pub memory: usize,
    laws: Vec<Law<'a>>,
    springs: Vec<([&'a ModalPort; 2], [[f64; 2]; 2])>,
    /// Coefficients of every mode; none where the ports are linear.
    modes: Vec<&'a [f64]>,
    /// G.
    shortening: &'a [f64],
}

/// A law in its motion.
struct Law<'a> {
    port: Cow<'a, ModalPort>,
    contact: LoadedContact<'a>,
    /// Coefficients of the displacement that a flexibility leaves it.
    displacement: &'a [f64],
    /// Whether it answers to its velocity behind a flexibility.
    yields: bool,
    /// Whether it answers to that in front of it.
    in_front: bool,
    /// First place of its memory.
    memory: usize,
    /// Whether its force may jump: behind a flexibility it does not.
    jumps: bool,
}

impl Law<'_> {
    fn memory_len(&self) -> usize {
        self.contact.law.state_len() + usize::from(self.yields)
    }

    fn series(&self, duration: f64) -> Series {
        match self.port.flexibility {
            0.0 => Series::Rigid,
            compliance if self.yields => Series::Yielding(compliance, duration),
            compliance => Series::Spring(compliance),
        }
    }

    /// Phases that a grid must meet: its turning points, both sides of the jumps of its tangents, and those of
    /// its force.
    fn events(&self, angular_frequency: f64) -> Vec<f64> {
        let Self { contact, displacement, .. } = self;
        /// Half the step over a jump.
        const BESIDE: f64 = 1e-9;
        let mut phases = turning_points(displacement);
        phases.extend(jumps(contact, displacement).into_iter().flat_map(|at| [at - BESIDE, at + BESIDE]));
        let [of_force, of_tangents] = impulse::phases(contact, displacement, angular_frequency);
        phases.extend(of_tangents.into_iter().flat_map(|at| [at - BESIDE, at + BESIDE]));
        phases.extend(of_force.into_iter().flat_map(|at| [at - BESIDE, at, at + BESIDE]));
        phases
    }
}

impl<'a> Disturbed<'a> {
    /// A structure whose `contacts` move by given coefficients.
    pub fn linear(
        system: &'a System,
        contacts: &[LoadedContact<'a>],
        displacement: &[&'a [f64]],
        angular_frequency: f64,
    ) -> Self {
        let channels = contacts.len();
        let (mut laws, mut memory) = (Vec::with_capacity(channels), 0);
        for (channel, (contact, displacement)) in contacts.iter().zip(displacement).enumerate() {
            let shape = (0..channels).map(|other| f64::from(u8::from(other == channel))).collect();
            let port = Cow::Owned(ModalPort { shape, shortening: 0.0, flexibility: 0.0 });
            laws.push(Law {
                port,
                contact: *contact,
                displacement,
                yields: false,
                in_front: false,
                memory,
                jumps: true,
            });
            memory += contact.law.state_len();
        }
        let (springs, modes) = (Vec::new(), Vec::new());
        Self {
            system: Cow::Borrowed(system),
            angular_frequency,
            memory,
            laws,
            springs,
            modes,
            shortening: &[],
        }
    }

    /// A system in modal coordinates: `modes` are the coefficients of every mode, `displacement` those of every law in the
    /// order of the elements.
    pub fn in_modes(
        modal: &'a ModalSystem,
        modes: Vec<&'a [f64]>,
        displacement: &[&'a [f64]],
        angular_frequency: f64,
    ) -> Result<Self, OscillatorError> {
        let (mut laws, mut springs, mut memory) = (Vec::new(), Vec::new(), 0);
        let mut left = displacement.iter();
        for element in &modal.elements {
            match element {
                Element::Law { port, law, normal_load } => {
                    let (expected, found) = (displacement.len() + 1, displacement.len());
                    let missing = OscillatorError::Length { name: "displacement", expected, found };
                    let displacement = left.next().ok_or(missing)?;
                    let contact = LoadedContact { law: law.as_ref(), normal_load: *normal_load };
                    let port = Cow::Borrowed(&modal.ports[*port]);
                    let in_front = port.flexibility > 0.0 && contact.law.limit_follows_velocity();
                    let mut law =
                        Law { port, contact, displacement, yields: false, in_front, memory, jumps: false };
                    if law.port.flexibility > 0.0 && !in_front {
                        // Rates are the same all along the period or change with the velocity: a few phases tell.
                        let few = (0..=16).map(|k| f64::from(k) * std::f64::consts::TAU / 16.0);
                        let few: Vec<f64> = few.collect();
                        let motion = |phase| evaluate(displacement, phase);
                        let steps = history(&contact, &motion, angular_frequency, &few, false)?;
                        law.yields = steps.iter().any(Step::follows_velocity);
                    }
                    memory += law.memory_len();
                    laws.push(law);
                }
                Element::Springs { ports, stiffness } => {
                    springs.push((ports.map(|port| &modal.ports[port]), *stiffness));
                }
                Element::Resonator { .. } // in the expanded form there are none
                | Element::SlipSlap { .. }
                | Element::Inertia { .. }
                | Element::Outside { .. } => {}
            }
        }
        let system = Cow::Owned(System::new(&channels(modal))?);
        Ok(Self { system, angular_frequency, memory, laws, springs, modes, shortening: &modal.shortening })
    }

    /// What acts on a disturbance at `phase` but the laws, and the arms of ports there with their rates.
    fn at(&self, phase: f64, duration: f64, steps: &[&Step]) -> Feedback {
        let n = self.system.contacts.len();
        let (q, rate): (Vec<f64>, Vec<f64>) = self.modes.iter().map(|mode| evaluate(mode, phase)).unzip();
        let turned = |q: &[f64]| -> Vec<f64> {
            self.shortening.chunks_exact(n.max(1)).map(|row| dot(row, q)).collect()
        };
        let (bent, bending) = (turned(&q), turned(&rate));
        let shortened = 0.5 * dot(&q, &bent);
        let arm = |port: &ModalPort| -> Vec<f64> {
            let mut arm = port.shape.clone();
            arm.iter_mut().zip(&bent).for_each(|(b, bent)| *b -= port.shortening * bent);
            arm
        };
        let mut feedback = Feedback::new(n, self.memory);
        let mut tension: f64 =
            steps.iter().zip(&self.laws).map(|(step, law)| law.port.shortening * step.force).sum();
        for (ports, stiffness) in &self.springs {
            let u = ports.map(|port| dot(&port.shape, &q) - port.shortening * shortened);
            let arms = ports.map(arm);
            for (port, row) in ports.iter().zip(stiffness) {
                tension += port.shortening * (row[0] * u[0] + row[1] * u[1]);
            }
            for (left, row) in arms.iter().zip(stiffness) {
                for (right, stiffness) in arms.iter().zip(row) {
                    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                        feedback.force[(i, j)] += left[i] * stiffness * right[j];
                    }
                }
            }
        }
        for (place, along) in self.shortening.iter().enumerate() {
            feedback.force[(place / n, place % n)] -= tension * along;
        }
        for (step, law) in steps.iter().zip(&self.laws) {
            let turning = -self.angular_frequency * law.port.shortening;
            let mut arm_rate = vec![0.0; n];
            arm_rate.iter_mut().zip(&bending).for_each(|(rate, bending)| *rate = turning * bending);
            let (arm, series) = (arm(&law.port), law.series(duration));
            feedback.attach(step, &Attachment { arm: &arm, arm_rate: &arm_rate, memory: law.memory, series });
        }
        feedback
    }

    /// Derivative by phase of the displacement (m) of `port` in front of its flexibility.
    fn slope_in_front(&self, port: &ModalPort, phase: f64) -> f64 {
        let (q, slope): (Vec<f64>, Vec<f64>) = self.modes.iter().map(|mode| evaluate(mode, phase)).unzip();
        let bent = self.shortening.chunks_exact(q.len().max(1)).map(|row| dot(row, &q));
        dot(&port.shape, &slope) - port.shortening * bent.zip(&slope).map(|(g, rate)| g * rate).sum::<f64>()
    }

    /// Coefficients of the finest signal of the motion.
    pub fn coefficients(&self) -> usize {
        let all = self.modes.iter().copied().chain(self.laws.iter().map(|law| law.displacement));
        all.map(<[f64]>::len).max().unwrap_or(1)
    }

    /// Phases that a grid must meet: where memory is made or the feedback jumps.
    pub fn events(&self) -> Vec<f64> {
        self.laws.iter().flat_map(|law| law.events(self.angular_frequency)).collect()
    }

    /// Whether the feedback takes differences backwards in time, whose error is of first order.
    pub fn first_order(&self) -> bool {
        self.laws.iter().any(|law| law.yields)
    }

    /// The feedback at every phase of the grid, from 0 to 2π; the first step has no length.
    pub fn feedback(&self, grid: &[f64]) -> Result<Vec<Feedback>, OscillatorError> {
        let steps = |law: &Law| {
            let motion = |phase: f64| {
                let (displacement, slope) = evaluate(law.displacement, phase);
                (displacement, if law.in_front { self.slope_in_front(&law.port, phase) } else { slope })
            };
            history(&law.contact, &motion, self.angular_frequency, grid, law.jumps)
        };
        let steps = self.laws.iter().map(steps).collect::<Result<Vec<_>, _>>()?;
        let duration = |k: usize| if k == 0 { 0.0 } else { (grid[k] - grid[k - 1]) / self.angular_frequency };
        let at = |(k, phase): (usize, &f64)| {
            let here: Vec<&Step> = steps.iter().map(|steps| &steps[k]).collect();
            self.at(*phase, duration(k), &here)
        };
        Ok(grid.iter().enumerate().map(at).collect())
    }
}

/// The modes alone, each a channel.
fn channels(modal: &ModalSystem) -> LinearStructure {
    let diagonal = |value: &dyn Fn(usize) -> f64| (0..modal.modes()).map(|i| (i, i, value(i))).collect();
    let (omega, zeta) = (&modal.angular_frequency, &modal.damping_ratio);
    LinearStructure {
        size: modal.modes(),
        mass: diagonal(&|_| 1.0),
        damping: diagonal(&|i| 2.0 * zeta[i] * omega[i]),
        stiffness: diagonal(&|i| omega[i] * omega[i]),
        contacts: (0..modal.modes()).map(|mode| vec![(mode, 1.0)]).collect(),
        excitation: modal.driven.iter().copied().enumerate().collect(),
        outputs: Vec::new(),
    }
}
