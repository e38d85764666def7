//! What a beam must be for its balance to have a meaning.

use crate::harmonic::HarmonicError;
use crate::system::ModalBeam;

/// Refuses lists that do not fit and numbers that make no sense.
pub(super) fn check_beam(beam: &ModalBeam) -> Result<(), HarmonicError> {
    let modes = beam.angular_frequency.len();
    if modes == 0 {
        return Err(HarmonicError::InvalidInput("the beam has no modes"));
    }
    if beam.string_stiffness != 0.0 && beam.string_stretch.len() != modes {
        return Err(HarmonicError::InvalidInput("the string's stretch does not have one entry per mode"));
    }
    let same_length = [&beam.damping_ratio, &beam.contact_shape, &beam.excitation_shape];
    if same_length.iter().any(|v| v.len() != modes) || beam.shortening.len() != modes * modes {
        return Err(HarmonicError::InvalidInput("the beam's arrays do not have one entry per mode"));
    }
    let all =
        same_length.iter().flat_map(|v| v.iter()).chain(&beam.angular_frequency).chain(&beam.shortening);
    if all
        .chain(&beam.string_stretch)
        .chain([&beam.axial_flexibility, &beam.string_stiffness])
        .any(|x| !x.is_finite())
    {
        return Err(HarmonicError::InvalidInput("the beam has a value that is not finite"));
    }
    if beam.angular_frequency.iter().any(|w| *w <= 0.0) || beam.axial_flexibility < 0.0 {
        return Err(HarmonicError::InvalidInput(
            "a natural frequency or the axial flexibility is not positive",
        ));
    }
    Ok(())
}
