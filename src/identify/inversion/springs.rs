//! Springs that modes do not have, put in harmonic by harmonic.

use nalgebra::{Complex, DMatrix, DVector};

use super::structure::Structure;

/// What the springs do to modes that move without them: by the formula of Sherman, Morrison and Woodbury.
pub(super) struct Springs {
    rows: DMatrix<f64>,
    /// Per harmonic, the mean first: `D⁻¹ Bᵀ (1 + S B D⁻¹ Bᵀ)⁻¹ S`, D the stiffness of the modes, B the rows and S the springs.
    corrections: Vec<DMatrix<Complex<f64>>>,
}

impl Springs {
    pub fn new(structure: &Structure, angular_frequency: f64, harmonics: usize) -> Self {
        let (count, modes) = (structure.springs.len(), structure.angular_frequency.len());
        let rows = DMatrix::from_fn(count, modes, |p, i| structure.springs[p].1[i]);
        let correction = |h: usize| {
            let omega = h as f64 * angular_frequency;
            let moved = DMatrix::from_fn(modes, count, |i, p| rows[(p, i)] / structure.stiffness(i, omega));
            let springs = DVector::from_fn(count, |p, _| Complex::from(structure.springs[p].0));
            let springs = DMatrix::from_diagonal(&springs);
            let held = DMatrix::identity(count, count) + &springs * rows.map(Complex::from) * &moved;
            // The springs of a rig without its contact leave it supported: there is an inverse.
            let inverse = held.try_inverse().unwrap_or_else(|| DMatrix::zeros(count, count));
            moved * inverse * springs
        };
        let corrections = if count == 0 { Vec::new() } else { (0..=harmonics).map(correction).collect() };
        Self { rows, corrections }
    }

    /// Holds `modes` that moved without the springs.
    pub fn hold(&self, modes: &mut [Vec<f64>]) {
        for (h, correction) in self.corrections.iter().enumerate() {
            let at = |mode: &Vec<f64>| match h {
                0 => Complex::from(mode[0]),
                h => Complex::new(mode[2 * h - 1], -mode[2 * h]),
            };
            let free = DVector::from_iterator(modes.len(), modes.iter().map(at));
            let change = correction * (self.rows.map(Complex::from) * free);
            for (mode, change) in modes.iter_mut().zip(change.iter()) {
                if h == 0 {
                    mode[0] -= change.re;
                } else {
                    mode[2 * h - 1] -= change.re;
                    mode[2 * h] += change.im;
                }
            }
        }
    }
}
