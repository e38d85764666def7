//! How the modes' dynamic stiffness D changes with the operating point.

use super::equations::ModalEquations;

impl ModalEquations {
    /// `out = ∂D/∂Ω q`.
    pub fn by_frequency(&self, q: &[f64], out: &mut [f64]) {
        let modes = self.modes;
        out.fill(0.0);
        for i in 0..modes {
            for order in 1..=self.harmonics {
                let h = order as f64;
                let inertia = -2.0 * h * h * self.at.angular_frequency;
                let rate = h * (self.damping[i] - 4.0 * self.at.self_excitation * self.at.angular_frequency);
                let (c, s) = ((2 * order - 1) * modes + i, 2 * order * modes + i);
                out[c] = inertia * q[c] + rate * q[s];
                out[s] = inertia * q[s] - rate * q[c];
            }
        }
    }

    /// `out = ∂D/∂ζ q` for the self-excitation ζ.
    pub fn by_self_excitation(&self, q: &[f64], out: &mut [f64]) {
        let modes = self.modes;
        out.fill(0.0);
        for order in 1..=self.harmonics {
            let rate = -2.0 * order as f64 * self.at.angular_frequency.powi(2);
            for i in 0..modes {
                let (c, s) = ((2 * order - 1) * modes + i, 2 * order * modes + i);
                out[c] = rate * q[s];
                out[s] = -rate * q[c];
            }
        }
    }
}
