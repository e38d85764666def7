//! A contact law under a prescribed periodic displacement.

use nalgebra::DMatrix;

pub use super::CycleSummary;
use super::map::ContactMap;
use super::{Cycle, PeriodicContact};
use crate::contact::ContactLaw;
use crate::harmonic::{HarmonicError, HarmonicSet, Method};

/// The periodic response of a contact law to a displacement given by its harmonics.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCycle {
    /// Coefficients of the restoring force (N).
    pub force: Vec<f64>,
    /// ∂force coefficients/∂displacement coefficients (N/m).
    pub jacobian: DMatrix<f64>,
    /// Energy, stiffness and stick over the period.
    pub summary: CycleSummary,
}

/// The contact map of harmonic balance, for many evaluations: its buffers are kept, so that a repeated
/// evaluation allocates nothing.
///
/// ```
/// use stickslip::contact::Jenkins;
/// use stickslip::harmonic::{ContactMapping, HarmonicSet, Method};
/// let law = Jenkins::new(2.0, 0.5)?; // 2 N/m, and a limit of 0.5 N under a normal load of 1 N
/// let mut map = ContactMapping::new(HarmonicSet::odd(5), Method::Exact);
/// map.evaluate(&law, 1.0, 0.0, 1.0, &[3.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
/// let loop_area = 4.0 * 0.5 * (3.0 - 0.5 / 2.0);
/// assert!((map.summary().dissipated_energy - loop_area).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ContactMapping {
    set: HarmonicSet,
    map: ContactMap,
}

impl ContactMapping {
    /// A map between coefficients on `set`.
    pub fn new(set: HarmonicSet, method: Method) -> Self {
        Self { set, map: ContactMap::new(set, method, 0.0) }
    }

    /// Evaluates `law` under the constant `normal_load` (N), behind a spring of `compliance` (m/N; 0 for
    /// none), at the fundamental `angular_frequency` (rad/s) for the `displacement` coefficients (m) of
    /// contact and spring together.
    ///
    /// Where the memory does not fade (a stuck contact keeps whatever it remembers) the periodic state is
    /// that of a contact without history loaded to the displacement of the largest magnitude.
    ///
    /// # Errors
    /// [`HarmonicError::InvalidInput`] for as many coefficients as the set has not, for numbers that are not
    /// finite and for a negative compliance; [`HarmonicError::ContactNotPeriodic`] if no periodic state is
    /// found.
    pub fn evaluate(
        &mut self,
        law: &dyn ContactLaw,
        normal_load: f64,
        compliance: f64,
        angular_frequency: f64,
        displacement: &[f64],
    ) -> Result<(), HarmonicError> {
        if displacement.len() != self.set.len() {
            return Err(HarmonicError::InvalidInput("not as many displacement coefficients as the set has"));
        }
        let finite = [normal_load, compliance, angular_frequency].iter().all(|x| x.is_finite())
            && displacement.iter().all(|x| x.is_finite());
        if !finite || compliance < 0.0 {
            return Err(HarmonicError::InvalidInput("a number that is not finite, or a negative compliance"));
        }
        let contact = PeriodicContact { law, normal_load, load_swing: &[], compliance };
        self.map.evaluate(&contact, angular_frequency, displacement)
    }

    /// Coefficients of the force (N) of the last evaluation.
    pub fn force(&self) -> &[f64] {
        self.map.force()
    }

    /// ∂force/∂displacement coefficients (N/m) of the last evaluation.
    pub fn jacobian(&self) -> &DMatrix<f64> {
        self.map.jacobian()
    }

    /// ∂force coefficients/∂angular frequency (N s) of the last evaluation.
    pub fn by_frequency(&self) -> &[f64] {
        self.map.by_frequency()
    }

    /// Coefficients of the force (N) on another set of harmonics, for the displacement last evaluated.
    pub fn force_on(&mut self, set: HarmonicSet) -> Vec<f64> {
        let mut out = vec![0.0; set.len()];
        self.map.force_on(set, &mut out);
        out
    }

    /// What the contact did in the last evaluation.
    pub fn summary(&mut self) -> CycleSummary {
        self.map.summary()
    }
}

/// The periodic response of `law` under the constant `normal_load` (N) to the displacement with the
/// `coefficients` (m) on `set`, at the fundamental `angular_frequency` (rad/s), which only rate-dependent
/// laws notice.
///
/// # Errors
/// As [`ContactMapping::evaluate`].
///
/// ```
/// use stickslip::contact::Valanis;
/// use stickslip::harmonic::{HarmonicSet, contact_cycle};
/// let law = Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15)?;
/// let cycle = contact_cycle(&law, 147.15, 300.0, &[0.0, 10e-6, 0.0], HarmonicSet::full(1))?;
/// assert!((cycle.summary.dissipated_energy / 5.82422872e-4 - 1.0).abs() < 1e-8);
/// assert!((cycle.summary.equivalent_stiffness * 10e-6 - 66.332303).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact_cycle(
    law: &dyn ContactLaw,
    normal_load: f64,
    angular_frequency: f64,
    coefficients: &[f64],
    set: HarmonicSet,
) -> Result<ContactCycle, HarmonicError> {
    let mut map = ContactMapping::new(set, Method::Exact);
    map.evaluate(law, normal_load, 0.0, angular_frequency, coefficients)?;
    Ok(ContactCycle { force: map.force().to_vec(), jacobian: map.jacobian().clone(), summary: map.summary() })
}
