//! Phase resonance under response control, and backbones.

use nalgebra::DMatrix;

use super::balance::Balance;
use super::newton::{self, Effort, Equations};
use super::{ContactOnBeam, HarmonicError, Settings, guess};
use crate::structure::ModalBeam;

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
    /// Modal coordinates (m √kg): `[a0, c1, s1, …, cH, sH]` per mode.
    pub coefficients: Vec<f64>,
    /// Contact displacement `c·q − ½ qᵀG q` before the series spring gives way (m), harmonics `0..=2H`.
    pub contact_displacement: Vec<f64>,
    /// Restoring contact force (N), harmonics `0..=2H`.
    pub contact_force: Vec<f64>,
    /// Energy the contact takes per cycle (J).
    pub dissipated_energy: f64,
    /// Energy the modal damping takes per cycle (J).
    pub viscous_energy: f64,
    /// Newton steps of the last solve.
    pub iterations: usize,
    /// Largest residual of the balance as share of the largest force.
    pub residual: f64,
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

/// Phase resonance of the beam's first mode with the first-harmonic acceleration at the excitation held
/// at `acceleration_amplitude` (m/s²): harmonics of the modes, frequency and force are the unknowns.
/// Without a contact, or with one that never slips, this is the resonance of the linear beam.
///
/// `start`, a solution nearby (another level, or other parameters), saves Newton steps; the result does
/// not depend on it where the response is unique.
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit; the other kinds when no solution was
/// found even by following it from small amplitudes.
pub fn phase_resonance(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    acceleration_amplitude: f64,
    settings: &Settings,
    start: Option<&Resonance>,
) -> Result<Resonance, HarmonicError> {
    Solver::new(beam, contact, settings)?.solve(acceleration_amplitude, start)
}

/// [`phase_resonance`] at every amplitude (m/s²), in the caller's order. `starts` are earlier results
/// for the same amplitudes (with other parameters), or empty; then each level starts from the ones below.
///
/// # Errors
/// Those of the first level, from below, that fails.
pub fn backbone(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    acceleration_amplitudes: &[f64],
    settings: &Settings,
    starts: &[Resonance],
) -> Result<Vec<Resonance>, HarmonicError> {
    if !(starts.is_empty() || starts.len() == acceleration_amplitudes.len()) {
        return Err(HarmonicError::InvalidInput("the starts are not one per amplitude"));
    }
    let mut solver = Solver::new(beam, contact, settings)?;
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

struct Solver<'a> {
    equations: PhaseResonance<'a>,
    settings: Settings,
}

impl<'a> Solver<'a> {
    fn new(
        beam: &'a ModalBeam,
        contact: Option<ContactOnBeam<'a>>,
        settings: &Settings,
    ) -> Result<Self, HarmonicError> {
        let balance = Balance::new(beam, contact, settings)?;
        let largest = beam.excitation_shape.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if largest == 0.0 {
            return Err(HarmonicError::InvalidInput("the excitation moves no mode"));
        }
        let lowest = beam.angular_frequency.iter().copied().fold(f64::INFINITY, f64::min);
        let size = balance.unknowns + 2;
        let equations = PhaseResonance {
            balance,
            acceleration: 0.0,
            condition_scale: lowest * lowest / largest,
            residual: vec![0.0; size],
            jacobian: DMatrix::zeros(size, size),
        };
        Ok(Self { equations, settings: *settings })
    }

    fn solve(&mut self, acceleration: f64, start: Option<&Resonance>) -> Result<Resonance, HarmonicError> {
        if !(acceleration > 0.0 && acceleration.is_finite()) {
            return Err(HarmonicError::InvalidInput("the acceleration amplitude must be positive"));
        }
        let unknowns = self.equations.balance.unknowns;
        if let Some(start) = start.filter(|s| s.coefficients.len() == unknowns) {
            let ratio = acceleration / start.acceleration_amplitude;
            let mut x: Vec<f64> = start.coefficients.iter().map(|q| ratio * q).collect();
            x.extend([start.angular_frequency, ratio * start.force_amplitude]);
            if let Ok(effort) = self.attempt(acceleration, &mut x) {
                return Ok(self.result(&x, effort));
            }
        }
        let mut x = self.guess(acceleration)?;
        match self.attempt(acceleration, &mut x) {
            Ok(effort) => Ok(self.result(&x, effort)),
            Err(_) => self.follow(acceleration),
        }
    }

    fn guess(&mut self, acceleration: f64) -> Result<Vec<f64>, HarmonicError> {
        let (mut x, frequency, force) = guess::resonance(&mut self.equations.balance, acceleration)?;
        x.extend([frequency, force]);
        Ok(x)
    }

    fn attempt(&mut self, acceleration: f64, x: &mut [f64]) -> Result<Effort, HarmonicError> {
        self.equations.acceleration = acceleration;
        self.equations.balance.forget();
        newton::solve(&mut self.equations, x, &self.settings)
    }

    /// Follows the solution from a small amplitude up, with steps that halve on failure.
    fn follow(&mut self, acceleration: f64) -> Result<Resonance, HarmonicError> {
        const SMALLEST_STEP: f64 = 1.002;
        let mut amplitude = 1e-3 * acceleration;
        let mut x = self.guess(amplitude)?;
        let mut effort = self.attempt(amplitude, &mut x)?;
        let mut step: f64 = 1.5;
        while amplitude < acceleration {
            let next = (amplitude * step).min(acceleration);
            let mut trial = x.clone();
            let ratio = next / amplitude;
            let unknowns = self.equations.balance.unknowns;
            trial[..unknowns].iter_mut().for_each(|q| *q *= ratio);
            trial[unknowns + 1] *= ratio;
            match self.attempt(next, &mut trial) {
                Ok(done) => {
                    (x, amplitude, effort) = (trial, next, done);
                    step = step.powf(1.5).min(2.0);
                }
                Err(error) if step < SMALLEST_STEP => return Err(error),
                Err(_) => step = step.sqrt(),
            }
        }
        Ok(self.result(&x, effort))
    }

    fn result(&self, x: &[f64], effort: Effort) -> Resonance {
        let balance = &self.equations.balance;
        let (q, rest) = x.split_at(balance.unknowns);
        Resonance {
            angular_frequency: rest[0],
            force_amplitude: rest[1],
            acceleration_amplitude: self.equations.acceleration,
            coefficients: q.to_vec(),
            contact_displacement: balance.displacement.clone(),
            contact_force: balance.force().to_vec(),
            dissipated_energy: balance.dissipated_energy(),
            viscous_energy: balance.viscous_energy(q, rest[0]),
            iterations: effort.iterations,
            residual: effort.residual,
        }
    }
}

/// Unknowns: coefficients, Ω, F. The last two equations hold the displacement's first harmonic at the
/// excitation at `a/Ω² sin Ωt`, a quarter period behind the force.
struct PhaseResonance<'a> {
    balance: Balance<'a>,
    acceleration: f64,
    /// Brings the two conditions to the size of the balance's forces.
    condition_scale: f64,
    residual: Vec<f64>,
    jacobian: DMatrix<f64>,
}

impl Equations for PhaseResonance<'_> {
    fn evaluate(&mut self, x: &[f64]) -> Result<f64, HarmonicError> {
        let n = self.balance.unknowns;
        let count = self.balance.count;
        let (frequency, force) = (x[n], x[n + 1]);
        let scale = self.balance.evaluate(&x[..n], frequency)?;
        self.residual[..n].copy_from_slice(&self.balance.residual);
        self.jacobian.fill(0.0);
        self.jacobian.view_mut((0, 0), (n, n)).copy_from(&self.balance.jacobian);
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (i, shape) in self.balance.beam.excitation_shape.iter().enumerate() {
            let (c, s) = (i * count + 1, i * count + 2);
            self.residual[c] -= force * shape;
            self.jacobian[(c, n + 1)] = -shape;
            cosine += shape * x[c];
            sine += shape * x[s];
            self.jacobian[(n, c)] = self.condition_scale * shape;
            self.jacobian[(n + 1, s)] = self.condition_scale * shape;
        }
        self.jacobian.view_mut((0, n), (n, 1)).copy_from_slice(&self.balance.by_frequency);
        let amplitude = self.acceleration / (frequency * frequency);
        self.residual[n] = self.condition_scale * cosine;
        self.residual[n + 1] = self.condition_scale * (sine - amplitude);
        self.jacobian[(n + 1, n)] = self.condition_scale * 2.0 * amplitude / frequency;
        Ok(scale)
    }

    fn residual(&self) -> &[f64] {
        &self.residual
    }

    fn jacobian(&self) -> &DMatrix<f64> {
        &self.jacobian
    }

    fn longest_step(&self, x: &[f64], step: &[f64]) -> f64 {
        let n = self.balance.unknowns;
        (0.2 * x[n] / step[n].abs()).min(1.0)
    }
}
