//! Periodic response to a periodic excitation.

use super::follow::{Family, State, find};
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::modal::Balance;
use crate::harmonic::newton::problem::{Effort, Newton, Stopping};
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::harmonic::{HarmonicError, Settings};
use crate::numeric::fourier::{coefficient_count, time_derivative, value};
use crate::system::System;

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
    /// Largest residual of the balance as a fraction of the largest force.
    pub residual: f64,
}

impl ForcedResponse {
    /// Coefficients of the displacement (m) of a point where the modes have the values `shape`
    /// (`φᵢ(x)`, kg^-1/2), e.g. of a [`crate::system::Sensor`].
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

/// Response of a system in modal coordinates to the force with the Fourier coefficients `excitation` (N; `[a0, c1, s1, …]`,
/// at most the harmonics of `settings`) and the fundamental period `period` (s).
///
/// `start`, a solution nearby, saves Newton steps. Without it the search starts from equivalent
/// linearisation, and follows the solution from a small excitation where that fails.
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit; the other kinds when no solution was
/// found.
pub fn forced_response(
    system: &System,
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
    settings.check()?;
    let assembly = Assembly { waveform: excitation.to_vec(), ..Assembly::new(system.clone()) };
    let mut balance = Balance::new(&assembly, settings.harmonics, settings.method)?;
    let at = Operating::forced(std::f64::consts::TAU / period, 1.0);
    let start = start.filter(|s| s.coefficients.len() == balance.q.len()).map(|start| {
        let x = balance.unknowns_of(&start.coefficients, &start.contact_force);
        State { x, at }
    });
    let mut family = Forced { angular_frequency: at.angular_frequency };
    let (_, effort) = find(&mut family, &mut balance, 1.0, start, settings)?;
    Ok(ForcedResponse {
        angular_frequency: at.angular_frequency,
        contact_displacement: balance.displacement().to_vec(),
        contact_force: balance.force().to_vec(),
        dissipated_energy: balance.dissipated_energy(),
        viscous_energy: balance.viscous_energy(at.angular_frequency),
        coefficients: balance.modal_coefficients(),
        iterations: effort.iterations,
        residual: effort.residual,
    })
}

/// Responses to a fraction of the excitation.
pub(crate) struct Forced {
    pub angular_frequency: f64,
}

impl Family for Forced {
    fn solve(
        &mut self,
        balance: &mut Balance,
        newton: &mut Newton,
        amount: f64,
        state: &mut State,
        stopping: &Stopping,
    ) -> Result<Effort, HarmonicError> {
        state.at = Operating::forced(self.angular_frequency, amount);
        newton.solve(balance, &mut state.x, &mut state.at, &[], &mut [], stopping)
    }

    fn guess(&mut self, balance: &mut Balance, amount: f64) -> Result<State, HarmonicError> {
        let at = Operating::forced(self.angular_frequency, amount);
        let mut x = vec![0.0; balance.unknowns()];
        balance.guess(&at, &mut x)?;
        Ok(State { x, at })
    }
}
