//! A law over a period, at the unknowns that are the displacement of its port.

use std::sync::Arc;

use crate::contact::ContactLaw;
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::period::{Cycle, PeriodicContact};
use crate::numeric::HarmonicSet;

/// The law of an element, with all that a period does to it.
#[derive(Debug)]
pub(crate) struct Attached {
    pub law: Arc<dyn ContactLaw>,
    pub normal_load: f64,
    /// Swing of the normal load, as [`PeriodicContact::load_swing`].
    load_swing: Vec<f64>,
    /// Displacement (m) at which the law that never moved has no force.
    static_offset: f64,
    /// Compliance (m/N) of a spring in front of the law.
    pub compliance: f64,
    pub cycle: ContactMap,
    /// Displacement from the offset.
    displaced: Vec<f64>,
    force: Vec<f64>,
}

impl Attached {
    /// The law of element `element` of `assembly`, over a period by `cycle`.
    pub fn new(
        assembly: &Assembly,
        element: usize,
        law: (&Arc<dyn ContactLaw>, f64),
        cycle: ContactMap,
    ) -> Self {
        let swing = assembly.load_swings.iter().find(|(of, _)| *of == element);
        let offset = assembly.static_offsets.iter().find(|(of, _)| *of == element);
        Self {
            law: law.0.clone(),
            normal_load: law.1,
            load_swing: swing.map_or_else(Vec::new, |(_, swing)| swing.clone()),
            static_offset: offset.map_or(0.0, |(_, offset)| *offset),
            compliance: 0.0,
            cycle,
            displaced: Vec::new(),
            force: Vec::new(),
        }
    }

    /// Another law takes its place.
    pub fn replace(&mut self, law: &Arc<dyn ContactLaw>, normal_load: f64) {
        (self.law, self.normal_load) = (law.clone(), normal_load);
    }

    fn parts<'s>(&'s mut self, u: &'s [f64]) -> (PeriodicContact<'s>, &'s mut ContactMap, &'s [f64]) {
        let Self { law, normal_load, load_swing, static_offset, compliance, cycle, displaced, .. } = self;
        let law: &'s Arc<dyn ContactLaw> = law;
        let contact = PeriodicContact {
            law: law.as_ref(),
            normal_load: *normal_load,
            load_swing,
            compliance: *compliance,
        };
        if *static_offset == 0.0 {
            return (contact, cycle, u);
        }
        displaced.clear();
        displaced.extend_from_slice(u);
        displaced[0] -= *static_offset;
        (contact, cycle, displaced)
    }

    /// The law under the displacement `u`, with derivatives.
    pub fn evaluate(&mut self, angular_frequency: f64, u: &[f64]) -> Result<(), HarmonicError> {
        let (contact, cycle, u) = self.parts(u);
        cycle.evaluate(&contact, angular_frequency, u)
    }

    /// Leaves the force under `u` for [`Self::force`], the derivatives to [`Self::complete`]; none can follow where it is
    /// wanted `alone`.
    pub fn evaluate_force(
        &mut self,
        angular_frequency: f64,
        u: &[f64],
        alone: bool,
    ) -> Result<(), HarmonicError> {
        let mut force = std::mem::take(&mut self.force);
        force.resize(u.len(), 0.0);
        let (contact, cycle, u) = self.parts(u);
        let done = if alone {
            cycle.force_alone(&contact, angular_frequency, u, HarmonicSet::full(u.len() / 2), &mut force)
        } else {
            let done = cycle.evaluate_force(&contact, angular_frequency, u);
            force.copy_from_slice(cycle.force());
            done
        };
        self.force = force;
        done
    }

    /// Makes the derivatives. Where they are not found those there are stay: a step with them is judged by the residual
    /// as any other.
    pub fn complete(&mut self, angular_frequency: f64, u: &[f64]) {
        let (contact, cycle, u) = self.parts(u);
        let _ = cycle.complete(&contact, angular_frequency, u);
    }

    /// Coefficients of the force (N) that [`Self::evaluate_force`] left.
    pub fn force(&self) -> &[f64] {
        &self.force
    }

    /// Coefficients on `set` of the force (N) under `u`, of which no derivatives follow, by the cycle `other`.
    pub fn force_alone(
        &mut self,
        other: &mut ContactMap,
        angular_frequency: f64,
        u: &[f64],
        set: HarmonicSet,
        out: &mut [f64],
    ) -> Result<(), HarmonicError> {
        let (contact, _, u) = self.parts(u);
        other.force_alone(&contact, angular_frequency, u, set, out)
    }
}
