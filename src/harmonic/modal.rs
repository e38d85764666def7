//! The modal equations under a given contact force, `A q = b`: linear, coupled by the shortening.
//!
//! `A = D − G ⊗ M(T)`: D is the modes' dynamic stiffness, harmonic by harmonic, and M(T) multiplies by the
//! contact force, which acts along `c − G q`. Coefficients of the modes lie coefficient after coefficient,
//! all modes of the bias, of the cosine of the first harmonic, …, so that a vector is a matrix
//! `modes × coefficients`.
//!
//! Solved by iteration: the low harmonics, where the response is resonant and the force strong, are inverted
//! together, the rest mode by mode. What is left out converges within a few rounds; where it does not,
//! more harmonics join the low ones, in the end all of them.

use nalgebra::{DMatrix, DVector};

use super::factors::Factors;
use super::fourier::{coefficient_count, multiplication};
use super::system::Operating;
use crate::structure::ModalBeam;

/// Highest harmonic of those first inverted together.
const FIRST_JOINT: usize = 2;
/// Rounds before more harmonics are inverted together.
const ROUNDS: usize = 10;
/// Change (share of the largest coefficient) at which the solution is at rounding.
const FINISHED: f64 = 1e-12;
/// Change above which the ratio of two changes tells the contraction.
const TELLING: f64 = 1e-8;
/// Error of the derivatives that Newton's method does not notice.
const DERIVATIVE_ERROR: f64 = 1e-3;

/// Workspace of the solution.
#[derive(Debug)]
pub(crate) struct ModalEquations {
    modes: usize,
    harmonics: usize,
    /// G.
    shortening: DMatrix<f64>,
    /// ωᵢ² and 2 ζᵢ ωᵢ.
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    at: Operating,
    /// M(T), transposed.
    product: DMatrix<f64>,
    product_columns: Vec<f64>,
    joint: usize,
    inverse: DMatrix<f64>,
    factors: Factors,
    /// Share of the error that a round leaves.
    contraction: f64,
    /// Error accepted of [`Self::solve_many`], as share.
    pub derivative_error: f64,
    coupled: DMatrix<f64>,
    residual: DVector<f64>,
    many: DMatrix<f64>,
    many_coupled: DMatrix<f64>,
    low: DMatrix<f64>,
}

impl ModalEquations {
    pub fn new(beam: &ModalBeam, harmonics: usize) -> Self {
        let modes = beam.angular_frequency.len();
        let count = coefficient_count(harmonics);
        Self {
            modes,
            harmonics,
            shortening: DMatrix::from_row_slice(modes, modes, &beam.shortening),
            stiffness: beam.angular_frequency.iter().map(|natural| natural * natural).collect(),
            damping: beam
                .angular_frequency
                .iter()
                .zip(&beam.damping_ratio)
                .map(|(natural, ratio)| 2.0 * ratio * natural)
                .collect(),
            at: Operating::forced(0.0, 0.0),
            product: DMatrix::zeros(count, count),
            product_columns: vec![0.0; count * count],
            joint: FIRST_JOINT.min(harmonics),
            inverse: DMatrix::zeros(0, 0),
            factors: Factors::default(),
            contraction: 0.0,
            derivative_error: DERIVATIVE_ERROR,
            coupled: DMatrix::zeros(modes, count),
            residual: DVector::zeros(modes * count),
            many: DMatrix::zeros(0, 0),
            many_coupled: DMatrix::zeros(0, 0),
            low: DMatrix::zeros(0, 0),
        }
    }

    /// Makes the number of rounds depend on the next arguments alone.
    pub fn forget(&mut self) {
        self.joint = FIRST_JOINT.min(self.harmonics);
    }

    /// Sets the operating point and the contact force (coefficients of twice the harmonics, or more).
    /// False where the equations are singular.
    pub fn set(&mut self, at: &Operating, force: &[f64]) -> bool {
        self.at = *at;
        let count = coefficient_count(self.harmonics);
        multiplication(force, self.harmonics, count, &mut self.product_columns);
        for (k, column) in self.product_columns.chunks_exact(count).enumerate() {
            column.iter().enumerate().for_each(|(row, value)| self.product[(k, row)] = *value);
        }
        self.invert_joint()
    }

    /// Dynamic stiffness and damping force per displacement of mode `mode` in harmonic `order`.
    fn dynamic(&self, mode: usize, order: usize) -> (f64, f64) {
        let speed = order as f64 * self.at.angular_frequency;
        let sustained = 2.0 * self.at.self_excitation * self.at.angular_frequency;
        (self.stiffness[mode] - speed * speed, (self.damping[mode] - sustained) * speed)
    }

    fn invert_joint(&mut self) -> bool {
        let modes = self.modes;
        let size = modes * coefficient_count(self.joint);
        let mut matrix = std::mem::take(&mut self.inverse);
        if matrix.nrows() != size {
            matrix = DMatrix::zeros(size, size);
        }
        for l in 0..coefficient_count(self.joint) {
            for k in 0..coefficient_count(self.joint) {
                let weight = -self.product[(l, k)];
                for j in 0..modes {
                    for i in 0..modes {
                        matrix[(k * modes + i, l * modes + j)] = weight * self.shortening[(i, j)];
                    }
                }
            }
        }
        for i in 0..modes {
            matrix[(i, i)] += self.stiffness[i];
            for order in 1..=self.joint {
                let (dynamic, damping) = self.dynamic(i, order);
                let (c, s) = ((2 * order - 1) * modes + i, 2 * order * modes + i);
                matrix[(c, c)] += dynamic;
                matrix[(s, s)] += dynamic;
                matrix[(c, s)] += damping;
                matrix[(s, c)] -= damping;
            }
        }
        self.factors.reset(size).copy_from_slice(matrix.as_slice());
        let regular = self.factors.factor();
        if regular {
            matrix.fill_with_identity();
            matrix.as_mut_slice().chunks_exact_mut(size).for_each(|column| self.factors.solve(column));
        }
        self.inverse = matrix;
        regular
    }

    /// `out += P⁻¹ right`, P being A without the coupling of the higher harmonics.
    fn add_preconditioned(&mut self, right: &[f64], out: &mut [f64], columns: usize) {
        let (modes, size) = (self.modes, self.modes * coefficient_count(self.harmonics));
        let low = self.inverse.nrows();
        if self.low.shape() != (low, columns) {
            self.low = DMatrix::zeros(low, columns);
        }
        let source = nalgebra::DMatrixView::from_slice_with_strides_generic(
            right,
            nalgebra::Dyn(low),
            nalgebra::Dyn(columns),
            nalgebra::Dyn(1),
            nalgebra::Dyn(size),
        );
        self.low.gemm(1.0, &self.inverse, &source, 0.0);
        for m in 0..columns {
            let target = &mut out[m * size..(m + 1) * size];
            let solved = &self.low.as_slice()[m * low..(m + 1) * low];
            target.iter_mut().zip(solved).for_each(|(t, s)| *t += s);
        }
        for order in self.joint + 1..=self.harmonics {
            for i in 0..modes {
                let (dynamic, damping) = self.dynamic(i, order);
                let scale = 1.0 / (dynamic * dynamic + damping * damping);
                let (dynamic, damping) = (scale * dynamic, scale * damping);
                let (c, s) = ((2 * order - 1) * modes + i, 2 * order * modes + i);
                for m in 0..columns {
                    let (rc, rs) = (right[m * size + c], right[m * size + s]);
                    out[m * size + c] += dynamic * rc - damping * rs;
                    out[m * size + s] += dynamic * rs + damping * rc;
                }
            }
        }
    }

    /// `out = D q`.
    fn multiply_dynamic(&self, q: &[f64], out: &mut [f64]) {
        let modes = self.modes;
        for i in 0..modes {
            out[i] = self.stiffness[i] * q[i];
            for order in 1..=self.harmonics {
                let (dynamic, damping) = self.dynamic(i, order);
                let (c, s) = ((2 * order - 1) * modes + i, 2 * order * modes + i);
                out[c] = dynamic * q[c] + damping * q[s];
                out[s] = dynamic * q[s] - damping * q[c];
            }
        }
    }

    /// Solves `A q = right` to rounding; false where that fails.
    pub fn solve(&mut self, right: &[f64], q: &mut [f64]) -> bool {
        loop {
            if self.iterate(right, q) {
                return true;
            }
            if self.joint == self.harmonics {
                return false;
            }
            self.joint = (2 * self.joint).min(self.harmonics);
            if !self.invert_joint() {
                return false;
            }
        }
    }

    fn iterate(&mut self, right: &[f64], q: &mut [f64]) -> bool {
        let (modes, count) = (self.modes, coefficient_count(self.harmonics));
        q.fill(0.0);
        self.contraction = 0.0;
        let mut residual = std::mem::replace(&mut self.residual, DVector::zeros(0));
        residual.copy_from_slice(right);
        let mut step = vec![0.0; right.len()];
        let mut before = f64::INFINITY;
        let mut finished = false;
        for _ in 0..ROUNDS {
            step.fill(0.0);
            self.add_preconditioned(residual.as_slice(), &mut step, 1);
            q.iter_mut().zip(&step).for_each(|(q, s)| *q += s);
            let change = largest(&step);
            if before.is_finite() && before > TELLING * largest(q) {
                self.contraction = self.contraction.max(change / before);
            }
            finished = change <= FINISHED * largest(q);
            // Exact to rounding once everything is inverted together.
            if finished || change.is_nan() || self.joint == self.harmonics {
                finished |= self.joint == self.harmonics && change.is_finite();
                break;
            }
            before = change;
            self.multiply_dynamic(q, residual.as_mut_slice());
            let view = nalgebra::DMatrixView::from_slice(q, modes, count);
            self.coupled.gemm(1.0, &self.shortening, &view, 0.0);
            let mut matrix = nalgebra::DMatrixViewMut::from_slice(residual.as_mut_slice(), modes, count);
            matrix.gemm(-1.0, &self.coupled, &self.product, 1.0);
            residual.iter_mut().zip(right).for_each(|(r, b)| *r = b - *r);
        }
        self.residual = residual;
        finished
    }

    /// Replaces the columns of `right` by `A⁻¹ right`, as precisely as derivatives need it. After
    /// [`Self::solve`], which tells how fast the iteration converges.
    pub fn solve_many(&mut self, right: &DMatrix<f64>, out: &mut DMatrix<f64>) {
        let (modes, count, columns) = (self.modes, coefficient_count(self.harmonics), right.ncols());
        out.fill(0.0);
        self.add_preconditioned(right.as_slice(), out.as_mut_slice(), columns);
        let mut error = self.contraction;
        let mut rounds = 0;
        while error > self.derivative_error && rounds < ROUNDS {
            if self.many.shape() != right.shape() {
                self.many = right.clone();
                self.many_coupled = right.clone();
            }
            let mut many = std::mem::replace(&mut self.many, DMatrix::zeros(0, 0));
            let view = nalgebra::DMatrixView::from_slice(out.as_slice(), modes, count * columns);
            let coupled = self.many_coupled.as_mut_slice();
            nalgebra::DMatrixViewMut::from_slice(coupled, modes, count * columns).gemm(
                1.0,
                &self.shortening,
                &view,
                0.0,
            );
            let size = modes * count;
            for m in 0..columns {
                let span = m * size..(m + 1) * size;
                self.multiply_dynamic(&out.as_slice()[span.clone()], &mut many.as_mut_slice()[span.clone()]);
                let coupled = nalgebra::DMatrixView::from_slice(
                    &self.many_coupled.as_slice()[span.clone()],
                    modes,
                    count,
                );
                let mut into =
                    nalgebra::DMatrixViewMut::from_slice(&mut many.as_mut_slice()[span], modes, count);
                into.gemm(-1.0, &coupled, &self.product, 1.0);
            }
            many.iter_mut().zip(right.iter()).for_each(|(r, b)| *r = b - *r);
            self.add_preconditioned(many.as_slice(), out.as_mut_slice(), columns);
            self.many = many;
            error *= self.contraction;
            rounds += 1;
        }
    }

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

fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| if x.abs() > m || x.is_nan() { x.abs() } else { m })
}
