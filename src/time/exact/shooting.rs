//! Periodic motions: Newton's method on the period map of the exact flow.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector, Schur};

use super::flow::{OscillatorFlow, OscillatorMotion, Variation};
use super::passage::Passage;
use super::system::dot;
use super::{Excitation, OscillatorError};

/// When shooting is satisfied, and when it gives up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShootingSettings {
    /// Largest change over a period, as a fraction of the largest displacement and velocity.
    pub tolerance: f64,
    /// Most periods computed, those marched between attempts included.
    pub periods: usize,
}

impl Default for ShootingSettings {
    fn default() -> Self {
        Self { tolerance: 1e-12, periods: 2000 }
    }
}

/// How far beyond the unit circle a multiplier may lie by rounding. Where nothing damps, all lie on the circle, and
/// disturbances neither grow nor die out: without this, rounding would decide.
const ON_THE_CIRCLE: f64 = 1e-8;

/// A periodic motion.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicMotion {
    /// State at the start of a period, at phase zero of the excitation.
    pub start: OscillatorMotion,
    /// What happens over the period.
    pub passage: Passage,
    /// Floquet multipliers of displacements, velocities and the sliders that slip, by falling magnitude. A
    /// slider that never slips keeps any position it is given (a multiplier of one) and is not counted.
    pub multipliers: Vec<Complex<f64>>,
    /// Whether no disturbance counted grows by more than 1e-8 of itself in a period, which can be distinguished
    /// from rounding.
    pub stable: bool,
    /// Largest change over a period, as a fraction of the largest displacement and velocity.
    pub mismatch: f64,
    /// Periods computed.
    pub periods: usize,
}

/// The motion of `flow` that has the period of `excitation`.
///
/// Newton's method on the period map with its exact derivative, the product of the flows of all regimes
/// passed. Unknowns are displacements, velocities and the positions of sliders that slip; a slider that
/// does not keeps the position to which a contact without history would be loaded at its displacement of the
/// largest magnitude. Where Newton's method does not settle, periods are marched before the next attempt.
///
/// # Errors
/// An excitation without period, illegal numbers, no periodic motion within the periods allowed.
///
/// ```
/// use stickslip::contact::Jenkins;
/// use stickslip::system::{LinearStructure, Output};
/// use stickslip::time::{Excitation, LoadedContact, OscillatorFlow, ShootingSettings, shoot};
/// let row = vec![(0, 1.0)];
/// let structure = LinearStructure {
///     size: 1,
///     mass: vec![(0, 0, 1.0)],
///     damping: vec![(0, 0, 0.02)],
///     stiffness: vec![(0, 0, 1.0)],
///     contacts: vec![row.clone()],
///     excitation: row.clone(),
///     outputs: vec![Output { name: "mass".into(), row }],
/// };
/// let law = Jenkins::new(2.0, 0.3)?;
/// let mut flow = OscillatorFlow::new(&structure, &[LoadedContact { law: &law, normal_load: 1.0 }])?;
/// let excitation = Excitation::cosine(0.9, 1.0);
/// let found = shoot(&mut flow, &excitation, None, &ShootingSettings::default())?;
/// // What comes in over a period is lost in it.
/// let lost = found.passage.total_dissipated_energy() + found.passage.viscous_energy;
/// assert!(found.stable && (lost / found.passage.work - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn shoot(
    flow: &mut OscillatorFlow,
    excitation: &Excitation,
    start: Option<&OscillatorMotion>,
    settings: &ShootingSettings,
) -> Result<PeriodicMotion, OscillatorError> {
    excitation.check()?;
    let Excitation::Periodic { angular_frequency, .. } = excitation else {
        return Err(OscillatorError::Input { name: "excitation frequency", value: 0.0 });
    };
    let mut motion = start.cloned().unwrap_or_else(|| flow.rest());
    if motion.x.len() != flow.system.size || motion.memory.len() != flow.elements.len() {
        let (expected, found) = (flow.system.size, motion.x.len());
        return Err(OscillatorError::Length { name: "start", expected, found });
    }
    motion.time = 0.0;
    let mut shooting = Shooting {
        flow,
        excitation,
        period: TAU / angular_frequency,
        settings,
        periods: 0,
        mismatch: f64::INFINITY,
    };
    let mut marched = 8;
    loop {
        if let Some(found) = shooting.newton(motion.clone())? {
            return shooting.settle(found);
        }
        for _ in 0..marched {
            shooting.count()?;
            shooting.flow.run(&mut motion, shooting.period, excitation, None)?;
            motion.time = 0.0;
        }
        marched *= 2;
    }
}

struct Shooting<'a> {
    flow: &'a mut OscillatorFlow,
    excitation: &'a Excitation,
    period: f64,
    settings: &'a ShootingSettings,
    periods: usize,
    mismatch: f64,
}

/// A start, where a period takes it, and the derivative of the one by the other.
struct Cycle {
    motion: OscillatorMotion,
    start: Vec<f64>,
    end: Vec<f64>,
    passage: Passage,
    derivative: DMatrix<f64>,
    mismatch: f64,
}

/// Newton steps before periods are marched instead.
const ATTEMPT: usize = 25;

impl Shooting<'_> {
    fn count(&mut self) -> Result<(), OscillatorError> {
        if self.periods == self.settings.periods {
            let (iterations, mismatch) = (self.periods, self.mismatch);
            return Err(OscillatorError::NotPeriodic { iterations, mismatch });
        }
        self.periods += 1;
        Ok(())
    }

    fn numbers(&self, motion: &OscillatorMotion) -> Vec<f64> {
        [motion.x.as_slice(), &motion.v, &self.flow.sliders(motion)].concat()
    }

    fn motion(&self, numbers: &[f64]) -> OscillatorMotion {
        let n = self.flow.system.size;
        self.flow.begin(0.0, numbers[..n].to_vec(), numbers[n..2 * n].to_vec(), |k| numbers[2 * n + k])
    }

    fn cycle(&mut self, motion: OscillatorMotion) -> Result<Cycle, OscillatorError> {
        self.count()?;
        let start = self.numbers(&motion);
        let size = start.len();
        let unit = |k| (0..size).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
        let mut variation = Variation { columns: (0..size).map(unit).collect() };
        let mut moved = motion.clone();
        let passage = self.flow.run(&mut moved, self.period, self.excitation, Some(&mut variation))?;
        let end = self.numbers(&moved);
        let derivative = DMatrix::from_fn(size, size, |i, j| variation.columns[j][i]);
        let mut cycle = Cycle { motion, start, end, passage, derivative, mismatch: 0.0 };
        cycle.mismatch = self.mismatch(&cycle);
        self.mismatch = cycle.mismatch;
        Ok(cycle)
    }

    /// Largest change as a fraction of the largest number of its kind.
    fn mismatch(&self, cycle: &Cycle) -> f64 {
        let n = self.flow.system.size;
        let mut worst = 0.0_f64;
        let contact_scale = self.flow.system.contacts.iter().map(|b| dot(b, b).sqrt()).fold(0.0, f64::max);
        let size = |list: &[f64]| list.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // At an instant of the cycle the displacement may be small: the velocity then sets the scale.
        let displacement = size(&cycle.end[..n]).max(size(&cycle.end[n..2 * n]) * self.period / TAU);
        for (range, scale) in [
            (0..n, displacement),
            (n..2 * n, displacement * TAU / self.period),
            (2 * n..cycle.end.len(), displacement * contact_scale),
        ] {
            for k in range {
                let change = (cycle.end[k] - cycle.start[k]).abs();
                worst = worst.max(if scale > 0.0 { change / scale } else { change });
            }
        }
        worst
    }

    /// Places of the unknowns: all displacements and velocities, the sliders that slip.
    fn unknowns(&self, passage: &Passage) -> Vec<usize> {
        let n = self.flow.system.size;
        let slipping = passage.slipped.iter().enumerate().filter(|(_, slipped)| **slipped);
        (0..2 * n).chain(slipping.map(|(k, _)| 2 * n + k)).collect()
    }

    /// Newton's method from `motion`; `None` where it does not settle.
    fn newton(&mut self, motion: OscillatorMotion) -> Result<Option<Cycle>, OscillatorError> {
        let mut cycle = self.cycle(motion)?;
        for _ in 0..ATTEMPT {
            if cycle.mismatch <= self.settings.tolerance {
                return Ok(Some(cycle));
            }
            let places = self.unknowns(&cycle.passage);
            let size = places.len();
            let matrix = DMatrix::from_fn(size, size, |i, j| {
                f64::from(u8::from(i == j)) - cycle.derivative[(places[i], places[j])]
            });
            let miss = DVector::from_fn(size, |i, _| cycle.end[places[i]] - cycle.start[places[i]]);
            let Some(step) = matrix.lu().solve(&miss) else { return Ok(None) };
            let mut next = cycle.start.clone();
            places.iter().zip(step.iter()).for_each(|(place, step)| next[*place] += step);
            if !next.iter().all(|value| value.is_finite()) {
                return Ok(None);
            }
            let motion = self.motion(&next);
            cycle = match self.cycle(motion) {
                Ok(cycle) => cycle,
                Err(OscillatorError::Diverged { .. }) => return Ok(None),
                Err(error) => return Err(error),
            };
        }
        Ok(None)
    }

    /// Gives the sliders that do not slip the position that loading a contact without history gives them, where
    /// that is a periodic motion too.
    fn settle(&mut self, mut cycle: Cycle) -> Result<PeriodicMotion, OscillatorError> {
        let n = self.flow.system.size;
        for _ in 0..ATTEMPT {
            let mut numbers = cycle.start.clone();
            let mut moved = 0.0_f64;
            for (k, element) in self.flow.elements.iter().enumerate() {
                if !cycle.passage.slipped[k] {
                    let (low, high) = cycle.passage.contact_range[element.contact];
                    let farthest = if high.abs() >= low.abs() { high } else { low };
                    let (_, position) = element.slider.step(0.0, farthest);
                    moved = moved
                        .max((numbers[2 * n + k] - position).abs() / (high - low).max(f64::MIN_POSITIVE));
                    numbers[2 * n + k] = position;
                }
            }
            if moved <= self.settings.tolerance {
                break;
            }
            let motion = self.motion(&numbers);
            match self.newton(motion)? {
                Some(next) if next.passage.slipped == cycle.passage.slipped => cycle = next,
                _ => break,
            }
        }
        let places = self.unknowns(&cycle.passage);
        let monodromy =
            DMatrix::from_fn(places.len(), places.len(), |i, j| cycle.derivative[(places[i], places[j])]);
        let multipliers = multipliers(monodromy);
        let stable = multipliers.as_ref().is_some_and(|m| m.iter().all(|m| m.norm() <= 1.0 + ON_THE_CIRCLE));
        Ok(PeriodicMotion {
            start: cycle.motion,
            passage: cycle.passage,
            multipliers: multipliers.unwrap_or_default(),
            stable,
            mismatch: cycle.mismatch,
            periods: self.periods,
        })
    }
}

/// Eigenvalues by falling magnitude; `None` where they cannot be computed.
pub(crate) fn multipliers(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if matrix.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let mut all = Schur::try_new(matrix, f64::EPSILON, 10_000)?.complex_eigenvalues().as_slice().to_vec();
    all.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    Some(all)
}
