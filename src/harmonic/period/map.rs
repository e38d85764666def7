//! The choice of the scheme by which a contact is carried over a period, and the damper beside it.

use super::piecewise::PiecewiseCycle;
use super::reference::ReferenceCycle;
use super::smooth::SmoothCycle;
use super::{Cycle, CycleSummary, ForceMap, PeriodicContact};
use crate::contact::Slider;
use crate::harmonic::settings::SAMPLES_IN_MOTION;
use crate::harmonic::{HarmonicError, Method};
use crate::numeric::HarmonicSet;

/// A contact map by the given method: of the exact ones the one that fits the law.
///
/// A damper is linear in the motion, and so exact in coefficients: that of a law beside its sliders, less one that the
/// structure has taken over from the contact. A structure alone has no free vibration of its own frequency at a finite
/// compliance; with a damper at the contact it has, and taking the damper from the contact leaves the sum of both forces
/// as it was.
#[derive(Debug)]
pub(crate) struct ContactMap {
    set: HarmonicSet,
    method: Method,
    sliders: Vec<Slider>,
    scheme: Scheme,
    cycle: Box<dyn Cycle>,
    /// Dampers (N s/m): of the law beside what the cycle follows, and taken over by the structure.
    own_damping: f64,
    shift: f64,
    displacement: Vec<f64>,
    angular_frequency: f64,
    result: ForceMap,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scheme {
    Piecewise,
    Smooth,
    Sampled(usize),
}

impl Scheme {
    fn cycle(self, set: HarmonicSet) -> Box<dyn Cycle> {
        match self {
            Self::Piecewise => Box::new(PiecewiseCycle::new(set)),
            Self::Smooth => Box::new(SmoothCycle::new(set)),
            Self::Sampled(samples) => Box::new(ReferenceCycle::new(set, samples)),
        }
    }
}

impl ContactMap {
    /// A contact map on `set`, less the damper `shift` (N s/m), which may be zero.
    pub fn new(set: HarmonicSet, method: Method, shift: f64) -> Self {
        let scheme = match method {
            Method::Exact => Scheme::Piecewise,
            Method::Sampled { samples } => Scheme::Sampled(samples),
        };
        Self {
            set,
            method,
            sliders: Vec::new(),
            scheme,
            cycle: scheme.cycle(set),
            own_damping: 0.0,
            shift,
            displacement: Vec::new(),
            angular_frequency: 0.0,
            result: ForceMap::new(0),
        }
    }

    /// Makes the scheme fit the law.
    fn choose(&mut self, contact: &PeriodicContact) -> Result<(), HarmonicError> {
        if let Method::Sampled { samples } = self.method {
            return if samples < 8 * self.set.highest() {
                Err(HarmonicError::InvalidInput("fewer than 8 samples per harmonic"))
            } else {
                Ok(())
            };
        }
        let moving = contact.law.limit_moves() || !contact.load_swing.is_empty();
        let damping = if moving {
            None
        } else {
            let damping = contact.law.sliders_and_damper(contact.normal_load, &mut self.sliders);
            // Behind a spring the damper's velocity is not that of the displacement given.
            damping.filter(|damping| *damping == 0.0 || contact.compliance == 0.0)
        };
        let scheme = match damping {
            Some(_) => Scheme::Piecewise,
            None if moving => Scheme::Sampled(SAMPLES_IN_MOTION),
            None => Scheme::Smooth,
        };
        if self.scheme != scheme {
            (self.scheme, self.cycle) = (scheme, scheme.cycle(self.set));
        }
        self.own_damping = damping.unwrap_or(0.0);
        Ok(())
    }

    /// Whether there is no damper beside what the cycle follows.
    fn is_plain(&self) -> bool {
        self.own_damping == 0.0 && self.shift == 0.0
    }

    fn take_motion(&mut self, angular_frequency: f64, u: &[f64]) {
        self.displacement.clear();
        self.displacement.extend_from_slice(u);
        self.angular_frequency = angular_frequency;
    }

    /// Adds the force on `set` of a damper (N s/m) to `out`.
    fn add_damper(&self, damping: f64, set: HarmonicSet, out: &mut [f64]) {
        for (order, place) in self.set.orders().filter(|(order, _)| *order > 0) {
            if let Some(to) = set.place(order) {
                let rate = damping * self.angular_frequency * order as f64;
                out[to] += rate * self.displacement[place + 1];
                out[to + 1] -= rate * self.displacement[place];
            }
        }
    }

    /// Coefficients of the contact's own force (N) at the last evaluation.
    pub fn own_force(&self) -> Vec<f64> {
        let mut force = self.cycle.force().to_vec();
        if self.own_damping != 0.0 {
            self.add_damper(self.own_damping, self.set, &mut force);
        }
        force
    }
}

impl Cycle for ContactMap {
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.choose(contact)?;
        self.cycle.evaluate(contact, angular_frequency, u)?;
        if self.is_plain() {
            return Ok(());
        }
        self.take_motion(angular_frequency, u);
        let damping = self.own_damping - self.shift;
        self.result.copy(self.cycle.result());
        let mut force = std::mem::take(&mut self.result.force);
        self.add_damper(damping, self.set, &mut force);
        self.result.force = force;
        for (order, place) in self.set.orders().filter(|(order, _)| *order > 0) {
            // (c cos hθ + s sin hθ)' = h s cos hθ − h c sin hθ.
            let rate = damping * order as f64;
            self.result.jacobian[(place, place + 1)] += rate * angular_frequency;
            self.result.jacobian[(place + 1, place)] -= rate * angular_frequency;
            self.result.by_frequency[place] += rate * u[place + 1];
            self.result.by_frequency[place + 1] -= rate * u[place];
        }
        Ok(())
    }

    fn evaluate_force(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.choose(contact)?;
        if self.is_plain() {
            return self.cycle.evaluate_force(contact, angular_frequency, u);
        }
        self.evaluate(contact, angular_frequency, u)
    }

    fn complete(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        if self.is_plain() { self.cycle.complete(contact, angular_frequency, u) } else { Ok(()) }
    }

    fn follow(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.choose(contact)?;
        self.take_motion(angular_frequency, u);
        self.cycle.follow(contact, angular_frequency, u)
    }

    fn result(&self) -> &ForceMap {
        if self.is_plain() { self.cycle.result() } else { &self.result }
    }

    fn forget(&mut self) {
        self.cycle.forget();
    }

    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        self.cycle.force_on(set, out);
        if !self.is_plain() {
            self.add_damper(self.own_damping - self.shift, set, out);
        }
    }

    /// Where the motion turns the damper has no force: the slope from tip to tip is that of the rest.
    fn summary(&mut self) -> CycleSummary {
        let mut summary = self.cycle.summary();
        if self.own_damping != 0.0 {
            for (order, place) in self.set.orders().filter(|(order, _)| *order > 0) {
                let square = self.displacement[place].powi(2) + self.displacement[place + 1].powi(2);
                let rate = self.own_damping * self.angular_frequency * (order * order) as f64;
                summary.dissipated_energy += std::f64::consts::PI * rate * square;
            }
        }
        summary
    }
}
