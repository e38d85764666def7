//! The contact force that makes the linear beam move as measured: receptances inverted.
//!
//! All modes of the description take part, and what they lack follows statically, so that the force acts on the beam's
//! residual flexibility, too. The force along the beam also acts on its slope; that product is taken with the motion of
//! the last round.

mod bending;
mod joint;
#[cfg(test)]
pub(super) mod tests;

use nalgebra::DMatrix;

use super::IdentificationError;
use crate::system::ModalBeam;
pub(super) use bending::Bending;
use joint::Joint;

/// What was measured in a steady state, by its harmonics.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyMotion {
    /// Fundamental (rad/s).
    pub angular_frequency: f64,
    /// Coefficients `[a0, c1, s1, …]` of the excitation (N).
    pub excitation: Vec<f64>,
    /// Of the acceleration at each of the beam's sensors (m/s²), as many harmonics each; means are not read.
    pub accelerations: Vec<Vec<f64>>,
    /// Standard error of each of these.
    pub errors: Vec<Vec<f64>>,
}

/// What is thought of the measuring chain beforehand: standard deviations, 0 for what is certain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubts {
    /// Of the load cell's gain (1).
    pub excitation_gain: f64,
    /// Of each accelerometer's gain (1).
    pub sensor_gain: f64,
    /// Of the mass at each sensor (kg).
    pub sensor_mass: f64,
    /// Of each coefficient of the contact's force (N): what keeps at zero what the records do not tell.
    pub force: f64,
}

/// The contact over a period of each record, and the measuring chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Inversion {
    /// In the order of the records.
    pub periods: Vec<ContactPeriod>,
    /// Logarithm of what the load cell shows over what there is (1), and its standard error.
    pub excitation_gain: [f64; 2],
    /// The same of every accelerometer.
    pub sensor_gains: Vec<[f64; 2]>,
    /// Mass at every sensor beyond that of the beam's description (kg), and its standard error.
    pub sensor_masses: Vec<[f64; 2]>,
    /// Largest over smallest singular value of the weighted equations.
    pub conditioning: f64,
    /// Root mean square of what remains, over what the errors let expect.
    pub misfit: f64,
}

/// The contact over a period.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPeriod {
    /// Fundamental (rad/s).
    pub angular_frequency: f64,
    /// Coefficients of the restoring force (N).
    pub force: Vec<f64>,
    /// Their covariance (N²), all doubts included.
    pub covariance: DMatrix<f64>,
    /// Coefficients of the contact's own displacement (m), the flexibility in series taken off.
    pub displacement: Vec<f64>,
    /// Their covariance (m²), all doubts included.
    pub displacement_covariance: DMatrix<f64>,
    /// Covariance of each of these (rows) with each coefficient of the force (m N).
    pub cross_covariance: DMatrix<f64>,
    /// Of its velocity (m/s).
    pub velocity: Vec<f64>,
    /// Modal coordinates (m √kg), mode after mode.
    pub modes: Vec<Vec<f64>>,
    /// Accelerations that the force does not explain, as a fraction of the measured ones.
    pub unexplained: f64,
}

/// Finds the force at the end of `beam`, with `harmonics` of it, that explains each of `motions`, and what of the measuring
/// chain must be otherwise than said for that.
///
/// The mean force moves no accelerometer but by what it changes of the bending stiffness. Gains and masses are the same in
/// all records, so that records of several levels tell them from the force.
///
/// # Errors
/// No record; channels that are not those of the beam's sensors; equations without a solution.
pub fn invert(
    beam: &ModalBeam,
    motions: &[SteadyMotion],
    harmonics: usize,
    doubts: &Doubts,
) -> Result<Inversion, IdentificationError> {
    invert_until(beam, motions, harmonics, doubts, &|| false)
}

/// As [`invert`], ended as soon as `interrupted` says so.
pub(super) fn invert_until(
    beam: &ModalBeam,
    motions: &[SteadyMotion],
    harmonics: usize,
    doubts: &Doubts,
    interrupted: &dyn Fn() -> bool,
) -> Result<Inversion, IdentificationError> {
    let records: Vec<Bending> =
        motions.iter().map(|motion| Bending::new(beam, motion, harmonics)).collect::<Result<_, _>>()?;
    if records.is_empty() {
        return Err(IdentificationError("there is no steady record".to_owned()));
    }
    // Before the motion is known roughly, no fault of the measuring chain explains what it does not.
    let certain = Doubts { excitation_gain: 0.0, sensor_gain: 0.0, sensor_mass: 0.0, ..*doubts };
    let mut joint = Joint::new(records, harmonics, &certain);
    joint.settle(interrupted)?;
    joint.spreads = doubts.spreads(beam.sensors.len());
    let solved = joint.settle(interrupted)?;
    Ok(joint.told(&solved))
}
