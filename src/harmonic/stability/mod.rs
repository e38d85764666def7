//! Whether a periodic response lasts: Floquet multipliers of the variational equation along it.
//!
//! A small disturbance δq of a periodic motion obeys `M δq̈ + C δq̇ + K δq + Σ Bᵢᵀ δTᵢ = 0`, where δTᵢ is
//! what the contact answers to `δuᵢ = Bᵢ δq` and to what its memory was disturbed by. The eigenvalues of
//! the map over one period are the multipliers; the motion is stable where all are smaller than one.
//!
//! - Piecewise-linear laws (`regimes`): the displacement tells which slider sticks when; each regime is
//!   a linear system, solved to rounding. Sliders remember the displacement of their last reversal, so that a
//!   disturbance of memory has one component per turning point, whatever the number of sliders.
//! - Any other law (`tangents`): the tangents of its steps on a grid that meets all turning points,
//!   the structure exactly between two, extrapolated (Romberg) until the map settles.
//!
//! A slider that never slips keeps any position; that neutral direction is not counted.

mod regimes;
mod signal;
mod tangents;

use nalgebra::{Complex, DMatrix};

use crate::contact::Slider;
use crate::integrate::oscillator::multipliers;
use crate::integrate::oscillator::system::System;
use crate::integrate::{LoadedContact, OscillatorError};
use crate::structure::LinearStructure;

/// Most degrees of freedom for which [`is_stable`] answers.
const LARGEST: usize = 60;

/// How far beyond the unit circle a multiplier may lie by rounding, that of the map and the root of it that is left
/// of two multipliers that fall together. Where nothing damps, all lie on the circle, and disturbances neither grow
/// nor die out: without this, rounding would decide.
const ON_THE_CIRCLE: f64 = 1e-8;

/// Floquet multipliers of a periodic motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipliers {
    /// The multipliers, by falling magnitude. Zeros of directions that are forgotten at once are among them.
    pub values: Vec<Complex<f64>>,
}

impl Multipliers {
    /// Whether no disturbance grows: by more than 1e-8 of itself in a period, which is what can be told from
    /// rounding.
    pub fn stable(&self) -> bool {
        self.values.iter().all(|multiplier| multiplier.norm() <= 1.0 + ON_THE_CIRCLE)
    }

    /// `Π (μᵢ − 1)` over all multipliers: zero where a periodic solution turns round or branches, of the sign
    /// `(−1)^n` of n multipliers where all are stable. Smooth along a curve, where single multipliers are not.
    pub fn fold_function(&self) -> f64 {
        self.values.iter().map(|multiplier| multiplier - 1.0).product::<Complex<f64>>().re
    }
}

/// Multipliers of the periodic motion of `structure` at `angular_frequency` (rad/s) whose contacts move by
/// the Fourier coefficients `displacement` (m), `[a0, c1, s1, …]` per contact in the structure's order.
///
/// # Errors
/// Lists that do not fit the structure, numbers that are not finite, a map that does not settle.
pub fn floquet(
    structure: &LinearStructure,
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
    angular_frequency: f64,
) -> Result<Multipliers, OscillatorError> {
    let system = System::new(structure)?;
    let expected = system.contacts.len();
    for (name, found) in [("contacts", contacts.len()), ("displacement", displacement.len())] {
        if found != expected {
            return Err(OscillatorError::Length { name, expected, found });
        }
    }
    for coefficients in displacement {
        if coefficients.is_empty() {
            return Err(OscillatorError::Length { name: "displacement", expected: 1, found: 0 });
        }
        if let Some(value) = coefficients.iter().find(|value| !value.is_finite()) {
            return Err(OscillatorError::Input { name: "displacement", value: *value });
        }
    }
    if !(angular_frequency > 0.0 && angular_frequency.is_finite()) {
        return Err(OscillatorError::Input { name: "angular_frequency", value: angular_frequency });
    }
    let mut sliders: Vec<Slider> = Vec::new();
    let linear_pieces = contacts.iter().all(|contact| contact.law.sliders(contact.normal_load, &mut sliders));
    let monodromy = if linear_pieces {
        regimes::monodromy(&system, contacts, displacement, angular_frequency)?
    } else {
        tangents::monodromy(&system, contacts, displacement, angular_frequency)?
    };
    let values = multipliers(monodromy)
        .ok_or(OscillatorError::Diverged { time: std::f64::consts::TAU / angular_frequency })?;
    Ok(Multipliers { values })
}

/// Whether the motion that [`floquet`] describes is stable; `None` for structures of more than 60 degrees of
/// freedom and where the multipliers cannot be told.
pub fn is_stable(
    structure: &LinearStructure,
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
    angular_frequency: f64,
) -> Option<bool> {
    if structure.size > LARGEST {
        return None;
    }
    floquet(structure, contacts, displacement, angular_frequency).ok().map(|multipliers| multipliers.stable())
}

/// Disturbances of displacement and velocity as columns of a square matrix with `memory` more rows.
fn unit_columns(size: usize) -> Vec<Vec<f64>> {
    (0..size).map(|k| (0..size).map(|i| if i == k { 1.0 } else { 0.0 }).collect()).collect()
}

fn as_matrix(columns: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(columns.len(), columns.len(), |i, j| columns[j][i])
}
