//! Drag `d |ẏ| ẏ` on a periodic motion, by its coefficients.

use nalgebra::DMatrix;

use crate::numeric::fourier::{Basis, coefficient_count};

/// Samples per harmonic: the force has a kink in its slope where the motion turns, and the coefficients
/// beyond the samples fall with the cube of their order.
const SAMPLES: usize = 8;

/// Coefficients of the force and their derivatives.
#[derive(Debug)]
pub(super) struct Drag {
    basis: Basis,
    /// ∂/∂phase of the basis at the samples.
    rates: DMatrix<f64>,
    weighed: DMatrix<f64>,
    velocity: Vec<f64>,
    samples: Vec<f64>,
    pub force: Vec<f64>,
    pub jacobian: DMatrix<f64>,
}

impl Drag {
    pub fn new(harmonics: usize) -> Self {
        let count = coefficient_count(harmonics);
        let samples = (SAMPLES * harmonics).max(64);
        let basis = Basis::new(harmonics, samples);
        let mut rates = DMatrix::zeros(count, samples);
        for k in 0..samples {
            for h in 1..=harmonics {
                rates[(2 * h - 1, k)] = -(h as f64) * basis.at_samples[(2 * h, k)];
                rates[(2 * h, k)] = h as f64 * basis.at_samples[(2 * h - 1, k)];
            }
        }
        Self {
            basis,
            weighed: rates.clone(),
            rates,
            velocity: vec![0.0; samples],
            samples: vec![0.0; samples],
            force: vec![0.0; count],
            jacobian: DMatrix::zeros(count, count),
        }
    }

    /// The force of `drag` (N s²/m²) on the displacement with the coefficients `y` (m).
    pub fn evaluate(&mut self, drag: f64, angular_frequency: f64, y: &[f64]) {
        let count = y.len();
        let rates = self.rates.as_slice().chunks_exact(count);
        for ((velocity, force), rate) in self.velocity.iter_mut().zip(&mut self.samples).zip(rates) {
            *velocity = angular_frequency * rate.iter().zip(y).map(|(r, y)| r * y).sum::<f64>();
            *force = drag * velocity.abs() * *velocity;
        }
        self.basis.project(&self.samples, &mut self.force);
    }

    /// ∂force/∂y at the last evaluation, to [`Drag::jacobian`].
    pub fn differentiate(&mut self, drag: f64, angular_frequency: f64) {
        let count = self.force.len();
        let rates = self.rates.as_slice().chunks_exact(count);
        let columns = self.weighed.as_mut_slice().chunks_exact_mut(count).zip(rates);
        for ((column, rate), velocity) in columns.zip(&self.velocity) {
            let weight = 2.0 * drag * angular_frequency * velocity.abs();
            column.iter_mut().zip(rate).for_each(|(c, r)| *c = weight * r);
        }
        let projection = self.basis.projection.transpose();
        self.jacobian.gemm(1.0, &projection, &self.weighed.transpose(), 0.0);
    }
}
