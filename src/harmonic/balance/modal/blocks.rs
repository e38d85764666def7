//! The modal equations without what couples the higher harmonics, solved.

use nalgebra::DMatrixViewMut;

use crate::numeric::fourier::coefficient_count;
use crate::numeric::lu::Factors;

/// The lowest harmonics, all modes of them together, and each mode of each of the others.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    modes: usize,
    low: Factors,
    /// Inverse of what each mode's own motion makes of it in each of the others, as `c − i s`.
    high: Vec<[f64; 2]>,
    /// Solutions of the low ones for all right sides.
    solved: Vec<f64>,
}

impl Blocks {
    /// Factors the equations of `modes` modes: `fill` writes the matrix of the harmonics `0..=joint`, zero before, column-major;
    /// `dynamic` is the stiffness of a mode in a higher harmonic, up to `harmonics`, and its damping force per displacement.
    /// False where one is singular.
    pub fn factor(
        &mut self,
        modes: usize,
        joint: usize,
        harmonics: usize,
        fill: impl Fn(&mut [f64]),
        dynamic: impl Fn(usize, usize) -> (f64, f64),
    ) -> bool {
        self.modes = modes;
        fill(self.low.reset(modes * coefficient_count(joint)));
        self.high.clear();
        for order in joint + 1..=harmonics {
            self.high.extend((0..modes).map(|mode| {
                let (dynamic, damping) = dynamic(mode, order);
                let scale = 1.0 / (dynamic * dynamic + damping * damping);
                [scale * dynamic, scale * damping]
            }));
        }
        self.low.factor() && self.high.as_flattened().iter().all(|x| x.is_finite())
    }

    /// Adds to `out` the solutions for `columns` right sides, one after the other in both.
    pub fn add_solutions(&mut self, right: &[f64], out: &mut [f64], columns: usize) {
        let (size, height) = (right.len() / columns, self.low.size());
        self.solved.resize(height * columns, 0.0);
        let pairs = self.solved.chunks_exact_mut(height).zip(right.chunks_exact(size));
        pairs.for_each(|(solved, right)| solved.copy_from_slice(&right[..height]));
        match columns {
            1 => self.low.solve(&mut self.solved),
            _ => self.low.solve_many(&mut DMatrixViewMut::from_slice(&mut self.solved, height, columns)),
        }
        let solutions = self.solved.chunks_exact(height).zip(right.chunks_exact(size));
        for ((low, right), out) in solutions.zip(out.chunks_exact_mut(size)) {
            let (first, others) = out.split_at_mut(height);
            first.iter_mut().zip(low).for_each(|(out, solved)| *out += solved);
            self.add_high(&right[height..], others);
        }
    }

    /// Adds the solutions of the higher harmonics.
    fn add_high(&self, right: &[f64], out: &mut [f64]) {
        let modes = self.modes;
        let orders = right.chunks_exact(2 * modes).zip(out.chunks_exact_mut(2 * modes));
        for ((right, out), inverse) in orders.zip(self.high.chunks_exact(modes)) {
            let (cosines, sines) = out.split_at_mut(modes);
            let (rc, rs) = right.split_at(modes);
            for i in 0..modes {
                let [dynamic, damping] = inverse[i];
                cosines[i] += dynamic * rc[i] - damping * rs[i];
                sines[i] += dynamic * rs[i] + damping * rc[i];
            }
        }
    }
}
