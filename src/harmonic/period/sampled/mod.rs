//! The periodic contact: Fourier coefficients of the displacement in, of the force out.
//!
//! This is the seam between the balance equations and the scheme by which a contact is integrated over a period:
//! [`SampledCycle::evaluate`] answers with the force's coefficients and their exact derivatives for
//! the discretisation it uses. Here the period is sampled (alternating frequency/time, Cameron &
//! Griffin 1989); within a step the displacement runs linearly, so that the turning points are met
//! to the second order of the step only. Where the force jumps within a step is known ([`jump`]).
//!
//! The contact's state is part of the problem: a period is marched with the derivatives of every
//! quantity with respect to the coefficients *and* to the state at its start. The monodromy matrix
//! gives the periodic state by Newton's method, and the implicit function theorem its derivative.
//! Where the memory does not fade (a stuck contact keeps whatever it remembers) the periodic state
//! is not unique; then the one reached by loading a contact without history to the largest displacement of
//! the period counts, and its derivative is carried through that loading.

mod alone;
mod jump;
mod march;

pub(in crate::harmonic::period) use march::differentiate_functions;

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DMatrixView, Dyn};

use super::PeriodicContact;
use super::closure::{Closure, Marched, add_scaled};
use crate::contact::{SlipState, StateTangents};
use crate::harmonic::HarmonicError;
use crate::numeric::SMALL_PRODUCT;
use crate::numeric::fourier::{Basis, coefficient_count, differentiate, dot};

/// Fraction of the largest force left as error of the implicit step through the series spring.
const STEP_TOLERANCE: f64 = 1e-11;
/// Change of force (fraction of the largest) and of the state (of each part's largest) below which the periodic state is
/// finished to first order.
const LINEAR_FINISH: f64 = 1e-6;
const MAX_CYCLES: usize = 60;

/// Workspace and result of one evaluation.
#[derive(Debug, Clone)]
pub(crate) struct SampledCycle {
    basis: Basis,
    samples: usize,
    wide: usize,
    /// Coefficients of the force (N), as many as the displacement has.
    pub force: Vec<f64>,
    /// ∂force/∂displacement coefficients, `wide × wide` (N/m).
    pub jacobian: DMatrix<f64>,
    /// ∂force coefficients/∂angular frequency; zero for rate-independent laws.
    pub by_frequency: Vec<f64>,
    displacement: Vec<f64>,
    rate: Vec<f64>,
    slope: Vec<f64>,
    /// Normal load (N) at the samples.
    load: Vec<f64>,
    force_samples: Vec<f64>,
    /// Displacement of the contact itself (m) at the samples, and whether it slips there.
    passed: Vec<(f64, SlipState)>,
    /// Column `k`: derivatives of the force at sample `k` by coefficients, frequency, start state.
    sensitivity: DMatrix<f64>,
    state_len: usize,
    /// The sample the march starts from.
    origin: usize,
    without_history: Vec<f64>,
    start: Vec<f64>,
    state: Vec<f64>,
    next: Vec<f64>,
    state_scale: Vec<f64>,
    start_sensitivity: Vec<f64>,
    state_sensitivity: Vec<f64>,
    next_sensitivity: Vec<f64>,
    /// Parts of the state whose sensitivity the last step changed.
    changed: Vec<usize>,
    displacement_row: Vec<f64>,
    velocity_row: Vec<f64>,
    closure: Closure,
    tangents: StateTangents,
    jump: jump::Workspace,
    force_scale: f64,
    previous: Vec<f64>,
    /// The samples and sensitivities belong to a converged evaluation at `previous`.
    warm: bool,
    /// The start and the forces are those of the displacement `previous` itself, without derivatives.
    settled: bool,
}

/// What one marched period tells about the periodic state.
struct Judgement {
    unique: bool,
    /// Largest change (N) of a force sample, to first order.
    force_change: f64,
    /// Largest change of the start state, in sizes of its parts over the period.
    state_change: f64,
}

impl SampledCycle {
    /// `harmonics` are those of the displacement and of the force.
    pub fn new(harmonics: usize, samples: usize) -> Self {
        let wide = coefficient_count(harmonics);
        Self {
            basis: Basis::new(harmonics, samples),
            samples,
            wide,
            force: vec![0.0; wide],
            jacobian: DMatrix::zeros(wide, wide),
            by_frequency: vec![0.0; wide],
            displacement: vec![0.0; samples],
            rate: vec![0.0; samples],
            slope: vec![0.0; wide],
            load: vec![0.0; samples],
            force_samples: vec![0.0; samples],
            passed: vec![(0.0, SlipState::Stick); samples],
            sensitivity: DMatrix::zeros(0, 0),
            state_len: usize::MAX,
            origin: 0,
            without_history: Vec::new(),
            start: Vec::new(),
            state: Vec::new(),
            next: Vec::new(),
            state_scale: Vec::new(),
            start_sensitivity: Vec::new(),
            state_sensitivity: Vec::new(),
            next_sensitivity: Vec::new(),
            changed: Vec::new(),
            displacement_row: Vec::new(),
            velocity_row: Vec::new(),
            closure: Closure::default(),
            tangents: StateTangents::default(),
            jump: jump::Workspace::default(),
            force_scale: 0.0,
            previous: vec![0.0; wide],
            warm: false,
            settled: false,
        }
    }

    /// Forgets the last solution, so that the next evaluation depends on its arguments alone.
    pub fn forget(&mut self) {
        (self.warm, self.settled) = (false, false);
    }

    /// Force (N) at the samples of the last evaluation.
    pub fn forces(&self) -> &[f64] {
        &self.force_samples
    }

    /// Displacement of the contact itself (m), whether it slips, and force (N) at every sample of the last evaluation.
    pub fn passed(&self) -> impl Iterator<Item = (f64, SlipState, f64)> + Clone {
        self.passed.iter().zip(&self.force_samples).map(|((u, state), force)| (*u, *state, *force))
    }

    /// Writes the load at the samples.
    fn take_load(&mut self, contact: &PeriodicContact) {
        self.load.fill(contact.normal_load);
        for (order, pair) in (1..).zip(contact.load_swing.chunks_exact(2)) {
            for (k, load) in self.load.iter_mut().enumerate() {
                let turn = (order * k % self.samples) as f64 / self.samples as f64;
                let (sine, cosine) = (TAU * turn).sin_cos();
                *load += pair[0] * cosine + pair[1] * sine;
            }
        }
    }

    fn reserve(&mut self, state_len: usize) {
        if self.state_len == state_len {
            return;
        }
        self.state_len = state_len;
        let columns = self.wide + 1 + state_len;
        self.sensitivity = DMatrix::zeros(columns, self.samples);
        for buffer in [
            &mut self.without_history,
            &mut self.start,
            &mut self.state,
            &mut self.next,
            &mut self.state_scale,
        ] {
            *buffer = vec![0.0; state_len];
        }
        for buffer in [&mut self.start_sensitivity, &mut self.state_sensitivity, &mut self.next_sensitivity] {
            *buffer = vec![0.0; state_len * columns];
        }
        self.displacement_row = vec![0.0; columns];
        self.velocity_row = vec![0.0; columns];
        self.forget();
    }

    /// Evaluates the contact for the displacement with coefficients `u` (m; before the series spring gives way) at
    /// the fundamental `angular_frequency` (rad/s). The velocity a rate-dependent law sees is that of `u`.
    ///
    /// # Errors
    /// [`HarmonicError::ContactNotPeriodic`] when no periodic state is found.
    pub fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.take_motion(contact, u);
        let settled = std::mem::take(&mut self.settled) && self.previous == u;
        let mut from_hint = self.warm || settled;
        if self.warm {
            self.predict(u);
        } else if !settled {
            self.start_without_history(contact, angular_frequency);
        }
        self.previous.copy_from_slice(u);
        self.warm = false;
        let (mut last_change, mut plain) = (f64::INFINITY, false);
        for _ in 0..MAX_CYCLES {
            self.march(contact, angular_frequency);
            let closure = self.close();
            if from_hint && !(closure.unique && closure.force_change.is_finite()) {
                from_hint = false;
                self.start_without_history(contact, angular_frequency);
                continue;
            }
            // Where the force follows the limit it does not show a change of the state that puts an end to that.
            let unmoved = closure.state_change <= LINEAR_FINISH;
            if unmoved && closure.force_change <= LINEAR_FINISH * self.force_scale {
                self.finish();
                self.closure.correct(&mut self.start, &mut self.start_sensitivity, true);
                self.warm = true;
                return Ok(());
            }
            // Newton may overshoot where the loop bends sharply; plain marching always contracts.
            let change = closure.force_change.max(closure.state_change * self.force_scale);
            plain = !closure.force_change.is_finite() || change > last_change && !plain;
            last_change = change;
            self.improve_start(plain, contact, angular_frequency);
        }
        Err(HarmonicError::ContactNotPeriodic { cycles: MAX_CYCLES })
    }

    /// Writes displacement, slope and load at the samples, and the contact that remembers nothing.
    fn take_motion(&mut self, contact: &PeriodicContact, u: &[f64]) {
        self.reserve(contact.law.state_len());
        self.basis.evaluate(u, &mut self.displacement);
        differentiate(u, &mut self.slope);
        self.basis.evaluate(&self.slope, &mut self.rate);
        self.take_load(contact);
        contact.law.set_state(0.0, self.load[self.farthest_sample()], 0.0, &mut self.without_history);
    }

    /// The sample of the largest displacement: a turning point, where most of the memory is wiped out.
    fn farthest_sample(&self) -> usize {
        let mut best = 0;
        for (k, u) in self.displacement.iter().enumerate() {
            if u.abs() > self.displacement[best].abs() {
                best = k;
            }
        }
        best
    }

    /// First-order prediction of the force samples and the start state from the last solution.
    fn predict(&mut self, u: &[f64]) {
        for (previous, u) in self.previous.iter_mut().zip(u) {
            *previous = u - *previous;
        }
        let columns = self.sensitivity.nrows();
        for (force, column) in
            self.force_samples.iter_mut().zip(self.sensitivity.as_slice().chunks_exact(columns))
        {
            *force += dot(&column[..self.wide], &self.previous);
        }
        for (state, row) in self.start.iter_mut().zip(self.start_sensitivity.chunks_exact(columns)) {
            *state += dot(&row[..self.wide], &self.previous);
        }
    }

    /// The state after loading a contact without history to the largest displacement, and its derivative.
    fn start_without_history(&mut self, contact: &PeriodicContact, angular_frequency: f64) {
        self.origin = self.farthest_sample();
        self.state.copy_from_slice(&self.without_history);
        self.state_sensitivity.fill(0.0);
        self.force_scale = 0.0;
        self.step(contact, angular_frequency, self.origin, 0.0, None);
        self.move_on();
        self.start.copy_from_slice(&self.state);
        self.start_sensitivity.copy_from_slice(&self.state_sensitivity);
        self.force_samples.fill(f64::NAN);
    }

    /// How far the state at the start is from the periodic one.
    fn close(&mut self) -> Judgement {
        let (n, inputs) = (self.state_len, self.wide + 1);
        let marched = Marched {
            start: &self.start,
            end: &self.state,
            start_sensitivity: &self.start_sensitivity,
            end_sensitivity: &self.state_sensitivity,
        };
        let state_change = self.closure.solve(&marched, inputs, &mut self.state_scale);
        // Memory that does not fade must be a contact without history's, or the result would depend on the
        // evaluations before.
        let unique = (0..n).all(|i| {
            self.closure.is_found(i)
                || (self.start[i] - self.without_history[i]).abs() <= 1e-12 * self.state_scale[i]
        });
        let columns = self.sensitivity.as_slice().chunks_exact(inputs + n);
        let force_change = self.closure.force_change(columns.map(|column| &column[inputs..]));
        Judgement { unique, force_change, state_change }
    }

    /// Moves the start towards the periodic state: by Newton's step, or to where the period ended.
    fn improve_start(&mut self, plain: bool, contact: &PeriodicContact, angular_frequency: f64) {
        if plain && self.state.iter().any(|x| !x.is_finite()) {
            self.start_without_history(contact, angular_frequency);
        } else if plain {
            self.start.copy_from_slice(&self.state);
            self.start_sensitivity.copy_from_slice(&self.state_sensitivity);
        } else {
            self.closure.correct(&mut self.start, &mut self.start_sensitivity, true);
        }
    }

    /// Adds what the start state contributes, to first order, and projects on the harmonics.
    fn finish(&mut self) {
        let (n, wide, samples) = (self.state_len, self.wide, self.samples);
        let columns = wide + 1 + n;
        for (force, column) in
            self.force_samples.iter_mut().zip(self.sensitivity.as_mut_slice().chunks_exact_mut(columns))
        {
            let (total, by_state) = column.split_at_mut(wide + 1);
            for (weight, changes) in by_state.iter().zip(self.closure.changes()) {
                if *weight != 0.0 {
                    *force += weight * changes[0];
                    add_scaled(total, *weight, &changes[1..]);
                }
            }
        }
        self.force_samples.iter_mut().zip(&self.jump.given).for_each(|(force, given)| *force += given);
        self.basis.project(&self.force_samples, &mut self.force);
        // jacobian = projectionᵀ · sensitivityᵀ, both as strided views so that the fast product is used.
        let projection = &self.basis.projection;
        let left = transposed(projection.as_slice(), samples, wide, samples);
        let right_factor = transposed(self.sensitivity.as_slice(), wide, samples, columns);
        if wide > SMALL_PRODUCT {
            self.jacobian.gemm(1.0, &left, &right_factor, 0.0);
        } else {
            for (m, column) in self.jacobian.as_mut_slice().chunks_exact_mut(wide).enumerate() {
                for (value, function) in column.iter_mut().zip(projection.as_slice().chunks_exact(samples)) {
                    *value = function.iter().enumerate().map(|(k, p)| p * self.sensitivity[(m, k)]).sum();
                }
            }
        }
        for (m, value) in self.by_frequency.iter_mut().enumerate() {
            let column = &projection.as_slice()[m * samples..(m + 1) * samples];
            *value = column.iter().enumerate().map(|(k, p)| p * self.sensitivity[(wide, k)]).sum();
        }
    }
}

/// The transpose of a column-major `rows × columns` matrix with the given column stride, as a view.
pub(crate) fn transposed(
    data: &[f64],
    rows: usize,
    columns: usize,
    stride: usize,
) -> DMatrixView<'_, f64, Dyn, Dyn> {
    DMatrixView::from_slice_with_strides_generic(data, Dyn(columns), Dyn(rows), Dyn(stride), Dyn(1))
}
