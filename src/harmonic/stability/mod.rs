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
//! - The modal beam (`beam`), whose contact turns with the motion: the same, whatever the law.
//!
//! A slider that never slips keeps any position; that neutral direction is not counted.

mod balancing;
mod beam;
mod feedback;
mod history;
mod regimes;
mod signal;
mod tangents;

use nalgebra::Complex;

use crate::contact::Slider;
use crate::integrate::oscillator::multipliers;
use crate::integrate::oscillator::system::System;
use crate::integrate::{LoadedContact, OscillatorError};
use crate::structure::{LinearStructure, ModalBeam};
use beam::Bent;
use feedback::Linear;

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
    let motion = Motion { structure, contacts, displacement, angular_frequency };
    Ok(Multipliers { values: motion.multipliers(&mut |_| false)? })
}

/// Multipliers of the periodic motion of `beam` at `angular_frequency` (rad/s) whose modes move by the Fourier
/// coefficients `modes` (m √kg), `[a0, c1, s1, …]` mode after mode, and whose contact, if it has one, by
/// `displacement` (m): what the beam's axial flexibility leaves of the displacement.
///
/// ```
/// use stickslip::harmonic::stability::floquet_of_beam;
/// use stickslip::structure::ModalBeam;
/// let beam = ModalBeam {
///     angular_frequency: vec![330.0],
///     damping_ratio: vec![0.003],
///     contact_shape: vec![0.057],
///     excitation_shape: vec![1.2],
///     shortening: vec![20.0],
///     axial_flexibility: 1.5e-8,
///     stretching_stiffness: 0.0,
///     quadratic_damping: 0.0,
///     sensors: vec![],
///     contact_points: vec![],
/// };
/// let multipliers = floquet_of_beam(&beam, None, &[0.0, 1e-3, 0.0], &[], 300.0)?;
/// let decay = (-0.003 * 330.0 * std::f64::consts::TAU / 300.0_f64).exp();
/// assert!((multipliers.values[0].norm() - decay).abs() < 1e-9);
/// # Ok::<(), stickslip::integrate::OscillatorError>(())
/// ```
///
/// # Errors
/// Lists that do not fit the beam, numbers that are not finite, a map that does not settle.
pub fn floquet_of_beam(
    beam: &ModalBeam,
    contact: Option<LoadedContact>,
    modes: &[f64],
    displacement: &[f64],
    angular_frequency: f64,
) -> Result<Multipliers, OscillatorError> {
    let bent = bent(beam, contact, modes, displacement, angular_frequency)?;
    Ok(Multipliers { values: tangents::multipliers_of(&bent, &mut |_| false)? })
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
    let motion = Motion { structure, contacts, displacement, angular_frequency };
    verdict(|enough| motion.multipliers(enough))
}

/// Whether the motion that [`floquet_of_beam`] describes is stable; `None` where the multipliers cannot be told.
pub fn beam_is_stable(
    beam: &ModalBeam,
    contact: Option<LoadedContact>,
    modes: &[f64],
    displacement: &[f64],
    angular_frequency: f64,
) -> Option<bool> {
    let bent = bent(beam, contact, modes, displacement, angular_frequency).ok()?;
    verdict(|enough| tangents::multipliers_of(&bent, enough))
}

/// Tells whether multipliers are good enough.
type Enough<'e> = dyn FnMut(&[Complex<f64>]) -> bool + 'e;

/// Whether all multipliers are stable, made no better than it takes to tell.
fn verdict(found: impl FnOnce(&mut Enough) -> Result<Vec<Complex<f64>>, OscillatorError>) -> Option<bool> {
    /// Change of the largest multiplier from one map to a better one, as share of its distance from the unit circle.
    const CLEAR: f64 = 0.1;
    let mut last = f64::NAN;
    let mut clear = |found: &[Complex<f64>]| {
        let largest = found.first().map_or(0.0, |first| first.norm());
        let change = (largest - std::mem::replace(&mut last, largest)).abs();
        change <= CLEAR * (largest - 1.0).abs()
    };
    found(&mut clear).ok().map(|values| Multipliers { values }.stable())
}

/// A periodic motion of a linear structure.
struct Motion<'a> {
    structure: &'a LinearStructure,
    contacts: &'a [LoadedContact<'a>],
    displacement: &'a [&'a [f64]],
    angular_frequency: f64,
}

impl Motion<'_> {
    fn multipliers(&self, enough: &mut Enough) -> Result<Vec<Complex<f64>>, OscillatorError> {
        let Self { structure, contacts, displacement, angular_frequency } = *self;
        let system = &System::new(structure)?;
        let expected = system.contacts.len();
        for (name, found) in [("contacts", contacts.len()), ("displacement", displacement.len())] {
            if found != expected {
                return Err(OscillatorError::Length { name, expected, found });
            }
        }
        displacement.iter().try_for_each(|coefficients| check("displacement", coefficients))?;
        check_frequency(angular_frequency)?;
        let mut sliders: Vec<Slider> = Vec::new();
        if contacts.iter().all(|contact| contact.law.sliders(contact.normal_load, &mut sliders)) {
            let map = regimes::monodromy(system, contacts, displacement, angular_frequency)?;
            let diverged = OscillatorError::Diverged { time: std::f64::consts::TAU / angular_frequency };
            return multipliers(map).ok_or(diverged);
        }
        tangents::multipliers_of(&Linear { system, contacts, displacement, angular_frequency }, enough)
    }
}

/// A periodic motion of a beam.
fn bent<'a>(
    beam: &'a ModalBeam,
    contact: Option<LoadedContact<'a>>,
    modes: &'a [f64],
    displacement: &'a [f64],
    angular_frequency: f64,
) -> Result<Bent<'a>, OscillatorError> {
    check_frequency(angular_frequency)?;
    check("modes", modes)?;
    if contact.is_some() {
        check("displacement", displacement)?;
    }
    let expected = beam.angular_frequency.len();
    let lists = [
        ("damping_ratio", beam.damping_ratio.len(), expected),
        ("contact_shape", beam.contact_shape.len(), expected),
        ("excitation_shape", beam.excitation_shape.len(), expected),
        ("shortening", beam.shortening.len(), expected * expected),
        ("modes", modes.len() % expected.max(1), 0),
    ];
    if let Some((name, found, expected)) = lists.into_iter().find(|(_, found, expected)| found != expected) {
        return Err(OscillatorError::Length { name, expected, found });
    }
    let width = (modes.len() / expected.max(1)).max(1);
    Bent::new(beam, contact, modes.chunks_exact(width).collect(), displacement, angular_frequency)
}

fn check(name: &'static str, coefficients: &[f64]) -> Result<(), OscillatorError> {
    if coefficients.is_empty() {
        return Err(OscillatorError::Length { name, expected: 1, found: 0 });
    }
    match coefficients.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(OscillatorError::Input { name, value: *value }),
        None => Ok(()),
    }
}

fn check_frequency(value: f64) -> Result<(), OscillatorError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(OscillatorError::Input { name: "angular_frequency", value })
}
