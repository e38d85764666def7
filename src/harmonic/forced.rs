//! Periodic response to a periodic excitation.

use nalgebra::DMatrix;

use super::balance::Balance;
use super::fourier::{coefficient_count, time_derivative, value};
use super::newton::{self, Effort, Equations};
use super::{ContactOnBeam, HarmonicError, Settings, guess};
use crate::structure::ModalBeam;

/// The periodic response to a periodic excitation.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcedResponse {
    /// Fundamental angular frequency (rad/s).
    pub angular_frequency: f64,
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

impl ForcedResponse {
    /// Coefficients of the displacement (m) of a point where the modes have the values `shape`
    /// (`φᵢ(x)`, kg^-1/2), e.g. of a [`crate::structure::Sensor`].
    pub fn displacement(&self, shape: &[f64]) -> Vec<f64> {
        let count = self.coefficients.len() / shape.len().max(1);
        let mut sum = vec![0.0; count];
        for (phi, q) in shape.iter().zip(self.coefficients.chunks_exact(count.max(1))) {
            sum.iter_mut().zip(q).for_each(|(s, q)| *s += phi * q);
        }
        sum
    }

    /// Time derivative of order `order` of that displacement (m/s^order) at `times` (s), where t = 0 is
    /// phase 0 of the excitation.
    pub fn motion(&self, shape: &[f64], order: usize, times: &[f64]) -> Vec<f64> {
        let motion = time_derivative(&self.displacement(shape), order, self.angular_frequency);
        times.iter().map(|t| value(&motion, self.angular_frequency * t)).collect()
    }

    /// Acceleration (m/s²) of that point at `times` (s).
    pub fn acceleration(&self, shape: &[f64], times: &[f64]) -> Vec<f64> {
        self.motion(shape, 2, times)
    }
}

/// Response of the beam to the force with the Fourier coefficients `excitation` (N; `[a0, c1, s1, …]`,
/// at most the harmonics of `settings`) and the fundamental period `period` (s).
///
/// `start`, a solution nearby, saves Newton steps. Without it the search starts from equivalent
/// linearisation, and follows the solution from a small excitation where that fails.
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit; the other kinds when no solution was
/// found.
pub fn forced_response(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    period: f64,
    excitation: &[f64],
    settings: &Settings,
    start: Option<&ForcedResponse>,
) -> Result<ForcedResponse, HarmonicError> {
    if !(period > 0.0 && period.is_finite()) || excitation.iter().any(|f| !f.is_finite()) {
        return Err(HarmonicError::InvalidInput(
            "the period and the excitation must be finite, the period positive",
        ));
    }
    if excitation.len() > coefficient_count(settings.harmonics) {
        return Err(HarmonicError::InvalidInput(
            "the excitation has more harmonics than the response may have",
        ));
    }
    let balance = Balance::new(beam, contact, settings)?;
    let mut equations = Forced {
        angular_frequency: std::f64::consts::TAU / period,
        residual: vec![0.0; balance.unknowns],
        balance,
        excitation,
        level: 1.0,
    };
    let unknowns = equations.balance.unknowns;
    if let Some(start) = start.filter(|s| s.coefficients.len() == unknowns) {
        let mut x = start.coefficients.clone();
        if let Ok(effort) = equations.attempt(1.0, &mut x, settings) {
            return Ok(equations.result(x, effort));
        }
    }
    let mut x = guess::forced(&mut equations.balance, equations.angular_frequency, excitation)?;
    match equations.attempt(1.0, &mut x, settings) {
        Ok(effort) => Ok(equations.result(x, effort)),
        Err(_) => equations.follow(settings),
    }
}

struct Forced<'a> {
    balance: Balance<'a>,
    angular_frequency: f64,
    excitation: &'a [f64],
    /// Share of the excitation applied.
    level: f64,
    residual: Vec<f64>,
}

impl Forced<'_> {
    fn attempt(&mut self, level: f64, x: &mut [f64], settings: &Settings) -> Result<Effort, HarmonicError> {
        self.level = level;
        self.balance.forget();
        newton::solve(self, x, settings)
    }

    /// Follows the solution from a small excitation up, with steps that halve on failure.
    fn follow(&mut self, settings: &Settings) -> Result<ForcedResponse, HarmonicError> {
        const SMALLEST_STEP: f64 = 1.001;
        let mut level = 1e-3;
        let weak: Vec<f64> = self.excitation.iter().map(|f| level * f).collect();
        let mut x = guess::forced(&mut self.balance, self.angular_frequency, &weak)?;
        let mut effort = self.attempt(level, &mut x, settings)?;
        let mut step: f64 = 1.5;
        while level < 1.0 {
            let next = (level * step).min(1.0);
            let mut trial: Vec<f64> = x.iter().map(|q| q * next / level).collect();
            match self.attempt(next, &mut trial, settings) {
                Ok(done) => {
                    (x, level, effort) = (trial, next, done);
                    step = step.powf(1.5).min(2.0);
                }
                Err(error) if step < SMALLEST_STEP => return Err(error),
                Err(_) => step = step.sqrt(),
            }
        }
        Ok(self.result(x, effort))
    }

    fn result(&self, x: Vec<f64>, effort: Effort) -> ForcedResponse {
        ForcedResponse {
            angular_frequency: self.angular_frequency,
            contact_displacement: self.balance.displacement.clone(),
            contact_force: self.balance.force().to_vec(),
            dissipated_energy: self.balance.dissipated_energy(),
            viscous_energy: self.balance.viscous_energy(&x, self.angular_frequency),
            coefficients: x,
            iterations: effort.iterations,
            residual: effort.residual,
        }
    }
}

impl Equations for Forced<'_> {
    fn evaluate(&mut self, x: &[f64]) -> Result<f64, HarmonicError> {
        let mut scale = self.balance.evaluate(x, self.angular_frequency)?;
        self.residual.copy_from_slice(&self.balance.residual);
        for (i, shape) in self.balance.beam.excitation_shape.iter().enumerate() {
            let start = i * self.balance.count;
            for (r, f) in self.residual[start..].iter_mut().zip(self.excitation) {
                let force = self.level * f * shape;
                *r -= force;
                scale = scale.max(force.abs());
            }
        }
        Ok(scale)
    }

    fn residual(&self) -> &[f64] {
        &self.residual
    }

    fn jacobian(&self) -> &DMatrix<f64> {
        &self.balance.jacobian
    }

    fn longest_step(&self, _x: &[f64], _step: &[f64]) -> f64 {
        1.0
    }
}
