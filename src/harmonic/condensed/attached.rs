//! A contact of a condensed structure, with a parameter that may vary.

use crate::contact::ContactLaw;
use crate::harmonic::HarmonicError;
use crate::harmonic::cycle::relieved::RelievedMap;
use crate::harmonic::cycle::{Cycle, PeriodicContact};

/// Makes a contact of the value of the model's parameter.
pub(crate) type Rebuild<'a> = Box<dyn FnMut(f64) -> Result<(Box<dyn ContactLaw>, f64), HarmonicError> + 'a>;

pub(super) enum Law<'a> {
    Given(&'a dyn ContactLaw),
    Built(Box<dyn ContactLaw>),
}

pub(super) fn contact_of<'l>(law: &'l Law, normal_load: f64) -> PeriodicContact<'l> {
    let law = match law {
        Law::Given(law) => *law,
        Law::Built(law) => law.as_ref(),
    };
    PeriodicContact { law, normal_load, compliance: 0.0 }
}

pub(super) struct Attached<'a> {
    pub law: Law<'a>,
    pub normal_load: f64,
    pub rebuild: Option<Rebuild<'a>>,
    /// Least size of the parameter, by which steps of it are measured.
    pub least: f64,
    /// Compliance (m/N) of a spring in front of the contact, on the way to a start.
    pub softening: f64,
    /// Whether the harmonics kept ask for an odd law.
    pub odd: bool,
    pub cycle: RelievedMap,
    /// The same contact on twice the harmonics, to see what the set leaves out.
    pub wide: Option<RelievedMap>,
    /// ∂force/∂parameter on the set.
    pub by_parameter: Vec<f64>,
}

impl Attached<'_> {
    pub fn evaluate(&mut self, angular_frequency: f64, u: &[f64]) -> Result<(), HarmonicError> {
        let contact =
            PeriodicContact { compliance: self.softening, ..contact_of(&self.law, self.normal_load) };
        self.cycle.evaluate(&contact, angular_frequency, u)
    }

    pub fn build(&mut self, parameter: f64) -> Result<(), HarmonicError> {
        if let Some(rebuild) = &mut self.rebuild {
            let (law, normal_load) = rebuild(parameter)?;
            if self.odd && !law.is_odd() {
                return Err(HarmonicError::InvalidInput(
                    "the contact loses its symmetry with the parameter: all harmonics are needed",
                ));
            }
            (self.law, self.normal_load) = (Law::Built(law), normal_load);
        }
        Ok(())
    }

    /// The contact at `parameter` under `u`, and how its force changes with the parameter.
    ///
    /// Forces have kinks where a contact begins to slip, which a response reaches just there. A difference across
    /// one is no derivative of either side, so the step shrinks until none is in sight.
    pub fn vary(
        &mut self,
        angular_frequency: f64,
        u: &[f64],
        parameter: f64,
        sample: &mut Vec<f64>,
    ) -> Result<(), HarmonicError> {
        const LONGEST: f64 = 1e-5;
        const SHORTEST: f64 = 1e-9;
        /// Second difference over first that is a kink's, and what rounding makes of the force.
        const KINK: f64 = 1e-3;
        const ROUNDING: f64 = 1e-13;
        let size = parameter.abs().max(self.least);
        let size = if size > 0.0 { size } else { 1.0 };
        let mut step = LONGEST * size;
        loop {
            self.build(parameter + step)?;
            self.evaluate(angular_frequency, u)?;
            self.by_parameter.copy_from_slice(self.cycle.force());
            self.build(parameter - step)?;
            self.evaluate(angular_frequency, u)?;
            sample.clear();
            sample.extend_from_slice(self.cycle.force());
            self.build(parameter)?;
            self.evaluate(angular_frequency, u)?;
            let (mut change, mut bend, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
            let sides = self.by_parameter.iter_mut().zip(&*sample).zip(self.cycle.force());
            for ((above, below), here) in sides {
                change = change.max((*above - below).abs());
                bend = bend.max((*above - 2.0 * here + below).abs());
                largest = largest.max(here.abs());
                *above = (*above - below) / (2.0 * step);
            }
            if bend <= KINK * change + ROUNDING * largest || step <= SHORTEST * size {
                return Ok(());
            }
            step *= 0.1;
        }
    }
}
