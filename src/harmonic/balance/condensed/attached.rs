//! A contact of a condensed structure, with a parameter that may vary.

use crate::contact::ContactLaw;
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::variation::{Rebuild, differentiate};
use crate::harmonic::period::damping_shift::ShiftedMap;
use crate::harmonic::period::{Cycle, PeriodicContact};

pub(super) enum Law<'a> {
    Given(&'a dyn ContactLaw),
    Built(Box<dyn ContactLaw>),
}

pub(super) fn contact_of<'l>(law: &'l Law, normal_load: f64) -> PeriodicContact<'l> {
    let law = match law {
        Law::Given(law) => *law,
        Law::Built(law) => law.as_ref(),
    };
    PeriodicContact { law, normal_load, load_swing: &[], compliance: 0.0 }
}

pub(super) struct Attached<'a> {
    pub law: Law<'a>,
    pub normal_load: f64,
    pub rebuild: Option<Rebuild<'a>>,
    /// Least size of the parameter, by which steps of it are measured.
    pub least: f64,
    /// Compliance (m/N) of a spring in front of the contact, on the way to a start.
    pub homotopy_compliance: f64,
    /// Whether the harmonics kept ask for an odd law.
    pub odd: bool,
    pub cycle: ShiftedMap,
    /// The same contact on twice the harmonics, to see what the set leaves out.
    pub wide: Option<ShiftedMap>,
    /// ∂force/∂parameter on the set.
    pub by_parameter: Vec<f64>,
}

impl Attached<'_> {
    pub fn evaluate(&mut self, angular_frequency: f64, u: &[f64]) -> Result<(), HarmonicError> {
        let contact = PeriodicContact {
            compliance: self.homotopy_compliance,
            ..contact_of(&self.law, self.normal_load)
        };
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
    pub fn vary(&mut self, angular_frequency: f64, u: &[f64], parameter: f64) -> Result<(), HarmonicError> {
        let mut by = std::mem::take(&mut self.by_parameter);
        let varied = differentiate(parameter, self.least, &mut by, &mut |value, force| {
            self.build(value)?;
            self.evaluate(angular_frequency, u)?;
            force.clear();
            force.extend_from_slice(self.cycle.force());
            Ok(())
        });
        self.by_parameter = by;
        varied
    }
}
