//! A contact in two directions over a period: coefficients of ξ and η in, of S and N out.
//!
//! The period is sampled, and marched from the largest tangential displacement, to which a contact without history is
//! loaded at once, until the state reproduces itself: what slips forgets within a period, and what sticks all through
//! keeps what the first loading left. What forgets slowly is put ahead ([`SlowEnd`]).

use nalgebra::DMatrix;

use super::CycleSummary;
use super::sampled::differentiate_functions;
use super::slow::SlowEnd;
use crate::contact::{SlipSlap, SlipSlapInputs, SlipSlapTangents, SlipSlapWork, SlipState};
use crate::harmonic::HarmonicError;
use crate::numeric::fourier::{Basis, coefficient_count, differentiate};

/// Change of the state in a period, as a fraction of its parts' largest values, that counts as none.
const CLOSED: f64 = 1e-10;
const MAX_CYCLES: usize = 100;

/// One of the two directions.
#[derive(Debug, Clone)]
struct Direction {
    basis: Basis,
    wide: usize,
    /// Displacement (m) and its derivative by the phase at the samples.
    displacement: Vec<f64>,
    rate: Vec<f64>,
    slope: Vec<f64>,
    /// Restoring force (N) at the samples, and its coefficients.
    forces: Vec<f64>,
    force: Vec<f64>,
    /// Column `k`: derivatives of the force at sample `k` by the coefficients of both displacements and the frequency.
    sensitivity: DMatrix<f64>,
    /// ∂force coefficients/∂(all of these).
    by_all: DMatrix<f64>,
    velocity_row: Vec<f64>,
}

/// Workspace and result of one evaluation.
#[derive(Debug, Clone)]
pub(crate) struct PairCycle {
    samples: usize,
    columns: usize,
    directions: [Direction; 2],
    state: Vec<f64>,
    next: Vec<f64>,
    begin: Vec<f64>,
    scale: Vec<f64>,
    carried: Vec<f64>,
    carried_next: Vec<f64>,
    tangents: SlipSlapTangents,
    work: SlipSlapWork,
    summary: PairSummary,
}

/// What a contact in two directions did over a period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PairSummary {
    /// Energy that friction and impacts dissipate (J).
    pub friction_energy: f64,
    pub impact_energy: f64,
    /// Fraction of the period in stick.
    pub stick_fraction: f64,
}

impl Direction {
    fn new(harmonics: usize, samples: usize, columns: usize) -> Self {
        let wide = coefficient_count(harmonics);
        Self {
            basis: Basis::new(harmonics, samples),
            wide,
            displacement: vec![0.0; samples],
            rate: vec![0.0; samples],
            slope: vec![0.0; wide],
            forces: vec![0.0; samples],
            force: vec![0.0; wide],
            sensitivity: DMatrix::zeros(columns, samples),
            by_all: DMatrix::zeros(columns, wide),
            velocity_row: vec![0.0; wide],
        }
    }

    /// Slope (N/m) from tip to tip of the loop.
    fn equivalent_stiffness(&self) -> f64 {
        let at = |k: &usize| self.displacement[*k];
        let by_place = |a: &usize, b: &usize| at(a).total_cmp(&at(b));
        let ends = ((0..self.forces.len()).min_by(by_place), (0..self.forces.len()).max_by(by_place));
        let (Some(low), Some(high)) = ends else { return f64::NAN };
        (self.forces[high] - self.forces[low]) / (at(&high) - at(&low))
    }

    fn take(&mut self, u: &[f64]) {
        self.basis.evaluate(u, &mut self.displacement);
        differentiate(u, &mut self.slope);
        self.basis.evaluate(&self.slope, &mut self.rate);
    }
}

impl PairCycle {
    /// For ξ and η of so many harmonics each, at so many samples of a period.
    pub fn new(harmonics: [usize; 2], samples: usize) -> Self {
        let columns = harmonics.map(coefficient_count).iter().sum::<usize>() + 1;
        Self {
            samples,
            columns,
            directions: harmonics.map(|harmonics| Direction::new(harmonics, samples, columns)),
            state: Vec::new(),
            next: Vec::new(),
            begin: Vec::new(),
            scale: Vec::new(),
            carried: Vec::new(),
            carried_next: Vec::new(),
            tangents: SlipSlapTangents::default(),
            work: SlipSlapWork::default(),
            summary: PairSummary::default(),
        }
    }

    /// Leaves no derivatives of an earlier contact where those of the next are not found.
    pub fn forget(&mut self) {
        self.directions.iter_mut().for_each(|direction| direction.by_all.fill(0.0));
    }

    /// Coefficients of S or N (N) of the last evaluation.
    pub fn force(&self, direction: usize) -> &[f64] {
        &self.directions[direction].force
    }

    /// ∂(coefficient `row` of S or N) by the coefficients of ξ, of η, and by the frequency, of the last evaluation with
    /// derivatives.
    pub fn derivatives(&self, direction: usize, row: usize) -> &[f64] {
        &self.directions[direction].by_all.as_slice()[row * self.columns..(row + 1) * self.columns]
    }

    /// What the contact did along ξ and η in the last evaluation: energy and stick are those of friction and of impacts.
    pub fn summaries(&self) -> [CycleSummary; 2] {
        let PairSummary { friction_energy, impact_energy, stick_fraction } = self.summary;
        let energies = [friction_energy, impact_energy];
        std::array::from_fn(|direction| CycleSummary {
            dissipated_energy: energies[direction],
            equivalent_stiffness: self.directions[direction].equivalent_stiffness(),
            stick_fraction: (direction == 0).then_some(stick_fraction),
        })
    }

    /// Evaluates `contact` for the displacements `u` (m) at `angular_frequency` (rad/s).
    ///
    /// # Errors
    /// [`HarmonicError::ContactNotPeriodic`] when the state does not settle.
    pub fn evaluate(
        &mut self,
        contact: &SlipSlap,
        angular_frequency: f64,
        u: [&[f64]; 2],
        derivatives: bool,
    ) -> Result<(), HarmonicError> {
        self.directions.iter_mut().zip(u).for_each(|(direction, u)| direction.take(u));
        let n = contact.state_len();
        for list in [&mut self.state, &mut self.next, &mut self.begin, &mut self.scale] {
            list.resize(n, 0.0);
        }
        for list in [&mut self.carried, &mut self.carried_next] {
            list.clear();
            list.resize(if derivatives { n * self.columns } else { 0 }, 0.0);
        }
        let far = |k: &usize| self.directions[0].displacement[*k].abs();
        let origin = (0..self.samples).max_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0);
        contact.set_state([0.0; 2], 0.0, &mut self.state);
        self.step(contact, angular_frequency, origin, derivatives);
        if derivatives {
            // What slips in the first period alone, and sticks from then on, is known by this period alone.
            self.march(contact, angular_frequency, origin, true);
        }
        self.close(contact, angular_frequency, origin)?;
        if derivatives {
            self.close_derivatives(contact, angular_frequency, origin);
        }
        self.project(derivatives);
        Ok(())
    }

    /// Marches until the state reproduces itself.
    fn close(
        &mut self,
        contact: &SlipSlap,
        angular_frequency: f64,
        origin: usize,
    ) -> Result<(), HarmonicError> {
        let mut slow = SlowEnd::default();
        for _ in 0..MAX_CYCLES {
            if self.march(contact, angular_frequency, origin, false) <= CLOSED {
                return Ok(());
            }
            slow.look_ahead(&self.begin, &mut self.state, &self.scale);
        }
        Err(HarmonicError::ContactNotPeriodic { cycles: MAX_CYCLES })
    }

    /// Marches on from a state that reproduces itself until the derivatives do.
    fn close_derivatives(&mut self, contact: &SlipSlap, angular_frequency: f64, origin: usize) {
        let mut slow = SlowEnd::default();
        for _ in 0..MAX_CYCLES {
            let begin = self.carried.clone();
            self.march(contact, angular_frequency, origin, true);
            let largest =
                |list: &mut dyn Iterator<Item = f64>| list.fold(0.0_f64, |most, x| most.max(x.abs()));
            let change = largest(&mut self.carried.iter().zip(&begin).map(|(end, begin)| end - begin));
            let size = largest(&mut self.carried.iter().copied());
            if change <= CLOSED * size {
                return;
            }
            slow.look_ahead(&begin, &mut self.carried, &vec![size; begin.len()]);
        }
    }

    /// Marches a period from sample `origin`; returns the change of the state.
    fn march(&mut self, contact: &SlipSlap, angular_frequency: f64, origin: usize, derivatives: bool) -> f64 {
        self.begin.copy_from_slice(&self.state);
        self.scale.fill(0.0);
        self.summary = PairSummary::default();
        for i in 1..=self.samples {
            self.step(contact, angular_frequency, (origin + i) % self.samples, derivatives);
            self.scale.iter_mut().zip(&self.state).for_each(|(scale, value)| *scale = scale.max(value.abs()));
        }
        let changes = self.state.iter().zip(&self.begin).zip(&self.scale);
        let relative = |((end, begin), scale): ((&f64, &f64), &f64)| {
            if *scale > 0.0 { (end - begin).abs() / scale } else { 0.0 }
        };
        // NaN must not pass for closed.
        changes.map(relative).fold(0.0, |most: f64, x| if x > most || x.is_nan() { x } else { most })
    }

    /// A step to sample `k`.
    fn step(&mut self, contact: &SlipSlap, angular_frequency: f64, k: usize, derivatives: bool) {
        let at = |direction: &Direction| (direction.displacement[k], angular_frequency * direction.rate[k]);
        let [(xi, xi_rate), (eta, eta_rate)] = [at(&self.directions[0]), at(&self.directions[1])];
        let inputs = SlipSlapInputs { displacement: [xi, eta], velocity: [xi_rate, eta_rate] };
        let Self { state, next, tangents, work, .. } = self;
        let response = if derivatives {
            contact.step_and_tangents(state, inputs, next, tangents, work)
        } else {
            contact.step(state, inputs, next, work)
        };
        for (direction, force) in self.directions.iter_mut().zip(response.force) {
            direction.forces[k] = force;
        }
        self.summary.friction_energy += response.friction_energy;
        self.summary.impact_energy += response.impact_energy;
        if response.slip_state == SlipState::Stick {
            self.summary.stick_fraction += 1.0 / self.samples as f64;
        }
        if derivatives {
            self.carry(angular_frequency, k, &response.by_displacement, &response.by_velocity);
        }
        std::mem::swap(&mut self.state, &mut self.next);
    }

    /// Carries the derivatives over the step just made.
    fn carry(&mut self, angular_frequency: f64, k: usize, by_u: &[[f64; 2]; 2], by_v: &[[f64; 2]; 2]) {
        let (n, columns) = (self.state.len(), self.columns);
        for direction in &mut self.directions {
            differentiate_functions(
                direction.basis.functions(k),
                angular_frequency,
                &mut direction.velocity_row,
            );
        }
        for force in 0..2 {
            let mut column = std::mem::take(&mut self.directions[force].sensitivity);
            let target = &mut column.as_mut_slice()[k * columns..(k + 1) * columns];
            target.fill(0.0);
            self.add_inputs(k, by_u[force], by_v[force], target);
            add_products(&self.tangents.force_by_state[force * n..][..n], &self.carried, target);
            self.directions[force].sensitivity = column;
        }
        let mut carried = std::mem::take(&mut self.carried_next);
        for (i, target) in carried.chunks_exact_mut(columns).enumerate() {
            target.fill(0.0);
            let pair = |list: &[f64]| [list[2 * i], list[2 * i + 1]];
            let (by_u, by_v) =
                (pair(&self.tangents.next_by_displacement), pair(&self.tangents.next_by_velocity));
            self.add_inputs(k, by_u, by_v, target);
            add_products(&self.tangents.next_by_state[i * n..][..n], &self.carried, target);
        }
        self.carried_next = std::mem::replace(&mut self.carried, carried);
    }

    /// Adds what displacements and velocities at sample `k` do, by the coefficients and the frequency.
    fn add_inputs(&self, k: usize, by_u: [f64; 2], by_v: [f64; 2], target: &mut [f64]) {
        let (coefficients, frequency) = target.split_at_mut(self.columns - 1);
        let (first, second) = coefficients.split_at_mut(self.directions[0].wide);
        for (j, target) in [first, second].into_iter().enumerate() {
            let direction = &self.directions[j];
            if by_u[j] != 0.0 {
                add(by_u[j], direction.basis.functions(k), target);
            }
            if by_v[j] != 0.0 {
                add(by_v[j], &direction.velocity_row, target);
                frequency[0] += by_v[j] * direction.rate[k];
            }
        }
    }

    fn project(&mut self, derivatives: bool) {
        for direction in &mut self.directions {
            direction.basis.project(&direction.forces, &mut direction.force);
            if derivatives {
                direction.by_all.gemm(1.0, &direction.sensitivity, &direction.basis.projection, 0.0);
            }
        }
    }
}

fn add(factor: f64, from: &[f64], to: &mut [f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
}

/// `target += weights · rows`.
fn add_products(weights: &[f64], rows: &[f64], target: &mut [f64]) {
    let columns = target.len();
    for (weight, row) in weights.iter().zip(rows.chunks_exact(columns)).filter(|(weight, _)| **weight != 0.0)
    {
        add(*weight, row, target);
    }
}
