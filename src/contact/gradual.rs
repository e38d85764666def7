//! Laws that slip gradually by themselves.

use super::{ContactLaw, Inputs, cut_to};

/// A law of one hysteretic force that saturates at the friction limit, beside a residual spring that it may have.
///
/// Its state is `[y, u, N, origin]`: hysteretic force (N), displacement (m) and normal load (N) at the end of the last
/// step, and the displacement at which the residual spring is unstressed (m).
pub trait GradualLaw: ContactLaw {
    /// A copy.
    fn boxed(&self) -> Box<dyn GradualLaw>;

    /// What it has in common with the others.
    fn gradual(&self) -> &Gradual;

    /// As [`GradualLaw::gradual`], to be changed.
    fn gradual_mut(&mut self) -> &mut Gradual;

    /// The law with the limits `1 ± asymmetry` times its own, which lies between −1 and 1.
    fn with_asymmetry(&self, asymmetry: f64) -> Box<dyn GradualLaw> {
        let mut law = self.boxed();
        law.gradual_mut().asymmetry = asymmetry;
        law
    }

    /// [`ContactLaw::advance`] by [`ContactLaw::step`].
    fn advance_by_step(&self, state: &mut [f64], inputs: Inputs) -> f64 {
        let mut next = [0.0; STATE];
        let force = self.step(state, inputs, &mut next).force;
        state.copy_from_slice(&next);
        force
    }

    /// As [`Gradual::stored_energy`].
    fn stored_energy(&self, state: &[f64]) -> f64 {
        self.gradual().stored_energy(state)
    }
}

/// What all gradual laws have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gradual {
    /// Slope of the initial loading curve of the hysteretic part (N/m): that of its elastic part.
    pub hysteretic_stiffness: f64,
    /// Slope left in macro-slip (N/m).
    pub residual_stiffness: f64,
    /// Coefficient of friction (1).
    pub friction_coefficient: f64,
    /// By how much the limit against positive motion is larger than the mean, as a fraction of it (1).
    pub asymmetry: f64,
}

impl Gradual {
    /// The limit against motion in the direction `sign`, over the mean of both.
    pub(super) fn side(&self, sign: f64) -> f64 {
        1.0 + sign * self.asymmetry
    }

    /// The mean of both limits (N) under `normal_load` (N).
    pub(super) fn limit(&self, normal_load: f64) -> f64 {
        if normal_load <= 0.0 { 0.0 } else { self.friction_coefficient * normal_load }
    }

    /// As [`ContactLaw::set_state`]; the residual spring is unstressed at `displacement` (m).
    pub(super) fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        let limit = self.side(force.signum()) * self.limit(normal_load);
        state.copy_from_slice(&[cut_to(force, limit), displacement, normal_load, displacement]);
    }

    /// Energy (J) kept in `state`: the hysteretic part's and the residual spring's.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        let stretch = state[1] - state[3];
        0.5 * (state[0] * state[0] / self.hysteretic_stiffness + self.residual_stiffness * stretch * stretch)
    }
}

/// Length of the state of a [`GradualLaw`].
pub(super) const STATE: usize = 4;

impl Clone for Box<dyn GradualLaw> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
