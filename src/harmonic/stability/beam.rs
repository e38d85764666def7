//! The modal beam in a periodic motion, as a disturbance of it sees it.
//!
//! With `w = c − G q` the displacement of the contact is disturbed by `w·δq`, and its force acts along w, which is
//! disturbed itself: on the modes act `w δT − T G δq`, from stretching `κ (qᵀ G q) G δq + 2 κ G q (G q)·δq`, and from
//! drag `2 d |ẏ| φ φ·δq̇`. Every mode is a channel. The flexibility a in series with the contact leaves it
//! `δv = w·δq − a δT`.

use super::feedback::{Disturbed, Feedback, Seat, Series, events_of};
use super::history::history;
use super::signal::evaluate;
use super::step::Step;
use crate::system::{LinearStructure, ModalBeam};
use crate::time::exact::system::{System, dot};
use crate::time::{LoadedContact, OscillatorError};

/// A beam and its periodic motion.
pub(super) struct Bent<'a> {
    beam: &'a ModalBeam,
    contact: Option<LoadedContact<'a>>,
    /// Coefficients of every mode, and of the displacement left for the contact.
    modes: Vec<&'a [f64]>,
    displacement: &'a [f64],
    angular_frequency: f64,
    system: System,
    /// Whether the contact answers to its velocity behind a flexibility.
    yields: bool,
}

impl<'a> Bent<'a> {
    pub fn new(
        beam: &'a ModalBeam,
        contact: Option<LoadedContact<'a>>,
        modes: Vec<&'a [f64]>,
        displacement: &'a [f64],
        angular_frequency: f64,
    ) -> Result<Self, OscillatorError> {
        let mut structure = LinearStructure::from_beam(beam);
        structure.contacts = (0..structure.size).map(|mode| vec![(mode, 1.0)]).collect();
        let system = System::new(&structure)?;
        let mut bent = Self { beam, contact, modes, displacement, angular_frequency, system, yields: false };
        if beam.axial_flexibility > 0.0 {
            // Rates are the same all along the period or change with the velocity: a few phases tell.
            let few: Vec<f64> = (0..=16).map(|k| f64::from(k) * std::f64::consts::TAU / 16.0).collect();
            bent.yields = bent.steps(&few)?.iter().any(Step::follows_velocity);
        }
        Ok(bent)
    }

    /// The contact's steps; none without one.
    fn steps(&self, grid: &[f64]) -> Result<Vec<Step>, OscillatorError> {
        let steps = |contact| history(contact, self.displacement, self.angular_frequency, grid, false);
        self.contact.as_ref().map_or(Ok(Vec::new()), steps)
    }

    fn series(&self, duration: f64) -> Series {
        match self.beam.axial_flexibility {
            0.0 => Series::Rigid,
            compliance if self.yields => Series::Yielding(compliance, duration),
            compliance => Series::Spring(compliance),
        }
    }

    fn at(&self, phase: f64, duration: f64, step: Option<&Step>) -> Feedback {
        let (n, beam) = (self.modes.len(), self.beam);
        let (q, rate): (Vec<f64>, Vec<f64>) = self.modes.iter().map(|mode| evaluate(mode, phase)).unzip();
        let turned =
            |q: &[f64]| -> Vec<f64> { beam.shortening.chunks_exact(n).map(|row| dot(row, q)).collect() };
        let (bent, bending) = (turned(&q), turned(&rate));
        let mut feedback = Feedback::new(n, self.memory());
        let tension = beam.stretching_stiffness * dot(&q, &bent)
            - beam.string_pull(&q)
            - step.map_or(0.0, |step| step.force);
        let string =
            |i: usize| beam.string_stiffness * beam.string_stretch.get(i).copied().unwrap_or_default();
        let drag =
            2.0 * beam.quadratic_damping * self.angular_frequency * dot(&beam.excitation_shape, &rate).abs();
        for i in 0..n {
            for j in 0..n {
                feedback.force[(i, j)] = tension * beam.shortening[i * n + j]
                    + 2.0 * beam.stretching_stiffness * bent[i] * bent[j]
                    - (string(i) * bent[j] + bent[i] * string(j));
                feedback.force[(i, n + j)] = drag * beam.excitation_shape[i] * beam.excitation_shape[j];
            }
        }
        if let Some(step) = step {
            let arm: Vec<f64> = beam.contact_shape.iter().zip(&bent).map(|(c, bent)| c - bent).collect();
            let arm_rate: Vec<f64> =
                bending.iter().map(|bending| -self.angular_frequency * bending).collect();
            let series = self.series(duration);
            feedback.attach(step, &Seat { arm: &arm, arm_rate: &arm_rate, memory: 0, series });
        }
        feedback
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
        self.contact.map_or(0, |contact| contact.law.state_len() + usize::from(self.yields))
    }

    fn coefficients(&self) -> usize {
        self.modes.iter().map(|mode| mode.len()).max().unwrap_or(1).max(self.displacement.len())
    }

    fn events(&self) -> Vec<f64> {
        self.contact
            .map_or(Vec::new(), |contact| events_of(&contact, self.displacement, self.angular_frequency))
    }

    fn first_order(&self) -> bool {
        self.yields
    }

    fn feedback(&self, grid: &[f64]) -> Result<Vec<Feedback>, OscillatorError> {
        let steps = self.steps(grid)?;
        let duration = |k: usize| if k == 0 { 0.0 } else { (grid[k] - grid[k - 1]) / self.angular_frequency };
        Ok(grid.iter().enumerate().map(|(k, phase)| self.at(*phase, duration(k), steps.get(k))).collect())
    }
}
