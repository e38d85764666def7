//! A contact whose structure has taken over a damper from it.

use nalgebra::DMatrix;

use super::map::ContactMap;
use super::{Cycle, CycleSummary, PeriodicContact};
use crate::harmonic::{HarmonicError, Method};
use crate::numeric::HarmonicSet;

/// A contact map less `damping · u̇`.
///
/// A structure alone has no free vibration of its own frequency at a finite compliance; with a damper at the
/// contact it has. The damper that the structure is given is taken from the contact, which leaves the sum of
/// both forces as it was.
#[derive(Debug)]
pub(crate) struct ShiftedMap {
    map: ContactMap,
    set: HarmonicSet,
    /// N s/m.
    damping: f64,
    displacement: Vec<f64>,
    angular_frequency: f64,
    force: Vec<f64>,
    jacobian: DMatrix<f64>,
    by_frequency: Vec<f64>,
}

impl ShiftedMap {
    /// A contact map on `set`, without `damping` (N s/m), which may be zero.
    pub fn new(set: HarmonicSet, method: Method, damping: f64) -> Self {
        Self {
            map: ContactMap::new(set, method),
            set,
            damping,
            displacement: Vec::new(),
            angular_frequency: 0.0,
            force: Vec::new(),
            jacobian: DMatrix::zeros(0, 0),
            by_frequency: Vec::new(),
        }
    }

    /// Coefficients of the contact's own force (N) at the last evaluation.
    pub fn own_force(&self) -> &[f64] {
        self.map.force()
    }
}

impl Cycle for ShiftedMap {
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.map.evaluate(contact, angular_frequency, u)?;
        if self.damping == 0.0 {
            return Ok(());
        }
        self.displacement.clear();
        self.displacement.extend_from_slice(u);
        self.angular_frequency = angular_frequency;
        self.force.clear();
        self.force.extend_from_slice(self.map.force());
        self.by_frequency.clear();
        self.by_frequency.extend_from_slice(self.map.by_frequency());
        self.jacobian.clone_from(self.map.jacobian());
        for (order, c) in self.set.orders().filter(|(order, _)| *order > 0) {
            let (s, rate) = (c + 1, order as f64 * self.damping);
            let stiffness = rate * angular_frequency;
            self.force[c] -= stiffness * u[s];
            self.force[s] += stiffness * u[c];
            self.by_frequency[c] -= rate * u[s];
            self.by_frequency[s] += rate * u[c];
            self.jacobian[(c, s)] -= stiffness;
            self.jacobian[(s, c)] += stiffness;
        }
        Ok(())
    }

    fn evaluate_force(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        if self.damping == 0.0 {
            return self.map.evaluate_force(contact, angular_frequency, u);
        }
        self.evaluate(contact, angular_frequency, u)
    }

    fn complete(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        if self.damping == 0.0 { self.map.complete(contact, angular_frequency, u) } else { Ok(()) }
    }

    fn force(&self) -> &[f64] {
        if self.damping == 0.0 { self.map.force() } else { &self.force }
    }

    fn jacobian(&self) -> &DMatrix<f64> {
        if self.damping == 0.0 { self.map.jacobian() } else { &self.jacobian }
    }

    fn by_frequency(&self) -> &[f64] {
        if self.damping == 0.0 { self.map.by_frequency() } else { &self.by_frequency }
    }

    fn forget(&mut self) {
        self.map.forget();
    }

    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        self.map.force_on(set, out);
        if self.damping == 0.0 {
            return;
        }
        for (order, from) in self.set.orders().filter(|(order, _)| *order > 0) {
            if let Some(into) = set.place(order) {
                let stiffness = order as f64 * self.damping * self.angular_frequency;
                out[into] -= stiffness * self.displacement[from + 1];
                out[into + 1] += stiffness * self.displacement[from];
            }
        }
    }

    fn force_alone(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
        set: HarmonicSet,
        out: &mut [f64],
    ) -> Result<(), HarmonicError> {
        if self.damping == 0.0 {
            return self.map.force_alone(contact, angular_frequency, u, set, out);
        }
        self.evaluate(contact, angular_frequency, u)?;
        self.force_on(set, out);
        Ok(())
    }

    fn summary(&mut self) -> CycleSummary {
        self.map.summary()
    }
}
