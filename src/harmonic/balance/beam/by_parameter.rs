//! The balance as the contact changes with the model's parameter.

use super::Balance;
use super::varied::Varied;
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::variation::{Rebuild, differentiate};

impl<'a> Balance<'a> {
    /// Makes the contact anew, by `rebuild`, for every value of the parameter.
    pub fn vary(&mut self, least: f64, rebuild: Rebuild<'a>) {
        let by_parameter = vec![0.0; self.wide];
        self.varied = Some(Varied { rebuild, built: None, value: f64::NAN, least, by_parameter });
    }

    /// Makes the contact that belongs to the parameter's value.
    pub(super) fn build(&mut self, parameter: f64) -> Result<(), HarmonicError> {
        let Some(varied) = &mut self.varied else { return Ok(()) };
        if varied.value != parameter {
            varied.value = f64::NAN;
            varied.built = Some((varied.rebuild)(parameter)?);
            varied.value = parameter;
        }
        Ok(())
    }

    /// How the force changes with the parameter where the contact is displaced by `u`.
    pub(super) fn vary_force(
        &mut self,
        angular_frequency: f64,
        u: &[f64],
        parameter: f64,
    ) -> Result<(), HarmonicError> {
        let Some(varied) = &mut self.varied else { return Ok(()) };
        let least = varied.least;
        let mut by = std::mem::take(&mut varied.by_parameter);
        let done = differentiate(parameter, least, &mut by, &mut |value, force| {
            self.build(value)?;
            let found = self.contact_force(angular_frequency, u, 0.0)?;
            force.clear();
            force.extend_from_slice(found);
            Ok(())
        });
        if let Some(varied) = &mut self.varied {
            varied.by_parameter = by;
        }
        done
    }

    /// Writes ∂forces/∂parameter at fixed unknowns; false where it vanishes.
    pub(super) fn force_by_parameter(&mut self) -> bool {
        self.rates.fill(0.0);
        if let Some(varied) = &self.varied {
            self.rates[..self.wide].copy_from_slice(&varied.by_parameter);
        }
        self.rates.iter().any(|rate| *rate != 0.0)
    }
}
