//! Euler–Bernoulli beam, clamped (or on a rotational spring) at x = 0, pinned at x = L, with point masses.
//!
//! # Reference
//! "Nonlinear model identification of a frictional contact support", Mechanical Systems and Signal
//! Processing (received 2009): eq. 5 and 6 (linear modes with a rotational spring), appendix A (their
//! orthogonality), eq. 4 (shortening). The modes kept are those without the contact.

mod characteristic;
mod finite_element;
mod segment;

pub use finite_element::finite_element_frequencies;

use std::f64::consts::TAU;

use characteristic::{Assembly, Mode};

use super::{ModalBeam, Sensor, StructureError};
use crate::model::{Beam, Damping};
use crate::vocabulary as v;

/// Rotational springs are searched up to this many times the beam's own bending stiffness 4EI/L: far
/// beyond, frequencies no longer change.
const STIFFEST: f64 = 1e6;

impl ModalBeam {
    /// Reduces `beam` to its first `beam.modes` modes, exactly (no spatial discretisation).
    ///
    /// Signs are fixed by a positive slope at x = L, so that [`ModalBeam::contact_shape`] is positive for a
    /// positive offset.
    ///
    /// # Errors
    /// [`StructureError`] names what is out of bounds.
    ///
    /// ```
    /// use stickslip::model::{Beam, Damping};
    /// use stickslip::structure::ModalBeam;
    /// let beam = Beam {
    ///     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 197e9,
    ///     modes: 3, damping: Damping::Uniform(0.003), point_masses: vec![], offset: 0.006,
    ///     rotational_stiffness: 0.0, clamp_stiffness: None, excitation_position: 0.55, sensors: vec![],
    /// };
    /// let modal = ModalBeam::new(&beam)?;
    /// assert_eq!(modal.angular_frequency.len(), 3);
    /// # Ok::<(), stickslip::structure::StructureError>(())
    /// ```
    pub fn new(beam: &Beam) -> Result<Self, StructureError> {
        check(beam)?;
        let assembly = Assembly::new(beam, &[]);
        let modes: Vec<Mode> =
            assembly.natural_frequencies(beam.modes).into_iter().map(|omega| assembly.mode(omega)).collect();
        let angular_frequency: Vec<f64> = modes.iter().map(|mode| mode.omega).collect();
        let values = |x: f64| modes.iter().map(|mode| mode.at(x).0).collect::<Vec<f64>>();
        Ok(Self {
            damping_ratio: damping_ratios(&beam.damping, &angular_frequency),
            contact_shape: modes.iter().map(|mode| beam.offset * mode.at(beam.length).1).collect(),
            excitation_shape: values(beam.excitation_position),
            shortening: shortening(&assembly, &modes),
            axial_flexibility: beam.length / (beam.youngs_modulus * beam.width * beam.thickness),
            sensors: beam
                .sensors
                .iter()
                .map(|&position| Sensor { position, shape: values(position) })
                .collect(),
            angular_frequency,
        })
    }
}

/// The first `count` natural frequencies (Hz) of `beam` by the characteristic equation.
///
/// # Errors
/// [`StructureError`] names what is out of bounds.
pub fn characteristic_frequencies(beam: &Beam, count: usize) -> Result<Vec<f64>, StructureError> {
    check(beam)?;
    Ok(Assembly::new(beam, &[]).natural_frequencies(count).into_iter().map(|omega| omega / TAU).collect())
}

/// The rotational spring at x = L (N m/rad) with which the first natural frequency of `beam` is `frequency`
/// (Hz); the beam's own `rotational_stiffness` is ignored.
///
/// # Errors
/// [`StructureError::FrequencyOutOfReach`] when no spring gives this frequency.
pub fn rotational_stiffness_from_frequency(beam: &Beam, frequency: f64) -> Result<f64, StructureError> {
    check(beam)?;
    let below = |stiffness: f64| {
        let trial = Beam { rotational_stiffness: stiffness, ..beam.clone() };
        Assembly::new(&trial, &[]).count_below(TAU * frequency) > 0
    };
    let own = beam.youngs_modulus * beam.width * beam.thickness.powi(3) / (3.0 * beam.length);
    let (mut low, mut high) = (0.0, STIFFEST * own);
    if !(frequency > 0.0 && below(low) && !below(high)) {
        let softest = Beam { rotational_stiffness: low, ..beam.clone() };
        let stiffest = Beam { rotational_stiffness: high, ..beam.clone() };
        return Err(StructureError::FrequencyOutOfReach {
            frequency,
            lowest: characteristic_frequencies(&softest, 1)?[0],
            highest: characteristic_frequencies(&stiffest, 1)?[0],
        });
    }
    // The frequency rises with the spring: bisect the spring on the count of frequencies below.
    while high - low > 1e-12 * own.max(high) {
        let middle = 0.5 * (low + high);
        if below(middle) { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

/// Gᵢⱼ = ∫ φᵢ' φⱼ' dx, row-major.
fn shortening(assembly: &Assembly, modes: &[Mode]) -> Vec<f64> {
    let count = modes.len();
    let mut matrix = vec![0.0; count * count];
    let Some(highest) = modes.last() else { return matrix };
    for (x, weight) in assembly.quadrature(highest.omega) {
        let slopes: Vec<f64> = modes.iter().map(|mode| mode.at(x).1).collect();
        for row in 0..count {
            for column in 0..=row {
                matrix[row * count + column] += weight * slopes[row] * slopes[column];
            }
        }
    }
    for (row, column) in (0..count).flat_map(|row| (0..row).map(move |column| (row, column))) {
        matrix[column * count + row] = matrix[row * count + column];
    }
    matrix
}

fn damping_ratios(damping: &Damping, angular_frequency: &[f64]) -> Vec<f64> {
    match damping {
        Damping::Uniform(ratio) => vec![*ratio; angular_frequency.len()],
        Damping::PerMode(ratios) => ratios.clone(),
        Damping::Proportional { mass, stiffness } => {
            angular_frequency.iter().map(|omega| 0.5 * (mass / omega + stiffness * omega)).collect()
        }
    }
}

/// Models read from files are checked already; this one may have been made in code.
fn check(beam: &Beam) -> Result<(), StructureError> {
    let positive = [
        (&v::LENGTH, beam.length),
        (&v::WIDTH, beam.width),
        (&v::THICKNESS, beam.thickness),
        (&v::DENSITY, beam.density),
        (&v::YOUNGS_MODULUS, beam.youngs_modulus),
    ];
    let masses = beam.point_masses.iter().map(|mass| (&v::MASS, mass.mass));
    let clamp = beam.clamp_stiffness.iter().map(|stiffness| (&v::CLAMP_STIFFNESS, *stiffness));
    for (quantity, value) in positive.into_iter().chain(masses).chain(clamp) {
        if !(value > 0.0 && value.is_finite()) {
            return Err(StructureError::OutOfBounds {
                name: quantity.name,
                value,
                wanted: "finite and above zero",
            });
        }
    }
    if !(beam.rotational_stiffness >= 0.0 && beam.rotational_stiffness.is_finite()) {
        let (name, value) = (v::ROTATIONAL_STIFFNESS.name, beam.rotational_stiffness);
        return Err(StructureError::OutOfBounds { name, value, wanted: "finite and zero or more" });
    }
    if !beam.offset.is_finite() {
        return Err(StructureError::OutOfBounds {
            name: v::OFFSET.name,
            value: beam.offset,
            wanted: "finite",
        });
    }
    let masses = beam.point_masses.iter().map(|mass| mass.position);
    for position in masses.chain(beam.sensors.iter().copied()).chain([beam.excitation_position]) {
        if !(0.0..=beam.length).contains(&position) {
            return Err(StructureError::OutOfBounds {
                name: v::POSITION.name,
                value: position,
                wanted: "on the beam, from 0 to its length",
            });
        }
    }
    let most = v::MODES.max.unwrap_or(f64::MAX);
    if beam.modes == 0 || beam.modes as f64 > most {
        return Err(StructureError::OutOfBounds {
            name: v::MODES.name,
            value: beam.modes as f64,
            wanted: "from 1 to 40",
        });
    }
    match &beam.damping {
        Damping::PerMode(ratios) if ratios.len() != beam.modes => {
            Err(StructureError::DampingRatios { given: ratios.len(), modes: beam.modes })
        }
        _ => Ok(()),
    }
}
