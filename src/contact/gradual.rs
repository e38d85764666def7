//! Laws that slip gradually by themselves.

use super::ContactLaw;

/// A law of one hysteretic force that saturates at the friction limit, beside a residual spring that it may have.
///
/// Its state is `[y, u, N, origin]`: hysteretic force (N), displacement (m) and normal load (N) at the end of the last
/// step, and the displacement at which the residual spring is unstressed (m).
pub trait GradualLaw: ContactLaw {
    /// A copy.
    fn boxed(&self) -> Box<dyn GradualLaw>;

    /// The law with the limits `1 ± asymmetry` times its own, which lies between −1 and 1.
    fn with_asymmetry(&self, asymmetry: f64) -> Box<dyn GradualLaw>;

    /// By how much the limit against positive motion is larger than the mean, as a fraction of it (1).
    fn asymmetry(&self) -> f64;

    /// Slope of the initial loading curve of the hysteretic part (N/m): that of its elastic part.
    fn hysteretic_stiffness(&self) -> f64;

    /// Slope left in macro-slip (N/m).
    fn residual_stiffness(&self) -> f64;

    /// Energy (J) kept in `state`: the hysteretic part's and the residual spring's.
    fn stored_energy(&self, state: &[f64]) -> f64 {
        let stretch = state[1] - state[3];
        0.5 * (state[0] * state[0] / self.hysteretic_stiffness()
            + self.residual_stiffness() * stretch * stretch)
    }
}

/// Length of the state of a [`GradualLaw`].
pub(super) const STATE: usize = 4;

impl Clone for Box<dyn GradualLaw> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
