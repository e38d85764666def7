//! A system in modal coordinates in a periodic motion, as a disturbance of it sees it.
//!
//! With `J = b − γ G q` the displacement of a port is disturbed by `J·δq`, and its force F acts along J, which is
//! disturbed itself: on the modes act `J δF − γ F G δq`. Every mode is a channel. A flexibility a in series with a law
//! leaves it `δv = J·δq − a δF`.

use super::feedback::{Attachment, Disturbed, Feedback, Series, events_of};
use super::history::history;
use super::signal::evaluate;
use super::step::Step;
use crate::harmonic::modal_system::{ModalPort, ModalSystem};
use crate::system::{Element, LinearStructure};
use crate::time::exact::system::{System, dot};
use crate::time::{LoadedContact, OscillatorError};

/// A system and its periodic motion.
pub(super) struct Bent<'a> {
    modal: &'a ModalSystem,
    laws: Vec<Law<'a>>,
    springs: Vec<([&'a ModalPort; 2], [[f64; 2]; 2])>,
    /// Coefficients of every mode.
    modes: Vec<&'a [f64]>,
    angular_frequency: f64,
    system: System,
}

/// A law in its motion.
struct Law<'a> {
    port: &'a ModalPort,
    contact: LoadedContact<'a>,
    /// Coefficients of the displacement that a flexibility leaves it.
    displacement: &'a [f64],
    /// Whether it answers to its velocity behind a flexibility.
    yields: bool,
    /// First place of its memory.
    memory: usize,
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
}

impl<'a> Bent<'a> {
    /// `modes` are the coefficients of every mode, `displacement` those of every law in the order of the elements.
    pub fn new(
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
                    let port = &modal.ports[*port];
                    let mut law = Law { port, contact, displacement, yields: false, memory };
                    if port.flexibility > 0.0 {
                        // Rates are the same all along the period or change with the velocity: a few phases tell.
                        let few = (0..=16).map(|k| f64::from(k) * std::f64::consts::TAU / 16.0);
                        let few: Vec<f64> = few.collect();
                        let steps = history(&contact, displacement, angular_frequency, &few, false)?;
                        law.yields = steps.iter().any(Step::follows_velocity);
                    }
                    memory += law.memory_len();
                    laws.push(law);
                }
                Element::Springs { ports, stiffness } => {
                    springs.push((ports.map(|port| &modal.ports[port]), *stiffness));
                }
                Element::Outside { .. } => {}
            }
        }
        let system = System::new(&channels(modal))?;
        Ok(Self { modal, laws, springs, modes, angular_frequency, system })
    }

    /// What acts on a disturbance at `phase` but the laws, and the arms of ports there with their rates.
    fn at(&self, phase: f64, duration: f64, steps: &[&Step]) -> Feedback {
        let (n, modal) = (self.modes.len(), self.modal);
        let (q, rate): (Vec<f64>, Vec<f64>) = self.modes.iter().map(|mode| evaluate(mode, phase)).unzip();
        let turned =
            |q: &[f64]| -> Vec<f64> { modal.shortening.chunks_exact(n).map(|row| dot(row, q)).collect() };
        let (bent, bending) = (turned(&q), turned(&rate));
        let shortened = 0.5 * dot(&q, &bent);
        let arm = |port: &ModalPort| -> Vec<f64> {
            port.shape.iter().zip(&bent).map(|(b, bent)| b - port.shortening * bent).collect()
        };
        let mut feedback = Feedback::new(n, self.memory());
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
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            feedback.force[(i, j)] -= tension * modal.shortening[i * n + j];
        }
        for (step, law) in steps.iter().zip(&self.laws) {
            let turning = -self.angular_frequency * law.port.shortening;
            let arm_rate: Vec<f64> = bending.iter().map(|bending| turning * bending).collect();
            let (arm, series) = (arm(law.port), law.series(duration));
            feedback.attach(step, &Attachment { arm: &arm, arm_rate: &arm_rate, memory: law.memory, series });
        }
        feedback
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

impl Disturbed for Bent<'_> {
    fn system(&self) -> &System {
        &self.system
    }

    fn angular_frequency(&self) -> f64 {
        self.angular_frequency
    }

    fn memory(&self) -> usize {
        self.laws.iter().map(Law::memory_len).sum()
    }

    fn coefficients(&self) -> usize {
        let all = self.modes.iter().copied().chain(self.laws.iter().map(|law| law.displacement));
        all.map(<[f64]>::len).max().unwrap_or(1)
    }

    fn events(&self) -> Vec<f64> {
        let of = |law: &Law| events_of(&law.contact, law.displacement, self.angular_frequency);
        self.laws.iter().flat_map(of).collect()
    }

    fn first_order(&self) -> bool {
        self.laws.iter().any(|law| law.yields)
    }

    fn feedback(&self, grid: &[f64]) -> Result<Vec<Feedback>, OscillatorError> {
        let steps = |law: &Law| history(&law.contact, law.displacement, self.angular_frequency, grid, false);
        let steps = self.laws.iter().map(steps).collect::<Result<Vec<_>, _>>()?;
        let duration = |k: usize| if k == 0 { 0.0 } else { (grid[k] - grid[k - 1]) / self.angular_frequency };
        let at = |(k, phase): (usize, &f64)| {
            let here: Vec<&Step> = steps.iter().map(|steps| &steps[k]).collect();
            self.at(*phase, duration(k), &here)
        };
        Ok(grid.iter().enumerate().map(at).collect())
    }
}
