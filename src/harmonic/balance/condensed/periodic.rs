//! The condensed balance as a [`PeriodicSystem`]: what continuation, tracking and conditions ask of it.

use nalgebra::DMatrix;

use super::{Condensed, method_on, set_of};
use crate::harmonic::balance::transfer::Of;
use crate::harmonic::newton::system::{Observation, Operating, PeriodicSystem, Scalar};
use crate::harmonic::period::Cycle;
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::stability::Undecided;
use crate::harmonic::{HarmonicError, Point};
use crate::numeric::HarmonicSet;
use crate::system::System;

impl PeriodicSystem for Condensed {
    fn unknowns(&self) -> usize {
        self.residual.len()
    }

    fn evaluate(&mut self, x: &[f64], at: &Operating, scalars: &[Scalar]) -> Result<f64, HarmonicError> {
        self.at = *at;
        self.at_contacts.evaluate(&mut self.receptance, at)?;
        self.carry(x, at)?;
        let scale = self.balance(x, at);
        self.differentiate();
        scalars.iter().for_each(|scalar| self.differentiate_by(*scalar, at));
        Ok(scale)
    }

    fn residual(&self) -> &[f64] {
        &self.residual
    }

    fn jacobian(&mut self) -> &DMatrix<f64> {
        &self.jacobian
    }

    fn by(&self, scalar: Scalar) -> &[f64] {
        &self.by[scalar.index()]
    }

    fn output(&mut self, node: usize, order: usize) -> [f64; 2] {
        self.seen(node, order)
    }

    fn observe(&mut self, node: usize, order: usize, out: &mut Observation) {
        self.look(node, order, out);
    }

    fn forget(&mut self) {
        self.contacts.iter_mut().for_each(|contact| contact.cycle.forget());
    }

    fn nodes(&self) -> usize {
        self.nodes
    }

    fn harmonics(&self) -> usize {
        self.set.highest()
    }

    fn guess(&mut self, at: &Operating, x: &mut [f64]) -> Result<(), HarmonicError> {
        self.linearised(at, x)
    }

    fn rounding(&mut self, at: &Operating) -> f64 {
        self.rounding_about(at)
    }

    fn compliance_homotopy(&mut self, compliances: f64) -> bool {
        let p = self.contacts.len();
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            // The largest at the harmonics of the last evaluation.
            let own = (0..self.orders.len()).map(|k| {
                let [re, im] = self.at_contacts.get(k, Of::Value, i, i);
                re.hypot(im)
            });
            contact.compliance = compliances * own.fold(0.0, f64::max);
        }
        p > 0
    }

    fn describe(&mut self, x: &[f64], at: &Operating) -> Result<Point, HarmonicError> {
        self.point(x, at)
    }

    fn nodes_along(&mut self, unknowns: &[f64], scalars: &[f64; 4], out: &mut [Vec<f64>]) {
        self.derivatives_along(unknowns, scalars, out);
    }

    fn truncation_error(
        &mut self,
        x: &[f64],
        at: &Operating,
        point: &Point,
        solve: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, HarmonicError> {
        self.left_out(x, at, point, solve)
    }

    fn stable(&mut self, point: &Point) -> Result<bool, Undecided> {
        self.lasts(point)
    }

    fn resume(&self, point: &Point, x: &mut [f64]) -> bool {
        if point.contacts.len() != self.contacts.len() {
            return false;
        }
        for (contact, u) in point.contacts.iter().zip(x.chunks_exact_mut(self.set.len())) {
            let known = &contact.displacement;
            if known.len().is_multiple_of(2) {
                return false;
            }
            HarmonicSet::full(known.len() / 2).convert(known, self.set, u);
        }
        true
    }

    fn replace_laws(&mut self, system: &System) -> Result<(), HarmonicError> {
        for (contact, (_, law, normal_load)) in self.contacts.iter_mut().zip(system.laws()) {
            if self.odd && !law.is_odd() {
                return Err(HarmonicError::InvalidInput(
                    "the contact loses its symmetry with the parameter: all harmonics are needed",
                ));
            }
            contact.replace(law, normal_load);
        }
        Ok(())
    }

    fn set_harmonics(
        &mut self,
        harmonics: usize,
        vectors: &mut [&mut Vec<f64>],
    ) -> Result<bool, HarmonicError> {
        let (old, new) = (self.set, set_of(self.odd, harmonics));
        for vector in vectors {
            let mut carried = vec![0.0; new.len() * self.contacts.len()];
            let parts = carried.chunks_exact_mut(new.len()).zip(vector.chunks_exact(old.len()));
            parts.for_each(|(into, from)| old.convert(from, new, into));
            **vector = carried;
        }
        self.set = new;
        let method = method_on(self.method, new);
        for contact in &mut self.contacts {
            contact.cycle = ContactMap::new(new, method, self.damping_shift);
        }
        self.reserve();
        Ok(true)
    }
}
