//! The sampled contact on any set of harmonics: slow, simple, and independent of the exact schemes.

use super::sampled::SampledCycle;
use super::{Cycle, CycleSummary, ForceMap, PeriodicContact};
use crate::contact::SlipState;
use crate::harmonic::HarmonicError;
use crate::numeric::HarmonicSet;
use crate::numeric::fourier::{coefficient_count, from_samples, work_per_cycle};

/// [`SampledCycle`] restricted to a set of harmonics.
#[derive(Debug)]
pub(crate) struct ReferenceCycle {
    set: HarmonicSet,
    wide: HarmonicSet,
    inner: SampledCycle,
    displacement: Vec<f64>,
    result: ForceMap,
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
            displacement: vec![0.0; wide.len()],
            result: ForceMap::new(set.len()),
            has_stick: true,
            complete: false,
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
        self.wide.convert(&self.inner.force, self.set, &mut self.result.force);
        self.wide.convert(&self.inner.by_frequency, self.set, &mut self.result.by_frequency);
        let places: Vec<usize> =
            (0..self.wide.len()).filter(|place| self.set.place(place.div_ceil(2)).is_some()).collect();
        for (column, j) in places.iter().enumerate() {
            for (row, i) in places.iter().enumerate() {
                self.result.jacobian[(row, column)] = self.inner.jacobian[(*i, *j)];
            }
        }
        self.has_stick = contact.law.has_stick();
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
        self.wide.convert(&self.inner.force, self.set, &mut self.result.force);
        self.has_stick = contact.law.has_stick();
        self.complete = false;
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

    fn result(&self) -> &ForceMap {
        &self.result
    }

    fn forget(&mut self) {
        self.inner.forget();
    }

    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        let full = from_samples(self.inner.forces(), 1, set.highest());
        HarmonicSet::full(full.len() / 2).convert(&full, set, out);
    }

    fn summary(&mut self) -> CycleSummary {
        let passed = || self.inner.passed();
        let low = passed().min_by(|a, b| a.0.total_cmp(&b.0)).map_or((0.0, 0.0), |p| (p.0, p.2));
        let high = passed().max_by(|a, b| a.0.total_cmp(&b.0)).map_or((0.0, 0.0), |p| (p.0, p.2));
        let stuck = passed().filter(|(_, state, _)| *state == SlipState::Stick).count();
        debug_assert_eq!(self.displacement.len(), coefficient_count(self.wide.highest()));
        CycleSummary {
            dissipated_energy: work_per_cycle(&self.inner.force, &self.displacement),
            equivalent_stiffness: (high.1 - low.1) / (high.0 - low.0),
            stick_fraction: self.has_stick.then(|| stuck as f64 / self.inner.forces().len() as f64),
        }
    }
}
