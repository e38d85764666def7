//! The modal equations under a given contact force, `A q = b`: linear, coupled by the shortening.
//!
//! `A = D − G ⊗ M(T)`: D is the modes' dynamic stiffness, harmonic by harmonic, and M(T) multiplies by the
//! contact force, which acts along `c − G q`. Coefficients of the modes lie coefficient after coefficient,
//! all modes of the bias, of the cosine of the first harmonic, …, so that a vector is a matrix
//! `modes × coefficients`.
//!
//! Solved by iteration: the low harmonics, where the response is resonant and the force strong, are inverted
//! together, the rest mode by mode. The remainder converges within a few rounds; where it does not, under a force
//! that nearly buckles the beam or more, minimal residuals find the way, and where they do not, more harmonics join
//! the low ones, in the end all of them.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, DVector, Dyn};

use crate::harmonic::modal_system::ModalSystem;
use crate::harmonic::newton::problem::largest;
use crate::harmonic::newton::system::Operating;
use crate::numeric::fourier::{coefficient_count, multiplication};
use crate::numeric::gmres::Krylov;
use crate::numeric::lu::Factors;

/// Highest harmonic of those first inverted together.
const FIRST_JOINT: usize = 2;
/// Rounds before more harmonics are inverted together.
const ROUNDS: usize = 10;
/// Change (fraction of the largest coefficient) at which the solution is at rounding.
const FINISHED: f64 = 1e-12;
/// Change above which the ratio of two changes tells the contraction.
const TELLING: f64 = 1e-8;
/// Fraction left by a round above which the rounds are too many.
const SLOW: f64 = 0.5;
/// Error of the derivatives that Newton's method does not notice.
const DERIVATIVE_ERROR: f64 = 1e-3;

/// Workspace of the solution.
#[derive(Debug)]
pub(crate) struct ModalEquations {
    pub(super) modes: usize,
    pub(super) harmonics: usize,
    /// G.
    shortening: DMatrix<f64>,
    /// ωᵢ² and 2 ζᵢ ωᵢ.
    stiffness: Vec<f64>,
    pub(super) damping: Vec<f64>,
    pub(super) at: Operating,
    /// M(T), transposed.
    product: DMatrix<f64>,
    product_columns: Vec<f64>,
    joint: usize,
    inverse: DMatrix<f64>,
    /// Whether it is that of the present factors.
    inverted: bool,
    factors: Factors,
    /// Fraction of the error that a round leaves.
    contraction: f64,
    /// Error accepted of [`Self::solve_many`], as a fraction.
    pub derivative_error: f64,
    coupled: DMatrix<f64>,
    residual: DVector<f64>,
    many: DMatrix<f64>,
    many_coupled: DMatrix<f64>,
    low: DMatrix<f64>,
    krylov: Krylov,
    /// What [`Krylov`] works on: a product with A, and the right side.
    multiplied: Vec<f64>,
    prepared: Vec<f64>,
}

impl ModalEquations {
    pub fn new(system: &ModalSystem, harmonics: usize) -> Self {
        let modes = system.modes();
        let count = coefficient_count(harmonics);
        let mut equations = Self {
            modes,
            harmonics,
            shortening: DMatrix::zeros(0, 0),
            stiffness: Vec::new(),
            damping: Vec::new(),
            at: Operating::forced(0.0, 0.0),
            product: DMatrix::zeros(count, count),
            product_columns: vec![0.0; count * count],
            joint: FIRST_JOINT.min(harmonics),
            inverse: DMatrix::zeros(0, 0),
            inverted: false,
            factors: Factors::default(),
            contraction: 0.0,
            derivative_error: DERIVATIVE_ERROR,
            coupled: DMatrix::zeros(modes, count),
            residual: DVector::zeros(modes * count),
            many: DMatrix::zeros(0, 0),
            many_coupled: DMatrix::zeros(0, 0),
            low: DMatrix::zeros(0, 0),
            krylov: Krylov::default(),
            multiplied: vec![0.0; modes * count],
            prepared: vec![0.0; modes * count],
        };
        equations.describe(system);
        equations
    }

    fn describe(&mut self, system: &ModalSystem) {
        self.shortening = DMatrix::from_row_slice(self.modes, self.modes, &system.shortening);
        self.stiffness = system.angular_frequency.iter().map(|natural| natural * natural).collect();
        let natural = system.angular_frequency.iter().zip(&system.damping_ratio);
        self.damping = natural.map(|(natural, ratio)| 2.0 * ratio * natural).collect();
    }

    /// Those of another system with as many modes and harmonics, in the same room.
    pub fn renewed(mut self, system: &ModalSystem) -> Self {
        self.describe(system);
        self.forget();
        self.inverted = false;
        self.contraction = 0.0;
        self.derivative_error = DERIVATIVE_ERROR;
        self
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Adds a damper (1/s) to a mode.
    pub fn add_damping(&mut self, mode: usize, rate: f64) {
        self.damping[mode] += rate;
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
        self.factor_joint()
    }

    /// Dynamic stiffness and damping force per displacement of mode `mode` in harmonic `order`.
    fn dynamic(&self, mode: usize, order: usize) -> (f64, f64) {
        dynamic(self.stiffness[mode], self.damping[mode], &self.at, order)
    }

    /// Factors the low harmonics' equations; false where they are singular.
    fn factor_joint(&mut self) -> bool {
        let modes = self.modes;
        let size = modes * coefficient_count(self.joint);
        let matrix = self.factors.reset(size);
        for l in 0..coefficient_count(self.joint) {
            for k in 0..coefficient_count(self.joint) {
                let weight = -self.product[(l, k)];
                for j in 0..modes {
                    for i in 0..modes {
                        matrix[(l * modes + j) * size + k * modes + i] = weight * self.shortening[(i, j)];
                    }
                }
            }
        }
        for i in 0..modes {
            let mut add = |row: usize, column: usize, value: f64| matrix[column * size + row] += value;
            add(i, i, self.stiffness[i]);
            for order in 1..=self.joint {
                let (dynamic, damping) = dynamic(self.stiffness[i], self.damping[i], &self.at, order);
                let (c, s) = ((2 * order - 1) * modes + i, 2 * order * modes + i);
                add(c, c, dynamic);
                add(s, s, dynamic);
                add(c, s, damping);
                add(s, c, -damping);
            }
        }
        self.inverted = false;
        self.factors.factor()
    }

    /// Makes the inverse of the low harmonics' equations, with which many columns are solved faster.
    fn invert_joint(&mut self) {
        if self.inverted {
            return;
        }
        let size = self.modes * coefficient_count(self.joint);
        if self.inverse.nrows() != size {
            self.inverse = DMatrix::zeros(size, size);
        }
        self.inverse.fill_with_identity();
        let columns = self.inverse.as_mut_slice().chunks_exact_mut(size);
        columns.for_each(|column| self.factors.solve(column));
        self.inverted = true;
    }

    /// `out += P⁻¹ right`, P being A without the coupling of the higher harmonics.
    fn add_preconditioned(&mut self, right: &[f64], out: &mut [f64], columns: usize) {
        let (modes, size) = (self.modes, self.modes * coefficient_count(self.harmonics));
        let low = modes * coefficient_count(self.joint);
        if self.low.shape() != (low, columns) {
            self.low = DMatrix::zeros(low, columns);
        }
        let source =
            DMatrixView::from_slice_with_strides_generic(right, Dyn(low), Dyn(columns), Dyn(1), Dyn(size));
        if columns < low {
            self.low.copy_from(&source);
            self.low.as_mut_slice().chunks_exact_mut(low).for_each(|column| self.factors.solve(column));
        } else {
            self.invert_joint();
            self.low.gemm(1.0, &self.inverse, &source, 0.0);
        }
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
            self.contraction = f64::INFINITY;
            if self.joint < self.harmonics && self.minimise(right, q, FINISHED) {
                return true;
            }
            if self.joint == self.harmonics {
                return false;
            }
            self.joint = (2 * self.joint).min(self.harmonics);
            if !self.factor_joint() {
                return false;
            }
        }
    }

    /// `out = A q`.
    fn multiply(&mut self, q: &[f64], out: &mut [f64]) {
        let (modes, count) = (self.modes, coefficient_count(self.harmonics));
        self.multiply_dynamic(q, out);
        let view = DMatrixView::from_slice(q, modes, count);
        self.coupled.gemm(1.0, &self.shortening, &view, 0.0);
        let mut matrix = DMatrixViewMut::from_slice(out, modes, count);
        matrix.gemm(-1.0, &self.coupled, &self.product, 1.0);
    }

    /// Solves `P⁻¹ A q = P⁻¹ right` by minimal residuals.
    fn minimise(&mut self, right: &[f64], q: &mut [f64], tolerance: f64) -> bool {
        let mut krylov = std::mem::take(&mut self.krylov);
        let mut multiplied = std::mem::take(&mut self.multiplied);
        let mut prepared = std::mem::take(&mut self.prepared);
        prepared.fill(0.0);
        self.add_preconditioned(right, &mut prepared, 1);
        let apply = |v: &[f64], out: &mut [f64]| {
            self.multiply(v, &mut multiplied);
            out.fill(0.0);
            self.add_preconditioned(&multiplied, out, 1);
        };
        let solved = krylov.solve(apply, &prepared, q, tolerance);
        (self.krylov, self.multiplied, self.prepared) = (krylov, multiplied, prepared);
        solved
    }

    fn iterate(&mut self, right: &[f64], q: &mut [f64]) -> bool {
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
            if change > before {
                break;
            }
            before = change;
            self.multiply(q, residual.as_mut_slice());
            residual.iter_mut().zip(right).for_each(|(r, b)| *r = b - *r);
        }
        self.residual = residual;
        finished
    }

    /// Replaces the columns of `right` by `A⁻¹ right`, as precisely as derivatives need it. After
    /// [`Self::solve`], which tells how fast the iteration converges.
    pub fn solve_many(&mut self, right: &DMatrix<f64>, out: &mut DMatrix<f64>) {
        let (modes, count, columns) = (self.modes, coefficient_count(self.harmonics), right.ncols());
        if self.contraction > SLOW {
            let (size, tolerance) = (modes * count, self.derivative_error);
            let pairs = right.as_slice().chunks_exact(size).zip(out.as_mut_slice().chunks_exact_mut(size));
            for (right, out) in pairs {
                self.minimise(right, out, tolerance);
            }
            return;
        }
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
            let view = DMatrixView::from_slice(out.as_slice(), modes, count * columns);
            let coupled = self.many_coupled.as_mut_slice();
            DMatrixViewMut::from_slice(coupled, modes, count * columns).gemm(
                1.0,
                &self.shortening,
                &view,
                0.0,
            );
            let size = modes * count;
            for m in 0..columns {
                let span = m * size..(m + 1) * size;
                self.multiply_dynamic(&out.as_slice()[span.clone()], &mut many.as_mut_slice()[span]);
            }
            // Mode by mode for all columns: few large products.
            let (rows, cols, along, across) = (Dyn(columns), Dyn(count), Dyn(size), Dyn(modes));
            for i in 0..modes {
                let coupled = &self.many_coupled.as_slice()[i..];
                let coupled =
                    DMatrixView::from_slice_with_strides_generic(coupled, rows, cols, along, across);
                let into = &mut many.as_mut_slice()[i..];
                let mut into =
                    DMatrixViewMut::from_slice_with_strides_generic(into, rows, cols, along, across);
                into.gemm(-1.0, &coupled, &self.product, 1.0);
            }
            many.iter_mut().zip(right.iter()).for_each(|(r, b)| *r = b - *r);
            self.add_preconditioned(many.as_slice(), out.as_mut_slice(), columns);
            self.many = many;
            error *= self.contraction;
            rounds += 1;
        }
    }
}

/// Dynamic stiffness and damping force per displacement of a mode with the stiffness ω² and the damping 2 ζ ω.
fn dynamic(stiffness: f64, damping: f64, at: &Operating, order: usize) -> (f64, f64) {
    let speed = order as f64 * at.angular_frequency;
    let sustained = 2.0 * at.self_excitation * at.angular_frequency;
    (stiffness - speed * speed, (damping - sustained) * speed)
}
