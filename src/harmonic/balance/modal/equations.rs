//! The modal equations under a given contact force, `A q = b`: linear, coupled by the shortening.
//!
//! `A = D − G ⊗ M(T)`: D is the modes' dynamic stiffness, harmonic by harmonic, and M(T) multiplies by the
//! contact force, which acts along `c − G q`. Coefficients of the modes lie coefficient after coefficient,
//! all modes of the bias, of the cosine of the first harmonic, …, so that a vector is a matrix
//! `modes × coefficients`.
//!
//! Solved by iteration: the low harmonics, where the response is resonant and the force strong, are solved
//! together, the rest mode by mode, each with what the mean of the force makes of it alone. The remainder converges within a
//! few rounds; where it does not, a few more harmonics join the low ones. Under a force that nearly buckles the beam or
//! more, minimal residuals find the way, and where they do not, more harmonics join, in the end all of them; many
//! solutions are made of all harmonics together there, where that is less work.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, DVector, Dyn};

use super::blocks::Blocks;
use crate::harmonic::modal_system::ModalSystem;
use crate::harmonic::newton::problem::largest;
use crate::harmonic::newton::system::Operating;
use crate::numeric::SMALL_PRODUCT;
use crate::numeric::fourier::coefficient_count;
use crate::numeric::gmres::Krylov;
use crate::numeric::multiplication::Multiplication;
use crate::numeric::random::Random;

/// Highest harmonic of those first solved together.
const FIRST_JOINT: usize = 2;
/// Highest harmonic of those that are solved together before minimal residuals are tried.
const MOST_JOINT: usize = 8;
/// Rounds before more harmonics are solved together.
const ROUNDS: usize = 10;
/// Change (fraction of the largest coefficient) at which the solution is at rounding.
const FINISHED: f64 = 1e-12;
/// Change above which the ratio of two changes tells the contraction.
const TELLING: f64 = 1e-8;
/// Fraction left by a round of many solutions above which rounds are too many.
const SLOW: f64 = 0.5;
/// Minimal residuals take about so many steps to a derivative.
const STEPS: usize = 8;
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
    by_force: Multiplication,
    joint: usize,
    blocks: Blocks,
    /// All harmonics together, where many solutions are wanted that rounds do not lead to.
    whole: Blocks,
    /// Fraction of the error that a round left at most in the last solution; infinite where rounds did not lead there.
    contraction: f64,
    /// Error accepted of [`Self::solve_many`], as a fraction.
    pub derivative_error: f64,
    coupled: DMatrix<f64>,
    residual: DVector<f64>,
    many: DMatrix<f64>,
    many_coupled: DMatrix<f64>,
    krylov: Krylov,
    /// The last change of each of many solutions, and how far it is.
    progress: Vec<(f64, Progress)>,
    /// A mixture of them.
    mixed: Vec<f64>,
    /// What [`Krylov`], or a mixture, works on: a product with A, and the right side.
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
            by_force: Multiplication::default(),
            joint: FIRST_JOINT.min(harmonics),
            blocks: Blocks::default(),
            whole: Blocks::default(),
            contraction: 0.0,
            derivative_error: DERIVATIVE_ERROR,
            coupled: DMatrix::zeros(modes, count),
            residual: DVector::zeros(modes * count),
            many: DMatrix::zeros(0, 0),
            many_coupled: DMatrix::zeros(0, 0),
            krylov: Krylov::default(),
            progress: Vec::new(),
            mixed: vec![0.0; modes * count],
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

    /// Sets the operating point and the contact force (coefficients of as many harmonics as the contact has).
    /// False where the equations are singular.
    pub fn set(&mut self, at: &Operating, force: &[f64]) -> bool {
        self.at = *at;
        self.by_force.set_signal(force, self.harmonics, self.harmonics);
        self.by_force.write(self.product.as_mut_slice().chunks_exact_mut(coefficient_count(self.harmonics)));
        // Transposed: M is symmetric but for the mean, which a wave's product has half of what a mean's has of the wave.
        self.product.row_mut(0).iter_mut().skip(1).for_each(|x| *x *= 2.0);
        self.product.column_mut(0).iter_mut().skip(1).for_each(|x| *x *= 0.5);
        self.factor()
    }

    /// Dynamic stiffness and damping force per displacement of mode `mode` in harmonic `order`.
    fn dynamic(&self, mode: usize, order: usize) -> (f64, f64) {
        dynamic(self.stiffness[mode], self.damping[mode], &self.at, order)
    }

    /// Factors what is solved together; false where that is singular.
    fn factor(&mut self) -> bool {
        let mut blocks = std::mem::take(&mut self.blocks);
        let factored = self.factor_in(&mut blocks, self.joint);
        self.blocks = blocks;
        factored
    }

    /// The same with all harmonics up to `joint` together.
    fn factor_in(&self, blocks: &mut Blocks, joint: usize) -> bool {
        // The mean of the force acts on each mode by itself as a spring does.
        let mean = self.product[(0, 0)];
        let dynamic = |mode: usize, order: usize| {
            let (dynamic, damping) = self.dynamic(mode, order);
            (dynamic - mean * self.shortening[(mode, mode)], damping)
        };
        let fill = |matrix: &mut [f64]| self.fill(matrix, joint);
        blocks.factor(self.modes, joint, self.harmonics, fill, dynamic)
    }

    /// Writes A for the harmonics up to `joint`, column-major.
    fn fill(&self, matrix: &mut [f64], joint: usize) {
        let (modes, count) = (self.modes, coefficient_count(joint));
        let size = modes * count;
        for (l, columns) in matrix.chunks_exact_mut(modes * size).enumerate() {
            for (column, turned) in columns.chunks_exact_mut(size).zip(self.shortening.column_iter()) {
                for (k, part) in column.chunks_exact_mut(modes).enumerate() {
                    let weight = -self.product[(l, k)];
                    part.iter_mut().zip(&turned).for_each(|(x, g)| *x = weight * g);
                }
            }
        }
        let mut add = |row: usize, column: usize, value: f64| matrix[column * size + row] += value;
        for i in 0..modes {
            add(i, i, self.stiffness[i]);
            for order in 1..=joint {
                let (dynamic, damping) = self.dynamic(i, order);
                let (c, s) = ((2 * order - 1) * modes + i, 2 * order * modes + i);
                add(c, c, dynamic);
                add(s, s, dynamic);
                add(c, s, damping);
                add(s, c, -damping);
            }
        }
    }

    /// `out = D q`.
    fn multiply_dynamic(&self, q: &[f64], out: &mut [f64]) {
        let modes = self.modes;
        let (mean, others) = out.split_at_mut(modes);
        mean.iter_mut().zip(&self.stiffness).zip(q).for_each(|((out, stiffness), q)| *out = stiffness * q);
        let pairs = others.chunks_exact_mut(2 * modes).zip(q[modes..].chunks_exact(2 * modes));
        for (order, (out, q)) in (1..).zip(pairs) {
            let ((out_c, out_s), (q_c, q_s)) = (out.split_at_mut(modes), q.split_at(modes));
            for i in 0..modes {
                let (dynamic, damping) = self.dynamic(i, order);
                out_c[i] = dynamic * q_c[i] + damping * q_s[i];
                out_s[i] = dynamic * q_s[i] - damping * q_c[i];
            }
        }
    }

    /// Solves `A q = right` to rounding; false where that fails.
    pub fn solve(&mut self, right: &[f64], q: &mut [f64]) -> bool {
        loop {
            if self.iterate(right, q) {
                return true;
            }
            let wide = 2 * self.joint > MOST_JOINT && self.joint < self.harmonics;
            self.contraction = f64::INFINITY;
            if wide && self.minimise(right, q, FINISHED) {
                return true;
            }
            if self.joint == self.harmonics {
                return false;
            }
            self.joint = (2 * self.joint).min(self.harmonics);
            if !self.factor() {
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
        self.blocks.add_solutions(right, &mut prepared, 1);
        let apply = |v: &[f64], out: &mut [f64]| {
            self.multiply(v, &mut multiplied);
            out.fill(0.0);
            self.blocks.add_solutions(&multiplied, out, 1);
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
            self.blocks.add_solutions(residual.as_slice(), &mut step, 1);
            q.iter_mut().zip(&step).for_each(|(q, s)| *q += s);
            let change = largest(&step);
            if before.is_finite() && before > TELLING * largest(q) {
                self.contraction = self.contraction.max(change / before);
            }
            finished = change <= FINISHED * largest(q);
            // Exact to rounding once everything is solved together.
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

    /// Writes `A⁻¹ right`, column by column, to `out`, as precisely as derivatives need it. After [`Self::solve`], which tells
    /// where rounds are slow: all harmonics together are faster there, or minimal residuals.
    pub fn solve_many(&mut self, right: &DMatrix<f64>, out: &mut DMatrix<f64>) {
        let (size, columns) = right.shape();
        if self.contraction > SLOW && self.is_less_together(columns) && self.solve_together(right, out) {
            return;
        }
        let mut progress = std::mem::take(&mut self.progress);
        progress.clear();
        if self.contraction > SLOW {
            progress.resize(columns, (0.0, Progress::Slow));
        } else {
            out.fill(0.0);
            self.blocks.add_solutions(right.as_slice(), out.as_mut_slice(), columns);
            progress.extend(out.as_slice().chunks_exact(size).map(|x| (largest(x), Progress::Converging)));
            if self.error_of_mixture(right, out, &progress) > self.derivative_error {
                if columns.min(coefficient_count(self.harmonics)) > SMALL_PRODUCT {
                    self.iterate_many(right, out, &mut progress);
                } else {
                    progress.iter_mut().for_each(|(_, progress)| *progress = Progress::Slow);
                }
            } else {
                progress.iter_mut().for_each(|(_, progress)| *progress = Progress::Finished);
            }
        }
        let columns = right.as_slice().chunks_exact(size).zip(out.as_mut_slice().chunks_exact_mut(size));
        for ((right, out), (_, progress)) in columns.zip(&progress) {
            if *progress != Progress::Finished {
                self.minimise(right, out, self.derivative_error);
            }
        }
        self.progress = progress;
    }

    /// Whether all harmonics are factored and solved together for so many right sides in fewer products than minimal residuals
    /// take.
    fn is_less_together(&self, columns: usize) -> bool {
        let (count, joint) = (coefficient_count(self.harmonics), coefficient_count(self.joint));
        let size = self.modes * count;
        let step = (self.modes * joint).pow(2) + self.modes * count * (self.modes + count);
        size.pow(3) / 3 + columns * size.pow(2) < STEPS * columns * step
    }

    /// Solves all harmonics together; false where that is singular.
    fn solve_together(&mut self, right: &DMatrix<f64>, out: &mut DMatrix<f64>) -> bool {
        let mut whole = std::mem::take(&mut self.whole);
        let factored = self.factor_in(&mut whole, self.harmonics);
        if factored {
            out.fill(0.0);
            whole.add_solutions(right.as_slice(), out.as_mut_slice(), right.ncols());
        }
        self.whole = whole;
        factored
    }

    /// Largest change of a round, as a fraction, in a mixture of the solutions `x` in which each has the same size, that by
    /// `sizes`: for the work of one column it tells whether any has far to go.
    fn error_of_mixture(&mut self, right: &DMatrix<f64>, x: &DMatrix<f64>, sizes: &[(f64, Progress)]) -> f64 {
        let mut mixed = std::mem::take(&mut self.mixed);
        let mut source = std::mem::take(&mut self.prepared);
        let mut product = std::mem::take(&mut self.multiplied);
        mixed.fill(0.0);
        source.fill(0.0);
        // Signs without a pattern, that nothing cancels.
        let mut signs = Random::new(1);
        let height = mixed.len();
        let pairs = x.as_slice().chunks_exact(height).zip(right.as_slice().chunks_exact(height));
        for ((x, right), (size, _)) in pairs.zip(sizes) {
            let sign = if signs.uniform() < 0.5 { 1.0 } else { -1.0 };
            let weight = sign / size.max(f64::MIN_POSITIVE);
            mixed.iter_mut().zip(x).for_each(|(sum, x)| *sum += weight * x);
            source.iter_mut().zip(right).for_each(|(sum, right)| *sum += weight * right);
        }
        self.multiply(&mixed, &mut product);
        source.iter_mut().zip(&product).for_each(|(r, ax)| *r -= ax);
        mixed.fill(0.0);
        self.blocks.add_solutions(&source, &mut mixed, 1);
        let error = largest(&mixed);
        (self.mixed, self.prepared, self.multiplied) = (mixed, source, product);
        error
    }

    /// Rounds until each column converged, or is found to converge slowly.
    fn iterate_many(
        &mut self,
        right: &DMatrix<f64>,
        out: &mut DMatrix<f64>,
        progress: &mut [(f64, Progress)],
    ) {
        let (size, columns) = right.shape();
        if self.many.shape() != right.shape() {
            self.many = right.clone();
            self.many_coupled = right.clone();
        }
        for _ in 0..ROUNDS {
            self.residual_of_many(right, out);
            self.many_coupled.fill(0.0);
            self.blocks.add_solutions(self.many.as_slice(), self.many_coupled.as_mut_slice(), columns);
            let steps = self.many_coupled.as_slice();
            out.as_mut_slice().iter_mut().zip(steps).for_each(|(out, step)| *out += step);
            let steps =
                self.many_coupled.as_slice().chunks_exact(size).zip(out.as_slice().chunks_exact(size));
            for ((before, progress), (step, x)) in progress.iter_mut().zip(steps) {
                let change = largest(step);
                let contraction = change / before.max(f64::MIN_POSITIVE);
                *before = change;
                *progress = match *progress {
                    Progress::Converging if contraction * change <= self.derivative_error * largest(x) => {
                        Progress::Finished
                    }
                    Progress::Converging if contraction > SLOW => Progress::Slow,
                    known => known,
                };
            }
            if progress.iter().all(|(_, progress)| *progress != Progress::Converging) {
                break;
            }
        }
    }

    /// Makes `right − A x` for many columns.
    fn residual_of_many(&mut self, right: &DMatrix<f64>, x: &DMatrix<f64>) {
        let (modes, count) = (self.modes, coefficient_count(self.harmonics));
        let (size, columns) = right.shape();
        let view = DMatrixView::from_slice(x.as_slice(), modes, count * columns);
        DMatrixViewMut::from_slice(self.many_coupled.as_mut_slice(), modes, count * columns).gemm(
            1.0,
            &self.shortening,
            &view,
            0.0,
        );
        let mut many = std::mem::replace(&mut self.many, DMatrix::zeros(0, 0));
        for (x, many) in x.as_slice().chunks_exact(size).zip(many.as_mut_slice().chunks_exact_mut(size)) {
            self.multiply_dynamic(x, many);
        }
        // Mode by mode for all columns: few large products.
        let (rows, cols, along, across) = (Dyn(columns), Dyn(count), Dyn(size), Dyn(modes));
        for i in 0..modes {
            let coupled = &self.many_coupled.as_slice()[i..];
            let coupled = DMatrixView::from_slice_with_strides_generic(coupled, rows, cols, along, across);
            let into = &mut many.as_mut_slice()[i..];
            let mut into = DMatrixViewMut::from_slice_with_strides_generic(into, rows, cols, along, across);
            into.gemm(-1.0, &coupled, &self.product, 1.0);
        }
        many.as_mut_slice().iter_mut().zip(right.as_slice()).for_each(|(r, b)| *r = b - *r);
        self.many = many;
    }
}

/// How far one of many solutions is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Progress {
    Converging,
    /// Left to minimal residuals.
    Slow,
    Finished,
}

/// Dynamic stiffness and damping force per displacement of a mode with the stiffness ω² and the damping 2 ζ ω.
fn dynamic(stiffness: f64, damping: f64, at: &Operating, order: usize) -> (f64, f64) {
    let speed = order as f64 * at.angular_frequency;
    let sustained = 2.0 * at.self_excitation * at.angular_frequency;
    (stiffness - speed * speed, (damping - sustained) * speed)
}
