//! The choice of the way a contact is carried over a period.

use nalgebra::DMatrix;

use super::damped::DampedCycle;
use super::piecewise::PiecewiseCycle;
use super::reference::ReferenceCycle;
use super::smooth::SmoothCycle;
use super::{Cycle, CycleSummary, PeriodicContact};
use crate::contact::Slider;
use crate::harmonic::{HarmonicError, Method};
use crate::numeric::HarmonicSet;

/// Samples of a period where the limit itself moves, or the load that it follows: the force is then right to a few parts in ten thousand.
const SAMPLES_IN_MOTION: usize = 1024;

/// A contact map by the given method: of the exact ones the one that fits the law.
#[derive(Debug)]
pub(crate) struct ContactMap {
    set: HarmonicSet,
    method: Method,
    sliders: Vec<Slider>,
    scheme: Scheme,
}

#[derive(Debug)]
enum Scheme {
    Piecewise(Box<PiecewiseCycle>),
    Damped(Box<DampedCycle>),
    Smooth(Box<SmoothCycle>),
    Reference(Box<ReferenceCycle>),
}

impl ContactMap {
    /// A contact map on `set`.
    pub fn new(set: HarmonicSet, method: Method) -> Self {
        let scheme = match method {
            Method::Exact => Scheme::Piecewise(Box::new(PiecewiseCycle::new(set))),
            Method::Sampled { samples } => Scheme::Reference(Box::new(ReferenceCycle::new(set, samples))),
        };
        Self { set, method, sliders: Vec::new(), scheme }
    }

    /// Makes the way fit the law.
    fn choose(&mut self, contact: &PeriodicContact) {
        if self.method != Method::Exact {
            return;
        }
        if contact.law.limit_moves() || !contact.load_swing.is_empty() {
            if !matches!(self.scheme, Scheme::Reference(_)) {
                self.scheme = Scheme::Reference(Box::new(ReferenceCycle::new(self.set, SAMPLES_IN_MOTION)));
            }
            return;
        }
        let damping = contact.law.sliders_and_damper(contact.normal_load, &mut self.sliders);
        // Behind a spring the damper's velocity is not that of the displacement given.
        let damping = damping.filter(|damping| *damping == 0.0 || contact.compliance == 0.0);
        match (&self.scheme, damping) {
            (Scheme::Piecewise(_), Some(0.0)) | (Scheme::Damped(_), Some(_)) | (Scheme::Smooth(_), None) => {}
            (_, Some(0.0)) => self.scheme = Scheme::Piecewise(Box::new(PiecewiseCycle::new(self.set))),
            (_, Some(_)) => self.scheme = Scheme::Damped(Box::new(DampedCycle::new(self.set))),
            (_, None) => self.scheme = Scheme::Smooth(Box::new(SmoothCycle::new(self.set))),
        }
    }

    fn check(&self) -> Result<(), HarmonicError> {
        match self.method {
            Method::Sampled { samples } if samples < 8 * self.set.highest() => {
                Err(HarmonicError::InvalidInput("fewer than 8 samples per harmonic"))
            }
            _ => Ok(()),
        }
    }

    fn cycle(&self) -> &dyn Cycle {
        match &self.scheme {
            Scheme::Piecewise(cycle) => cycle.as_ref(),
            Scheme::Damped(cycle) => cycle.as_ref(),
            Scheme::Smooth(cycle) => cycle.as_ref(),
            Scheme::Reference(cycle) => cycle.as_ref(),
        }
    }

    fn cycle_mut(&mut self) -> &mut dyn Cycle {
        match &mut self.scheme {
            Scheme::Piecewise(cycle) => cycle.as_mut(),
            Scheme::Damped(cycle) => cycle.as_mut(),
            Scheme::Smooth(cycle) => cycle.as_mut(),
            Scheme::Reference(cycle) => cycle.as_mut(),
        }
    }
}

impl Cycle for ContactMap {
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.check()?;
        self.choose(contact);
        self.cycle_mut().evaluate(contact, angular_frequency, u)
    }

    fn evaluate_force(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.check()?;
        self.choose(contact);
        self.cycle_mut().evaluate_force(contact, angular_frequency, u)
    }

    fn complete(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.cycle_mut().complete(contact, angular_frequency, u)
    }

    fn force_alone(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
        set: HarmonicSet,
        out: &mut [f64],
    ) -> Result<(), HarmonicError> {
        self.choose(contact);
        self.cycle_mut().force_alone(contact, angular_frequency, u, set, out)
    }

    fn force(&self) -> &[f64] {
        self.cycle().force()
    }

    fn jacobian(&self) -> &DMatrix<f64> {
        self.cycle().jacobian()
    }

    fn by_frequency(&self) -> &[f64] {
        self.cycle().by_frequency()
    }

    fn forget(&mut self) {
        self.cycle_mut().forget();
    }

    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        self.cycle_mut().force_on(set, out);
    }

    fn summary(&mut self) -> CycleSummary {
        self.cycle_mut().summary()
    }
}
