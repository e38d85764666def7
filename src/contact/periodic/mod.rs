//! The periodic state of a law under one period of samples.
//!
//! Marching to it may take thousands of periods (Valanis' law at a small amplitude X approaches it by
//! a factor `exp(−4 (1 − κ) λ X)` a period), so it is solved for: Newton on the map of one period,
//! whose derivative, the monodromy, is the product of the steps' state tangents.

mod singular_values;

use crate::contact::{ContactLaw, Inputs, StateTangents};
use singular_values::{multiply, orthogonalize_columns, set_identity};

/// One period of inputs, `n` samples; sample 0 follows the last.
#[derive(Debug, Clone, Copy)]
pub struct Period<'a> {
    /// Displacement (m), `n ≥ 1` samples.
    pub displacement: &'a [f64],
    /// Velocity (m/s), `n` samples, or none for zero.
    pub velocity: &'a [f64],
    /// Normal load (N), `n` samples, or one if it is constant.
    pub normal_load: &'a [f64],
}

impl Period<'_> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.displacement.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.displacement.is_empty()
    }

    /// Inputs at sample `index < len()` of a checked period.
    fn inputs(&self, index: usize) -> Inputs {
        Inputs {
            displacement: self.displacement[index],
            velocity: self.velocity.get(index).copied().unwrap_or(0.0),
            normal_load: if self.normal_load.len() == 1 {
                self.normal_load[0]
            } else {
                self.normal_load[index]
            },
        }
    }

    fn check(&self, law: &dyn ContactLaw, state: &[f64]) -> Result<(), PeriodicError> {
        let n = self.len();
        if n == 0 {
            return Err(PeriodicError::Length { what: "displacement", found: 0, expected: 1 });
        }
        if !self.velocity.is_empty() && self.velocity.len() != n {
            return Err(PeriodicError::Length { what: "velocity", found: self.velocity.len(), expected: n });
        }
        if self.normal_load.len() != 1 && self.normal_load.len() != n {
            let found = self.normal_load.len();
            return Err(PeriodicError::Length { what: "normal_load", found, expected: n });
        }
        if state.len() != law.state_len() {
            let expected = law.state_len();
            return Err(PeriodicError::Length { what: "state", found: state.len(), expected });
        }
        let inputs = [
            ("displacement", self.displacement),
            ("velocity", self.velocity),
            ("normal_load", self.normal_load),
            ("state", state),
        ];
        for (what, values) in inputs {
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                return Err(PeriodicError::NotFinite { what, index });
            }
        }
        Ok(())
    }
}

/// How the periodic state was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeriodicInfo {
    /// Largest change of a state component over one more period, relative to the component's largest
    /// value in the period.
    pub residual: f64,
    /// Newton steps taken; zero if marching two periods was enough.
    pub iterations: usize,
}

/// Why no periodic state was found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PeriodicError {
    /// Arrays that do not fit together.
    #[error("{what} has length {found}, expected {expected}")]
    Length {
        /// Which array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length that would fit; at least this for `displacement`.
        expected: usize,
    },
    /// An infinite value or a NaN.
    #[error("{what}[{index}] is not a finite number")]
    NotFinite {
        /// Which array.
        what: &'static str,
        /// Where.
        index: usize,
    },
    /// No state was found that reproduces itself, as for a law whose state drifts.
    #[error(
        "no periodic state after {iterations} Newton steps: a period still changes the state by {residual:e} of its size"
    )]
    NotConverged {
        /// As in [`PeriodicInfo::residual`].
        residual: f64,
        /// As in [`PeriodicInfo::iterations`].
        iterations: usize,
    },
}

/// Buffers of the search, for callers that solve many periods: nothing is allocated once they have
/// grown to a law's state.
///
/// ```
/// use stickslip::contact::{ContactLaw, Jenkins, Period, PeriodicSolver};
/// let law = Jenkins::new(1e6, 0.5)?;
/// let (amplitude, load, limit) = (1e-4, 100.0, 50.0);
/// let phases = (0..100).map(|sample| std::f64::consts::TAU * f64::from(sample) / 100.0);
/// let displacement: Vec<f64> = phases.map(|phase| amplitude * phase.cos()).collect();
/// let period = Period { displacement: &displacement, velocity: &[], normal_load: &[load] };
/// let (mut state, mut force) = ([0.0; 3], [0.0; 100]);
/// law.set_state(0.0, load, 0.0, &mut state);
/// let mut solver = PeriodicSolver::new();
/// solver.solve(&law, &period, &mut state)?;
/// let dissipated = solver.trace(&law, &period, &mut state, &mut force)?;
/// let area = 4.0 * limit * (amplitude - limit / law.tangential_stiffness());
/// assert!((dissipated / area - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct PeriodicSolver {
    current: Vec<f64>,
    next: Vec<f64>,
    trial: Vec<f64>,
    residual: Vec<f64>,
    scale: Vec<f64>,
    correction: Vec<f64>,
    monodromy: Vec<f64>,
    product: Vec<f64>,
    matrix: Vec<f64>,
    rotation: Vec<f64>,
    tangents: StateTangents,
}

const MAX_ITERATIONS: usize = 50;
/// A Newton correction below this, relative to the state's size, is the last.
const CORRECTION_TOLERANCE: f64 = 1e-10;
/// A residual below this is round-off.
const RESIDUAL_FLOOR: f64 = 1e-15;
/// What may be left when round-off stops the progress.
const RESIDUAL_ACCEPTED: f64 = 1e-10;
/// Singular values of I − monodromy below this fraction of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-12;

/// Writes the state at the end of the period that reproduces itself under one period of
/// `displacement` (m, `n` samples, sample 0 follows the last) and `normal_load` (N, `n` samples, or one
/// if constant) at zero velocity. `state` holds the start of the search, and where the period does not
/// determine a component (a stuck slider), that component stays as marching two periods leaves it.
///
/// # Errors
/// [`PeriodicError`], with `state` then unspecified.
///
/// ```
/// use stickslip::contact::{ContactLaw, Valanis, periodic_state};
/// let law = Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15)?;
/// let mut state = [0.0; 4];
/// law.set_state(0.0, 147.15, 0.0, &mut state);
/// periodic_state(&law, &[-1e-6, 1e-6], &[147.15], &mut state)?;
/// assert!((state[0] - 7.886058).abs() < 1e-6); // the initial loading curve ends at 7.660241 N
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn periodic_state(
    law: &dyn ContactLaw,
    displacement: &[f64],
    normal_load: &[f64],
    state: &mut [f64],
) -> Result<PeriodicInfo, PeriodicError> {
    let period = Period { displacement, velocity: &[], normal_load };
    PeriodicSolver::default().solve(law, &period, state)
}

impl PeriodicSolver {
    /// An empty workspace.
    pub fn new() -> Self {
        Self::default()
    }

    /// As [`periodic_state`], with velocities and without allocation once the buffers have grown.
    ///
    /// # Errors
    /// [`PeriodicError`], with `state` then unspecified.
    pub fn solve(
        &mut self,
        law: &dyn ContactLaw,
        period: &Period,
        state: &mut [f64],
    ) -> Result<PeriodicInfo, PeriodicError> {
        period.check(law, state)?;
        self.grow(state.len());
        // The first period brings in the displacement and the load that the state remembers, the
        // second forgets what friction forgets in one period.
        for _ in 0..2 {
            self.march(law, period, state, false);
            state.copy_from_slice(&self.current);
        }
        let mut residual = self.march(law, period, state, true);
        for iterations in 0..MAX_ITERATIONS {
            if residual <= RESIDUAL_FLOOR {
                return Ok(PeriodicInfo { residual, iterations });
            }
            let size = self.newton_correction();
            let (better, progress) = self.search(law, period, state, residual);
            if (size <= CORRECTION_TOLERANCE || !progress) && better <= RESIDUAL_ACCEPTED {
                return Ok(PeriodicInfo { residual: better, iterations: iterations + 1 });
            }
            if !progress {
                return Err(PeriodicError::NotConverged { residual: better, iterations: iterations + 1 });
            }
            residual = self.march(law, period, state, true);
        }
        Err(PeriodicError::NotConverged { residual, iterations: MAX_ITERATIONS })
    }

    /// Runs one period from `state` and writes the state after it back; `force` receives the force at
    /// each sample (N, as many as the period has). Returns the energy dissipated (J).
    ///
    /// # Errors
    /// [`PeriodicError::Length`] and [`PeriodicError::NotFinite`].
    pub fn trace(
        &mut self,
        law: &dyn ContactLaw,
        period: &Period,
        state: &mut [f64],
        force: &mut [f64],
    ) -> Result<f64, PeriodicError> {
        period.check(law, state)?;
        if force.len() != period.len() {
            let (found, expected) = (force.len(), period.len());
            return Err(PeriodicError::Length { what: "force", found, expected });
        }
        self.grow(state.len());
        let mut dissipated = 0.0;
        for (index, force) in force.iter_mut().enumerate() {
            let response = law.step(state, period.inputs(index), &mut self.next);
            state.copy_from_slice(&self.next);
            *force = response.force;
            dissipated += response.dissipated_energy;
        }
        Ok(dissipated)
    }

    fn grow(&mut self, n: usize) {
        let vectors = [
            &mut self.current,
            &mut self.next,
            &mut self.trial,
            &mut self.residual,
            &mut self.scale,
            &mut self.correction,
        ];
        vectors.into_iter().for_each(|vector| vector.resize(n, 0.0));
        let matrices = [&mut self.monodromy, &mut self.product, &mut self.matrix, &mut self.rotation];
        matrices.into_iter().for_each(|matrix| matrix.resize(n * n, 0.0));
    }

    /// One period from `state`: leaves the end in `current`, the change in `residual`, each component's
    /// size in `scale` and, if asked for, ∂end/∂start in `monodromy`. Returns the scaled change.
    fn march(&mut self, law: &dyn ContactLaw, period: &Period, state: &[f64], with_monodromy: bool) -> f64 {
        let n = state.len();
        self.current.copy_from_slice(state);
        for (scale, value) in self.scale.iter_mut().zip(state) {
            *scale = value.abs();
        }
        if with_monodromy {
            set_identity(&mut self.monodromy, n);
        }
        for index in 0..period.len() {
            let inputs = period.inputs(index);
            if with_monodromy {
                law.state_tangents(&self.current, inputs, &mut self.tangents);
                multiply(&self.tangents.next_by_state, &self.monodromy, n, &mut self.product);
                std::mem::swap(&mut self.monodromy, &mut self.product);
            }
            law.step(&self.current, inputs, &mut self.next);
            std::mem::swap(&mut self.current, &mut self.next);
            for (scale, value) in self.scale.iter_mut().zip(&self.current) {
                *scale = scale.max(value.abs());
            }
        }
        let mut largest: f64 = 0.0;
        let components = self.residual.iter_mut().zip(&mut self.scale).zip(self.current.iter().zip(state));
        for ((residual, scale), (end, start)) in components {
            *residual = end - start;
            if *scale == 0.0 {
                *scale = 1.0;
            }
            let change = (*residual / *scale).abs();
            // An overflow on the way must not pass for convergence: `max` would drop the NaN.
            largest = if change.is_nan() { f64::INFINITY } else { largest.max(change) };
        }
        largest
    }

    /// Least-norm solution of `(I − monodromy) correction = residual` in components of size one, from
    /// the singular value decomposition. Returns the largest scaled component.
    fn newton_correction(&mut self) -> f64 {
        let n = self.residual.len();
        for i in 0..n {
            for j in 0..n {
                let identity = if i == j { 1.0 } else { 0.0 };
                let entry = self.monodromy[i * n + j] * (self.scale[j] / self.scale[i]);
                self.matrix[i * n + j] = identity - entry;
            }
        }
        orthogonalize_columns(&mut self.matrix, &mut self.rotation, n);
        let column = |matrix: &[f64], j: usize| (0..n).map(|i| matrix[i * n + j].powi(2)).sum::<f64>();
        let largest = (0..n).map(|j| column(&self.matrix, j)).fold(0.0, f64::max);
        self.correction.fill(0.0);
        for j in 0..n {
            let square = column(&self.matrix, j);
            if square <= largest * RANK_TOLERANCE * RANK_TOLERANCE {
                continue;
            }
            let along: f64 =
                (0..n).map(|i| self.matrix[i * n + j] * (self.residual[i] / self.scale[i])).sum();
            for i in 0..n {
                self.correction[i] += self.rotation[i * n + j] * (along / square);
            }
        }
        let size = self.correction.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
        for i in 0..n {
            self.correction[i] *= self.scale[i];
        }
        size
    }

    /// Moves `state` along the correction, by less where the whole does not reduce the residual, and
    /// by one plain period where none of it does. Returns the residual there and whether it fell.
    fn search(
        &mut self,
        law: &dyn ContactLaw,
        period: &Period,
        state: &mut [f64],
        residual: f64,
    ) -> (f64, bool) {
        let mut trial = std::mem::take(&mut self.trial);
        let mut fraction = 1.0;
        let mut outcome = (residual, false);
        for _ in 0..8 {
            for i in 0..state.len() {
                trial[i] = state[i] + fraction * self.correction[i];
            }
            let there = self.march(law, period, &trial, false);
            if there < residual {
                state.copy_from_slice(&trial);
                outcome = (there, true);
                break;
            }
            fraction *= 0.5;
        }
        if !outcome.1 {
            self.march(law, period, state, false);
            trial.copy_from_slice(&self.current);
            let there = self.march(law, period, &trial, false);
            if there < residual {
                state.copy_from_slice(&trial);
                outcome = (there, true);
            }
        }
        self.trial = trial;
        outcome
    }
}
