//! What a beam's description may say.

use super::description::{Beam, Damping};
use crate::system::{HangingMass, StructureError};
use crate::vocabulary::{self, Quantity};

/// Most modes of a beam. The 40th has 20 waves over the length: a beam 100 times as long as thick has
/// then five thicknesses per wave, beyond what Euler–Bernoulli describes.
pub const MOST_MODES: usize = 40;

pub(in crate::system) fn check(
    path: String,
    value: f64,
    quantity: &'static Quantity,
) -> Result<(), StructureError> {
    let above = quantity.min.is_none_or(|min| value > min || (value == min && !quantity.open));
    let below = quantity.max.is_none_or(|max| value < max || (value == max && !quantity.open));
    if value.is_finite() && above && below {
        Ok(())
    } else {
        Err(StructureError::OutOfBounds { path, value, quantity })
    }
}

pub(in crate::system) fn check_position(
    path: String,
    position: f64,
    length: f64,
) -> Result<(), StructureError> {
    check(path.clone(), position, &vocabulary::POSITION)?;
    if position <= length { Ok(()) } else { Err(StructureError::BeyondTheEnd { path, position, length }) }
}

pub(in crate::system) fn check_mode_count(modes: usize) -> Result<(), StructureError> {
    if (1..=MOST_MODES).contains(&modes) {
        Ok(())
    } else {
        Err(StructureError::ModeCount { modes, most: MOST_MODES })
    }
}

/// What the eigenproblem depends on.
pub(in crate::system) fn check_mechanics(beam: &Beam) -> Result<(), StructureError> {
    check("beam.length".into(), beam.length, &vocabulary::LENGTH)?;
    check("beam.width".into(), beam.width, &vocabulary::WIDTH)?;
    check("beam.thickness".into(), beam.thickness, &vocabulary::THICKNESS)?;
    check("beam.density".into(), beam.density, &vocabulary::DENSITY)?;
    check("beam.youngs_modulus".into(), beam.youngs_modulus, &vocabulary::YOUNGS_MODULUS)?;
    let tip = beam.rotational_stiffness;
    check("support.rotational_stiffness".into(), tip, &vocabulary::ROTATIONAL_STIFFNESS)?;
    if let Some(clamp) = beam.clamp_stiffness {
        check("support.clamp_stiffness".into(), clamp, &vocabulary::CLAMP_STIFFNESS)?;
    }
    for (index, point) in beam.point_masses.iter().enumerate() {
        check(format!("beam.point_mass[{index}].mass"), point.mass, &vocabulary::MASS)?;
        check_position(format!("beam.point_mass[{index}].position"), point.position, beam.length)?;
    }
    Ok(())
}

/// What the modes are evaluated at.
pub(in crate::system) fn check_attachments(beam: &Beam) -> Result<(), StructureError> {
    check("support.offset".into(), beam.offset, &vocabulary::OFFSET)?;
    check_position("excitation.position".into(), beam.excitation_position, beam.length)?;
    for (index, &position) in beam.sensors.iter().enumerate() {
        check_position(format!("sensor[{index}].position"), position, beam.length)?;
    }
    for (index, &position) in beam.contact_points.iter().enumerate() {
        check_position(format!("contact_point[{index}].position"), position, beam.length)?;
    }
    Ok(())
}

/// What hangs at the contact.
pub(in crate::system) fn check_hung(hung: &[HangingMass]) -> Result<(), StructureError> {
    hung.iter().try_for_each(|one| {
        check("effect.mass".into(), one.mass, &vocabulary::MASS)?;
        check("effect.hanging_frequency".into(), one.frequency, &vocabulary::HANGING_FREQUENCY)
    })
}

pub(in crate::system) fn check_damping(damping: &Damping, modes: usize) -> Result<(), StructureError> {
    match damping {
        Damping::Uniform(ratio) => check("beam.damping_ratio".into(), *ratio, &vocabulary::DAMPING_RATIO),
        Damping::PerMode(ratios) => {
            if ratios.len() != modes {
                return Err(StructureError::DampingRatioCount { given: ratios.len(), modes });
            }
            ratios.iter().enumerate().try_for_each(|(index, &ratio)| {
                check(format!("beam.damping_ratio[{index}]"), ratio, &vocabulary::DAMPING_RATIO)
            })
        }
        Damping::Proportional { mass, stiffness } => {
            check("beam.mass_damping".into(), *mass, &vocabulary::MASS_DAMPING)?;
            check("beam.stiffness_damping".into(), *stiffness, &vocabulary::STIFFNESS_DAMPING)
        }
    }
}
