//! The contact force that makes the linear beam move as measured: receptances inverted.
//!
//! All modes of the description take part, and what they lack follows statically, so that the force acts on the beam's
//! residual flexibility, too. The force along the beam also acts on its slope; that product is taken with the motion of
//! the last round. On the pin rig the contact acts in two directions, and what the hanging mass pulls by the beam's shortening
//! is taken with that motion, too.
//!
//! `structure` is what the contact acts on and `springs` what its modes have too much; `motion` says what comes in and `found` what
//! goes out; `bending` is one record's structure, `joint` all records with the unknowns that they share.

mod bending;
mod found;
mod joint;
mod motion;
mod springs;
mod structure;
#[cfg(test)]
pub(super) mod tests;

use super::IdentificationError;
use crate::system::{ModalBeam, ModalPinRig};
pub(super) use bending::Bending;
pub use found::{ContactPeriod, Inversion};
use joint::Joint;
pub use motion::{Doubts, SteadyMotion};
pub(super) use structure::Structure;

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
    invert_until(&beam.into(), motions, harmonics, doubts, &|| false)
}

/// As [`invert`], of both forces at the end of a rig whose contact slips and slaps; its springs in place of the contact are
/// taken off, so that their stiffness plays no part.
///
/// # Errors
/// As [`invert`].
pub fn invert_slip_slap(
    rig: &ModalPinRig,
    motions: &[SteadyMotion],
    harmonics: usize,
    doubts: &Doubts,
) -> Result<Inversion, IdentificationError> {
    invert_until(&rig.into(), motions, harmonics, doubts, &|| false)
}

/// As [`invert`], ended as soon as `interrupted` says so.
pub(super) fn invert_until(
    structure: &Structure,
    motions: &[SteadyMotion],
    harmonics: usize,
    doubts: &Doubts,
    interrupted: &dyn Fn() -> bool,
) -> Result<Inversion, IdentificationError> {
    let records: Vec<Bending> =
        motions.iter().map(|motion| Bending::new(structure, motion, harmonics)).collect::<Result<_, _>>()?;
    if records.is_empty() {
        return Err(IdentificationError::Failed("there is no steady record".to_owned()));
    }
    // Before the motion is known roughly, no fault of the measuring chain explains what it does not.
    let certain = Doubts { excitation_gain: 0.0, sensor_gain: 0.0, sensor_mass: 0.0, ..*doubts };
    let mut joint = Joint::new(records, &certain);
    joint.settle(interrupted)?;
    joint.spreads = doubts.spreads(structure.sensors.len());
    let solved = joint.settle(interrupted)?;
    Ok(joint.told(&solved))
}
