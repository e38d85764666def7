//! The sampled contact on any set of harmonics: slow, simple, and independent of the exact ways.

use nalgebra::DMatrix;

use super::sampled::SampledCycle;
use super::{Cycle, CycleSummary, PeriodicContact};
use crate::contact::{Inputs, SlipState};
use crate::harmonic::HarmonicError;
use crate::numeric::HarmonicSet;
use crate::numeric::fourier::{coefficient_count, from_samples, work_per_cycle};

/// [`SampledCycle`] restricted to a set of harmonics.
#[derive(Debug)]
pub(crate) struct ReferenceCycle {
    set: HarmonicSet,
    wide: HarmonicSet,
    inner: SampledCycle,
    samples: usize,
    displacement: Vec<f64>,
    force: Vec<f64>,
    jacobian: DMatrix<f64>,
    by_frequency: Vec<f64>,
    /// Displacement, force and slip state at the samples of the last evaluation.
    history: Vec<(f64, f64, SlipState)>,
    has_stick: bool,
    /// Whether the derivatives are those of the last evaluation.
    complete: bool,
}

impl ReferenceCycle {
    pub fn new(set: HarmonicSet, samples: usize) -> Self {
        let wide = HarmonicSet::full(set.highest());
        Self {
            set,
            wide,
            inner: SampledCycle::new(set.highest(), samples),
            samples,
            displacement: vec![0.0; wide.len()],
            force: vec![0.0; set.len()],
            jacobian: DMatrix::zeros(set.len(), set.len()),
            by_frequency: vec![0.0; set.len()],
            history: Vec::new(),
            has_stick: true,
            complete: false,
        }
    }

    /// Two marched periods, of which the second tells where the contact sticks.
    fn march(&mut self, contact: &PeriodicContact, angular_frequency: f64) {
        let n = contact.law.state_len();
        let (mut state, mut next) = (vec![0.0; n], vec![0.0; n]);
        contact.law.set_state(0.0, self.inner.load(0), 0.0, &mut state);
        self.history.clear();
        self.has_stick = contact.law.has_stick();
        for k in 0..2 * self.samples {
            let (total, rate, force) = self.inner.sample(k % self.samples);
            let inputs = Inputs {
                displacement: total - contact.compliance * force,
                velocity: angular_frequency * rate,
                normal_load: self.inner.load(k % self.samples),
            };
            let response = contact.law.step(&state, inputs, &mut next);
            std::mem::swap(&mut state, &mut next);
            if k >= self.samples {
                self.history.push((inputs.displacement, force, response.slip_state));
            }
        }
    }
}

impl Cycle for ReferenceCycle {
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.set.convert(u, self.wide, &mut self.displacement);
        self.inner.evaluate(contact, angular_frequency, &self.displacement)?;
        self.wide.convert(&self.inner.force, self.set, &mut self.force);
        self.wide.convert(&self.inner.by_frequency, self.set, &mut self.by_frequency);
        let places: Vec<usize> =
            (0..self.wide.len()).filter(|place| self.set.place(place.div_ceil(2)).is_some()).collect();
        for (column, j) in places.iter().enumerate() {
            for (row, i) in places.iter().enumerate() {
                self.jacobian[(row, column)] = self.inner.jacobian[(*i, *j)];
            }
        }
        self.march(contact, angular_frequency);
        self.complete = true;
        Ok(())
    }

    fn evaluate_force(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.set.convert(u, self.wide, &mut self.displacement);
        if !self.inner.force_alone(contact, angular_frequency, &self.displacement) {
            return self.evaluate(contact, angular_frequency, u);
        }
        self.wide.convert(&self.inner.force, self.set, &mut self.force);
        self.march(contact, angular_frequency);
        self.complete = false;
        Ok(())
    }

    /// Marches no second time: who asks for the force alone does not ask where the contact sticks.
    fn follow(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.set.convert(u, self.wide, &mut self.displacement);
        if !self.inner.force_alone(contact, angular_frequency, &self.displacement) {
            return self.evaluate(contact, angular_frequency, u);
        }
        self.complete = false;
        self.history.clear();
        let force = |k| self.inner.sample(k).2;
        self.history.extend((0..self.samples).map(|k| (0.0, force(k), SlipState::Stick)));
        Ok(())
    }

    fn complete(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        if self.complete { Ok(()) } else { self.evaluate(contact, angular_frequency, u) }
    }

    fn force(&self) -> &[f64] {
        &self.force
    }

    fn jacobian(&self) -> &DMatrix<f64> {
        &self.jacobian
    }

    fn by_frequency(&self) -> &[f64] {
        &self.by_frequency
    }

    fn forget(&mut self) {
        self.inner.forget();
    }

    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        let forces: Vec<f64> = self.history.iter().map(|(_, force, _)| *force).collect();
        let full = from_samples(&forces, 1, set.highest());
        HarmonicSet::full(full.len() / 2).convert(&full, set, out);
    }

    fn summary(&mut self) -> CycleSummary {
        let by_displacement = |a: &&(f64, f64, SlipState), b: &&(f64, f64, SlipState)| a.0.total_cmp(&b.0);
        let low = self.history.iter().min_by(by_displacement).map_or((0.0, 0.0), |p| (p.0, p.1));
        let high = self.history.iter().max_by(by_displacement).map_or((0.0, 0.0), |p| (p.0, p.1));
        let stuck = self.history.iter().filter(|(_, _, state)| *state == SlipState::Stick).count();
        debug_assert_eq!(self.displacement.len(), coefficient_count(self.wide.highest()));
        CycleSummary {
            dissipated_energy: work_per_cycle(&self.inner.force, &self.displacement),
            equivalent_stiffness: (high.1 - low.1) / (high.0 - low.0),
            stick_fraction: self.has_stick.then(|| stuck as f64 / self.history.len().max(1) as f64),
        }
    }
}
