//! A damper moved from a mode's equation to its other side.
//!
//! A free vibration is a pole of the modes' compliance where the contact carries little. With a damper in the mode
//! that resonates the compliance has no pole; its force, of which the mode's displacement `p = c_r q_r` at the contact
//! is one more unknown, is taken away again.

use super::{Balance, DMatrix};

/// The damper.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Relief {
    mode: usize,
    /// Damping (N s/m) along p.
    damping: f64,
    /// Coefficients of its force (N).
    force: Vec<f64>,
}

impl Relief {
    pub fn new(mode: usize, count: usize) -> Self {
        Self { mode, damping: 0.0, force: vec![0.0; count] }
    }

    /// The force on p that takes the damper away, for the coefficients of p.
    fn evaluate(&mut self, angular_frequency: f64, p: &[f64]) {
        self.force[0] = 0.0;
        let pairs = self.force[1..].chunks_exact_mut(2).zip(p[1..].chunks_exact(2));
        for (order, (force, p)) in pairs.enumerate() {
            let rate = self.damping * angular_frequency * (order + 1) as f64;
            (force[0], force[1]) = (-rate * p[1], rate * p[0]);
        }
    }
}

impl Balance<'_> {
    /// Sets the damper (1/s, in the equation of the mode of unit mass).
    pub fn shift_damping(&mut self, rate: f64) {
        if let Some(relief) = &mut self.relief {
            let arm = self.beam.contact_shape[relief.mode];
            relief.damping = rate / (arm * arm);
            self.equations.add_damping(relief.mode, rate);
        }
    }

    /// First row of the relieved mode's displacement.
    pub(super) fn relief_row(&self) -> usize {
        self.string_row() + if self.signals.string { self.count } else { 0 }
    }

    /// Coefficients of p at the last evaluation.
    pub(super) fn relieved_mode(&self) -> Vec<f64> {
        let Some(relief) = &self.relief else { return Vec::new() };
        let arm = self.beam.contact_shape[relief.mode];
        self.q.chunks_exact(self.modes()).map(|q| arm * q[relief.mode]).collect()
    }

    pub(super) fn relieve_force(&mut self, x: &[f64], angular_frequency: f64) {
        let row = self.relief_row();
        if let Some(relief) = &mut self.relief {
            relief.evaluate(angular_frequency, &x[row..]);
        }
    }

    /// Takes the force from the right side of the modes' equations.
    pub(super) fn relieve_right(&mut self) {
        let modes = self.modes();
        let Some(relief) = &self.relief else { return };
        let arm = self.beam.contact_shape[relief.mode];
        for (right, force) in self.right.chunks_exact_mut(modes).zip(&relief.force) {
            right[relief.mode] -= arm * force;
        }
    }

    /// Weight of mode `mode` in p.
    pub(super) fn relief_weight(&self, mode: usize) -> Option<f64> {
        let relief = self.relief.as_ref()?;
        Some(if relief.mode == mode { self.beam.contact_shape[mode] } else { 0.0 })
    }

    pub(super) fn relief_law(&mut self, angular_frequency: f64) {
        let row = self.relief_row();
        let Some(relief) = &self.relief else { return };
        let law: &mut DMatrix<f64> = &mut self.matrices.law;
        for order in 1..=self.harmonics {
            let rate = relief.damping * angular_frequency * order as f64;
            let (c, s) = (row + 2 * order - 1, row + 2 * order);
            (law[(c, s)], law[(s, c)]) = (-rate, rate);
        }
    }

    /// ∂force/∂Ω at fixed p.
    pub(super) fn relief_rates(&mut self, angular_frequency: f64) {
        let row = self.relief_row();
        if let Some(relief) = &self.relief {
            let rates = self.rates[row..].iter_mut().zip(&relief.force);
            rates.for_each(|(rate, force)| *rate = force / angular_frequency);
        }
    }
}
