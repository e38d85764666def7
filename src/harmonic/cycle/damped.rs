//! Sliders with a viscous damper beside them: exact, as the damper is linear in the motion.

use nalgebra::DMatrix;

use super::piecewise::PiecewiseCycle;
use super::{Cycle, CycleSummary, PeriodicContact};
use crate::contact::Slider;
use crate::harmonic::HarmonicError;
use crate::harmonic::set::HarmonicSet;

/// [`PiecewiseCycle`] and `c u'` beside it, without a spring in series.
#[derive(Debug)]
pub(crate) struct DampedCycle {
    set: HarmonicSet,
    inner: PiecewiseCycle,
    sliders: Vec<Slider>,
    damping: f64,
    angular_frequency: f64,
    displacement: Vec<f64>,
    force: Vec<f64>,
    jacobian: DMatrix<f64>,
    by_frequency: Vec<f64>,
}

impl DampedCycle {
    pub fn new(set: HarmonicSet) -> Self {
        let size = set.len();
        Self {
            set,
            inner: PiecewiseCycle::new(set),
            sliders: Vec::new(),
            damping: 0.0,
            angular_frequency: 0.0,
            displacement: vec![0.0; size],
            force: vec![0.0; size],
            jacobian: DMatrix::zeros(size, size),
            by_frequency: vec![0.0; size],
        }
    }

    /// Takes the arguments of an evaluation.
    fn set(&mut self, contact: &PeriodicContact, angular_frequency: f64, u: &[f64]) {
        debug_assert_eq!(contact.compliance, 0.0);
        let damping = contact.law.sliders_and_damper(contact.normal_load, &mut self.sliders);
        self.damping = damping.unwrap_or(0.0);
        self.angular_frequency = angular_frequency;
        self.displacement.copy_from_slice(u);
    }

    /// Adds the damper's force on `set` to `out`.
    fn add_damper(&self, set: HarmonicSet, out: &mut [f64]) {
        for (order, place) in self.set.orders().filter(|(order, _)| *order > 0) {
            if let Some(to) = set.place(order) {
                let rate = self.damping * self.angular_frequency * order as f64;
                out[to] += rate * self.displacement[place + 1];
                out[to + 1] -= rate * self.displacement[place];
            }
        }
    }
}

impl Cycle for DampedCycle {
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.set(contact, angular_frequency, u);
        self.inner.evaluate(contact, angular_frequency, u)?;
        self.force.copy_from_slice(self.inner.force());
        self.jacobian.copy_from(self.inner.jacobian());
        let mut force = std::mem::take(&mut self.force);
        self.add_damper(self.set, &mut force);
        self.force = force;
        for (order, place) in self.set.orders().filter(|(order, _)| *order > 0) {
            // (c cos hθ + s sin hθ)' = h s cos hθ − h c sin hθ.
            let rate = self.damping * order as f64;
            self.jacobian[(place, place + 1)] += rate * angular_frequency;
            self.jacobian[(place + 1, place)] -= rate * angular_frequency;
            self.by_frequency[place] = rate * u[place + 1];
            self.by_frequency[place + 1] = -rate * u[place];
        }
        Ok(())
    }

    fn force_alone(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
        set: HarmonicSet,
        out: &mut [f64],
    ) -> Result<(), HarmonicError> {
        self.set(contact, angular_frequency, u);
        self.inner.force_alone(contact, angular_frequency, u, set, out)?;
        self.add_damper(set, out);
        Ok(())
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
        self.inner.force_on(set, out);
        self.add_damper(set, out);
    }

    /// Where the motion turns the damper has no force: the slope from tip to tip is that of the sliders.
    fn summary(&mut self) -> CycleSummary {
        let mut summary = self.inner.summary();
        for (order, place) in self.set.orders().filter(|(order, _)| *order > 0) {
            let square = self.displacement[place].powi(2) + self.displacement[place + 1].powi(2);
            let rate = self.damping * self.angular_frequency * (order * order) as f64;
            summary.dissipated_energy += std::f64::consts::PI * rate * square;
        }
        summary
    }
}
