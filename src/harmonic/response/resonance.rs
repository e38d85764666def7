//! Phase resonance under response control, and backbones.

use super::tracker::Solution;
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::modal::{Balance, guess};
use crate::harmonic::newton::problem::{Condition, ConditionRow, Newton, Seen};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::harmonic::{CurveSettings, HarmonicError};
use crate::system::System;

/// Fraction of an amplitude from which it is followed where Newton's method fails at once, and the smallest step (factor).
const WEAK: f64 = 1e-3;
const SMALLEST_STEP: f64 = 1.001;

/// A periodic response at phase resonance: the excitation `F cos Ωt` is in phase with the first
/// harmonic of the velocity where it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct Resonance {
    /// Ω (rad/s).
    pub angular_frequency: f64,
    /// F (N).
    pub force_amplitude: f64,
    /// First-harmonic amplitude of the acceleration at the excitation (m/s²), as held.
    pub acceleration_amplitude: f64,
    /// Modal coordinates (m √kg): `[a0, c1, s1, …, cH, sH]` per mode; behind them those of the masses of resonators, as
    /// [`System::expanded`] has them.
    pub coefficients: Vec<f64>,
    /// Contact displacement `c·q − ½ qᵀG q` before the series spring gives way to all that pulls there (m), harmonics `0..=2H`.
    pub contact_displacement: Vec<f64>,
    /// Restoring contact force (N), harmonics `0..=2H`.
    pub contact_force: Vec<f64>,
    /// Energy the contact takes per cycle (J).
    pub dissipated_energy: f64,
    /// Energy that the damping of modes and resonators, and drag, take per cycle (J).
    pub viscous_energy: f64,
}

impl Resonance {
    /// Equivalent viscous damping ratio (1): energy lost per cycle over 4π times the kinetic energy's peak,
    /// `ΔE/(2π Ω² Σ |qᵢ|²)` in first harmonics. For a linear mode its modal damping ratio.
    pub fn damping_ratio(&self) -> f64 {
        // Displacements have 2H + 1 coefficients per mode where the contact has 4H + 1.
        let per_mode = self.contact_displacement.len() / 2 + 1;
        let squares: f64 = self.coefficients.chunks_exact(per_mode).map(|q| q[1] * q[1] + q[2] * q[2]).sum();
        let lost = self.dissipated_energy + self.viscous_energy;
        lost / (std::f64::consts::TAU * self.angular_frequency.powi(2) * squares)
    }
}

/// Phase resonance of the first mode of a system in modal coordinates with the first-harmonic acceleration at the excitation held
/// at `acceleration_amplitude` (m/s²): harmonics of the modes, frequency and force are the unknowns.
/// Without a contact, or with one that never slips, this is the resonance of the linear system.
/// Of `settings` it takes `harmonics`, `method`, `tolerance` and `max_iterations`.
///
/// `start`, a solution nearby (another level, or other parameters), saves Newton steps; the result does
/// not depend on it where the response is unique.
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit; the other kinds when no solution was
/// found even by following it from small amplitudes.
///
/// ```
/// use stickslip::harmonic::{CurveSettings, phase_resonance};
/// use stickslip::system::{Beam, Damping, ModalBeam};
/// # let beam = Beam {
/// #     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 2e11,
/// #     modes: 4, static_correction: false, damping: Damping::Uniform(0.003), point_masses: vec![],
/// #     offset: 0.006, rotational_stiffness: 0.0, clamp_stiffness: None,
/// #     excitation_position: 0.55, sensors: vec![0.3], contact_points: vec![],
/// # };
/// let beam = ModalBeam::new(&beam)?;
/// let resonance = phase_resonance(&beam.system(None)?, 1.0, &CurveSettings::default(), None)?;
/// assert!((resonance.angular_frequency / beam.angular_frequency[0] - 1.0).abs() < 1e-3);
/// assert!((resonance.damping_ratio() / 0.003 - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn phase_resonance(
    system: &System,
    acceleration_amplitude: f64,
    settings: &CurveSettings,
    start: Option<&Resonance>,
) -> Result<Resonance, HarmonicError> {
    Solver::new(system, settings)?.solve(acceleration_amplitude, start)
}

/// [`phase_resonance`] at every amplitude (m/s²), in the caller's order. `starts` are earlier results
/// for the same amplitudes (with other parameters), or empty; then each level starts from the ones below.
///
/// # Errors
/// Those of the first level, from below, that fails.
///
/// ```
/// use std::sync::Arc;
/// use stickslip::contact::{ContactLaw, Jenkins};
/// use stickslip::harmonic::{CurveSettings, backbone};
/// use stickslip::system::{Beam, Damping, ModalBeam};
/// # let beam = Beam {
/// #     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 2e11,
/// #     modes: 4, static_correction: false, damping: Damping::Uniform(0.003), point_masses: vec![],
/// #     offset: 0.006, rotational_stiffness: 0.0, clamp_stiffness: None,
/// #     excitation_position: 0.55, sensors: vec![0.3], contact_points: vec![],
/// # };
/// let law: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(7.9e6, 0.3)?);
/// let system = ModalBeam::new(&beam)?.system(Some((law, 150.0)))?;
/// let points = backbone(&system, &[1.0, 100.0], &CurveSettings::default(), &[])?;
/// // It sticks, then slips: slip lowers the frequency and damps.
/// assert!(points[1].angular_frequency < points[0].angular_frequency);
/// assert!(points[1].damping_ratio() > points[0].damping_ratio());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn backbone(
    system: &System,
    acceleration_amplitudes: &[f64],
    settings: &CurveSettings,
    starts: &[Resonance],
) -> Result<Vec<Resonance>, HarmonicError> {
    if !(starts.is_empty() || starts.len() == acceleration_amplitudes.len()) {
        return Err(HarmonicError::InvalidInput("the starts are not one per amplitude"));
    }
    let mut solver = Solver::new(system, settings)?;
    let mut order: Vec<usize> = (0..acceleration_amplitudes.len()).collect();
    order.sort_by(|a, b| acceleration_amplitudes[*a].total_cmp(&acceleration_amplitudes[*b]));
    let mut results: Vec<Option<Resonance>> = vec![None; order.len()];
    let mut below: Option<usize> = None;
    for &level in &order {
        let start = starts.get(level).or(below.and_then(|index| results[index].as_ref()));
        let result = solver.solve(acceleration_amplitudes[level], start)?;
        results[level] = Some(result);
        below = Some(level);
    }
    Ok(results.into_iter().flatten().collect())
}

/// Responses at phase resonance: the displacement's first harmonic at the excitation is `a/Ω² sin Ωt`, a
/// quarter period behind the force. Ω and F are free.
struct Solver {
    balance: Balance,
    newton: Newton,
    settings: CurveSettings,
}

impl Solver {
    fn new(system: &System, settings: &CurveSettings) -> Result<Self, HarmonicError> {
        settings.check()?;
        let balance = Balance::new(&Assembly::new(system.clone()), settings.harmonics, settings.method)?;
        if balance.system.driven.iter().all(|phi| *phi == 0.0) {
            return Err(HarmonicError::InvalidInput("the excitation moves no mode"));
        }
        Ok(Self { balance, newton: Newton::default(), settings: *settings })
    }

    fn solve(&mut self, acceleration: f64, start: Option<&Resonance>) -> Result<Resonance, HarmonicError> {
        if !(acceleration > 0.0 && acceleration.is_finite()) {
            return Err(HarmonicError::InvalidInput("the acceleration amplitude must be positive"));
        }
        let Solution { at, .. } = self.find(acceleration, start)?;
        let balance = &self.balance;
        Ok(Resonance {
            angular_frequency: at.angular_frequency,
            force_amplitude: at.level,
            acceleration_amplitude: acceleration,
            coefficients: balance.expanded_coefficients(&at),
            contact_displacement: balance.displacement().to_vec(),
            contact_force: balance.force().to_vec(),
            dissipated_energy: balance.dissipated_energy(),
            viscous_energy: balance.viscous_energy(at.angular_frequency),
        })
    }

    /// From `start` if that is close enough, else from equivalent linearisation, else followed from a small amplitude.
    fn find(&mut self, acceleration: f64, start: Option<&Resonance>) -> Result<Solution, HarmonicError> {
        if let Some(mut solution) = start.and_then(|start| self.scaled(start, acceleration))
            && self.settle(acceleration, &mut solution).is_ok()
        {
            return Ok(solution);
        }
        let mut solution = self.guess(acceleration)?;
        if self.settle(acceleration, &mut solution).is_ok() {
            return Ok(solution);
        }
        let mut reached = WEAK * acceleration;
        solution = self.guess(reached)?;
        self.settle(reached, &mut solution)?;
        let mut step: f64 = 1.5;
        while reached < acceleration {
            let next = (reached * step).min(acceleration);
            let mut trial = solution.clone();
            trial.x.iter_mut().for_each(|x| *x *= next / reached);
            trial.at.level *= next / reached;
            match self.settle(next, &mut trial) {
                Ok(()) => {
                    (solution, reached) = (trial, next);
                    step = step.powf(1.5).min(2.0);
                }
                Err(error) if step < SMALLEST_STEP => return Err(error),
                Err(_) => step = step.sqrt(),
            }
        }
        Ok(solution)
    }

    /// A response at another amplitude, as if all were linear; `None` where it has other coefficients.
    fn scaled(&mut self, start: &Resonance, acceleration: f64) -> Option<Solution> {
        let balance = &mut self.balance;
        if start.coefficients.len() != balance.expanded_len() {
            return None;
        }
        let ratio = acceleration / start.acceleration_amplitude;
        let of_modes = &start.coefficients[..balance.q.len()];
        let scaled: Vec<f64> = of_modes.iter().map(|q| ratio * q).collect();
        let force: Vec<f64> = start.contact_force.iter().map(|force| ratio * force).collect();
        let x = balance.unknowns_of(&scaled, &force, start.angular_frequency);
        Some(Solution { x, at: Operating::forced(start.angular_frequency, ratio * start.force_amplitude) })
    }

    fn guess(&mut self, acceleration: f64) -> Result<Solution, HarmonicError> {
        self.balance.forget();
        let (frequency, force) = guess::resonance(&mut self.balance, acceleration)?;
        Ok(Solution { x: self.balance.start(frequency), at: Operating::forced(frequency, force) })
    }

    /// Newton's method from `solution`.
    fn settle(&mut self, acceleration: f64, solution: &mut Solution) -> Result<(), HarmonicError> {
        let Self { balance, newton, settings } = self;
        balance.forget();
        let node = balance.nodes() - 1;
        let mut cosine = InQuadrature { node, part: 0, acceleration };
        let mut sine = InQuadrature { node, part: 1, acceleration };
        let conditions: &mut [&mut dyn Condition] = &mut [&mut cosine, &mut sine];
        let free = [Scalar::AngularFrequency, Scalar::Level];
        let Solution { x, at } = solution;
        newton.solve(balance, x, at, &free, conditions, &settings.stopping()).map(drop)
    }
}

/// One part of `X₁ = a/Ω² sin Ωt`. Linear in the displacement, unlike amplitude and phase.
struct InQuadrature {
    node: usize,
    /// 0 for the cosine, 1 for the sine.
    part: usize,
    acceleration: f64,
}

impl Condition for InQuadrature {
    fn evaluate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        _x: &[f64],
        at: &Operating,
        row: &mut ConditionRow,
    ) -> f64 {
        let factor = at.angular_frequency * at.angular_frequency / self.acceleration;
        let value = factor * system.output(self.node, 1)[self.part];
        let mut weights = [0.0; 2];
        weights[self.part] = factor;
        row.seen.push(Seen { node: self.node, order: 1, weights });
        row.by_scalars[Scalar::AngularFrequency.index()] += 2.0 * value / at.angular_frequency;
        value - self.part as f64
    }
}
