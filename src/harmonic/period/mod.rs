//! The periodic contact: Fourier coefficients of the displacement in, of the force out.
//!
//! This is the seam between the balance equations and the scheme by which a contact is carried over a period.

#[cfg(test)]
mod alone_tests;
mod closure;
pub(crate) mod contact_cycle;
#[cfg(test)]
mod damper_tests;
pub(crate) mod map;
mod motion;
pub(crate) mod pair;
#[cfg(test)]
mod pair_tests;
mod piecewise;
mod reference;
pub(crate) mod sampled;
mod slow;
mod smooth;
mod turning;
mod waves;

use nalgebra::DMatrix;

use crate::contact::ContactLaw;
use crate::harmonic::HarmonicError;
use crate::numeric::HarmonicSet;

/// A contact whose displacement is periodic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PeriodicContact<'a> {
    /// The law.
    pub law: &'a dyn ContactLaw,
    /// Normal load (N), constant or the mean of it.
    pub normal_load: f64,
    /// Coefficients `[c1, s1, …]` (N) of the load's swing over the period, on as many harmonics as it has; empty where
    /// it is constant.
    pub load_swing: &'a [f64],
    /// Compliance of a spring in series with the contact (m/N), 0 for none. The displacement is that of
    /// both together.
    pub compliance: f64,
}

/// What a contact does over a period of the solution last evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CycleSummary {
    /// Energy dissipated (J).
    pub dissipated_energy: f64,
    /// Slope from tip to tip of the loop (N/m): between the smallest and the largest displacement of
    /// the contact itself, without the series spring. NaN where nothing moves.
    pub equivalent_stiffness: f64,
    /// Fraction of the period in which no point of the contact slides or is apart; `None` for a law without a
    /// distinct stick.
    pub stick_fraction: Option<f64>,
}

/// What an evaluation gives.
#[derive(Debug)]
pub(crate) struct ForceMap {
    force: Vec<f64>,
    jacobian: DMatrix<f64>,
    by_frequency: Vec<f64>,
}

impl ForceMap {
    /// Zeros, on so many coefficients.
    fn new(size: usize) -> Self {
        Self { force: vec![0.0; size], jacobian: DMatrix::zeros(size, size), by_frequency: vec![0.0; size] }
    }

    /// Takes another's numbers, into the buffers there are.
    fn copy(&mut self, other: &Self) {
        self.force.clone_from(&other.force);
        self.jacobian.clone_from(&other.jacobian);
        self.by_frequency.clone_from(&other.by_frequency);
    }
}

/// One scheme to carry a contact over a period.
pub(crate) trait Cycle: std::fmt::Debug + Send + Sync {
    /// Evaluates the contact for the displacement coefficients `u` (m, on the set of harmonics the cycle
    /// was made for) at the fundamental `angular_frequency` (rad/s). Force and derivatives are on the
    /// same set.
    ///
    /// Where the memory does not fade (a stuck contact keeps whatever it remembers) the periodic state
    /// is the one reached by loading a contact without history to the displacement of the largest magnitude.
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError>;

    /// As [`Cycle::evaluate`]; the derivatives may be left to [`Cycle::complete`] with the same arguments.
    fn evaluate_force(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.evaluate(contact, angular_frequency, u)
    }

    /// Makes the derivatives that [`Cycle::evaluate_force`] left out.
    fn complete(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        let _ = (contact, angular_frequency, u);
        Ok(())
    }

    /// The force and its derivatives of the last evaluation.
    fn result(&self) -> &ForceMap;

    /// Coefficients of the force (N) of the last evaluation.
    fn force(&self) -> &[f64] {
        &self.result().force
    }

    /// ∂force/∂displacement coefficients (N/m) of the last evaluation.
    fn jacobian(&self) -> &DMatrix<f64> {
        &self.result().jacobian
    }

    /// ∂force coefficients/∂angular frequency (N s) of the last evaluation; zeros for rate-independent laws.
    fn by_frequency(&self) -> &[f64] {
        &self.result().by_frequency
    }

    /// Forgets the last solution, so that the next evaluation depends on its arguments alone.
    fn forget(&mut self) {}

    /// Follows the contact for [`Cycle::force_on`] alone: what else is of an evaluation has no meaning then.
    fn follow(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.evaluate_force(contact, angular_frequency, u)
    }

    /// Coefficients of the force on another set of harmonics, for the displacement last evaluated or followed.
    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]);

    /// Coefficients on `set` of the force for the displacement `u`, without derivatives.
    fn force_alone(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
        set: HarmonicSet,
        out: &mut [f64],
    ) -> Result<(), HarmonicError> {
        self.follow(contact, angular_frequency, u)?;
        self.force_on(set, out);
        Ok(())
    }

    /// What the contact did in the last evaluation.
    fn summary(&mut self) -> CycleSummary;
}
