//! The beam: exact modes, an independent finite-element solution, and the reduction to a modal beam.
//!
//! Source: "Nonlinear model identification of a frictional contact support", Mechanical Systems and
//! Signal Processing (received 2009). Eq. 1 is the beam with its contact, Eq. 2b the expansion in modes,
//! Eq. 3 the modal equations, Eq. 4 the displacement at the contact, Eq. 5 and 6 the eigenproblem.
//! The contact force here is restoring (the paper's N pulls the end outwards), and the modes are those
//! of a beam *without* the contact: its effect is all in `T`, so Eq. 3's `k_θ` term is not needed. A
//! rotational spring of the support is part of the modes.
//!
//! Limits: Euler–Bernoulli (thickness well below a wavelength, no rotary inertia, of the masses neither),
//! linear strains but for the shortening, no axial inertia.

mod changed;
pub(super) mod characteristic;
pub(super) mod checks;
mod description;
pub(super) mod finite_element;
mod krylov;
mod modal_beam;
pub(super) mod sweep;

pub use characteristic::BeamModes;
pub use checks::MOST_MODES;
pub use description::{Beam, Damping, PointMass};
pub use finite_element::FiniteElementModes;
pub use modal_beam::{ModalBeam, Sensor};

use std::f64::consts::TAU;

use super::StructureError;
use crate::vocabulary;
use characteristic::{Scales, divide};
use checks::{check, check_attachments, check_damping, check_mechanics, check_mode_count};

impl ModalBeam {
    /// Reduces a beam to its first `beam.modes` modes.
    ///
    /// With `beam.static_correction` the truncated modes follow the contact force without inertia: the
    /// rotation of the pinned end that they lack (see [`tip_rotational_compliance`]) yields in series with
    /// the contact, like the axial flexibility. Their contribution falls only with one over the number of modes.
    /// The published beam at phase resonance (Hz, five harmonics), without and with the correction:
    ///
    /// | modes | stuck, 0.5 m/s² | | 20 m/s² | | 70 m/s² | |
    /// |---|---|---|---|---|---|---|
    /// | 4 | 54.0443 | 53.7470 | 51.6363 | 51.6802 | 49.4133 | 49.4282 |
    /// | 6 | 53.9535 | 53.7468 | 51.6201 | 51.6513 | 49.4138 | 49.4243 |
    /// | 10 | 53.8903 | 53.7467 | 51.6181 | 51.6399 | 49.4152 | 49.4226 |
    /// | 20 | 53.8168 | 53.7467 | 51.6334 | 51.6439 | 49.4197 | 49.4233 |
    /// | 40 | 53.7809 | 53.7467 | 51.6385 | 51.6436 | 49.4215 | 49.4233 |
    ///
    /// In slip the inertia of the truncated modes counts too, which no static correction has.
    ///
    /// Exact up to rounding; positions may coincide with one another and with the ends. Without sensors
    /// the point masses are the sensors.
    ///
    /// # Errors
    /// Every value is checked against the vocabulary's bounds and every position against the length;
    /// see [`StructureError`].
    ///
    /// ```
    /// use stickslip::system::{Beam, Damping};
    /// let steel = Beam {
    ///     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 2e11,
    ///     modes: 4, static_correction: false, damping: Damping::Uniform(0.003), point_masses: vec![],
    ///     offset: 0.006, rotational_stiffness: 0.0, clamp_stiffness: None,
    ///     excitation_position: 0.55, sensors: vec![0.3], contact_points: vec![],
    /// };
    /// let modal = stickslip::system::ModalBeam::new(&steel).unwrap();
    /// // A bare clamped–pinned beam: ω = 3.926602² √(EI/ρA)/L².
    /// let expected = 3.926602_f64.powi(2) * (2e11_f64 * 0.005 * 0.005 / 12.0 / 7850.0).sqrt() / 0.36;
    /// assert!((modal.angular_frequency[0] / expected - 1.0).abs() < 1e-6);
    /// ```
    pub fn new(beam: &Beam) -> Result<Self, StructureError> {
        Self::linear(beam)
    }

    /// Modes and attachments, without the forces that effects add.
    fn linear(beam: &Beam) -> Result<Self, StructureError> {
        check_mode_count(beam.modes)?;
        check_mechanics(beam)?;
        check_attachments(beam)?;
        check_damping(&beam.damping, beam.modes)?;
        let modes = BeamModes::new(beam, beam.modes)?;
        let mut axial_flexibility = beam.length / (beam.youngs_modulus * beam.width * beam.thickness);
        if beam.static_correction {
            axial_flexibility += beam.offset * beam.offset * residual_compliance(beam, &modes)?;
        }
        let shape_at =
            |x| (0..beam.modes).filter_map(|mode| modes.displacement(mode, x)).collect::<Vec<f64>>();
        let sensor = |position| Sensor { position, shape: shape_at(position) };
        let sensors = if beam.sensors.is_empty() {
            beam.point_masses.iter().map(|point| sensor(point.position)).collect()
        } else {
            beam.sensors.iter().map(|&position| sensor(position)).collect()
        };
        Ok(Self {
            damping_ratio: damping_ratios(&beam.damping, modes.angular_frequency()),
            contact_shape: modes.tip_slopes().map(|slope| beam.offset * slope).collect(),
            excitation_shape: shape_at(beam.excitation_position),
            shortening: modes.shortening().to_vec(),
            axial_flexibility,
            stretching_stiffness: 0.0,
            quadratic_damping: 0.0,
            hung: Vec::new(),
            sensors,
            contact_points: beam.contact_points.iter().map(|&position| sensor(position)).collect(),
            angular_frequency: modes.angular_frequency().to_vec(),
        })
    }
}

/// The rotational stiffness at x = L (N m/rad) that gives the beam this first natural frequency (Hz).
///
/// What the paper's Table 2 reads off the measured frequencies, by Eq. 5 and 6. At a given frequency
/// the characteristic equation is linear in the stiffness, so it is solved in closed form; a count of
/// the natural frequencies below makes sure that the frequency is the first one and not another. The
/// beam's own `rotational_stiffness` plays no part.
///
/// # Errors
/// [`StructureError::FrequencyOutOfReach`] below the frequency with a free pin and from the one with a
/// clamped end upwards; values out of bounds as in [`ModalBeam::new`].
///
/// ```
/// use stickslip::system::{Beam, Damping, ModalBeam, rotational_stiffness_from_frequency};
/// # let beam = Beam {
/// #     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 2e11,
/// #     modes: 4, static_correction: false, damping: Damping::Uniform(0.003), point_masses: vec![],
/// #     offset: 0.006, rotational_stiffness: 4e3, clamp_stiffness: None,
/// #     excitation_position: 0.55, sensors: vec![0.3], contact_points: vec![],
/// # };
/// let measured = ModalBeam::new(&beam)?.angular_frequency[0] / std::f64::consts::TAU;
/// let stiffness = rotational_stiffness_from_frequency(&beam, measured)?;
/// assert!((stiffness / beam.rotational_stiffness - 1.0).abs() < 1e-9);
/// # Ok::<(), stickslip::system::StructureError>(())
/// ```
pub fn rotational_stiffness_from_frequency(beam: &Beam, frequency: f64) -> Result<f64, StructureError> {
    check_mechanics(beam)?;
    check("frequency".into(), frequency, &vocabulary::FREQUENCY)?;
    let scales = Scales::of(beam)?;
    let divided = divide(beam, &scales);
    let lowest = divided.wave_number(1, 0.0, 0.0)?;
    let highest = divided.wave_number(1, 0.0, f64::INFINITY)?;
    let wave_number = (TAU * frequency / scales.angular_frequency).sqrt();
    // The two roots carry rounding of a few units in the last place.
    if wave_number < lowest * (1.0 - 4.0 * f64::EPSILON) || wave_number >= highest {
        let hertz = |wave_number: f64| scales.angular_frequency * wave_number * wave_number / TAU;
        let (lowest, highest) = (hertz(lowest), hertz(highest));
        return Err(StructureError::FrequencyOutOfReach { frequency, lowest, highest });
    }
    let (slope, curvature) = divided.arrive(wave_number).slope_and_curvature_without_deflection();
    Ok((-curvature / slope).max(0.0) / scales.rotational_flexibility)
}

/// Rotation of the pinned end per unit of moment on it (rad/(N m)), all of the beam's modes at rest
/// frequency: `Σ φᵢ'(L)²/ωᵢ²` over infinitely many modes, L/(4EI) for a rigid clamp and a free pin.
///
/// What the kept modes lack of it is the residual flexibility that a static correction adds: modes that
/// are pinned converge slowly against a moment at the pin.
///
/// # Errors
/// Values out of bounds as in [`ModalBeam::new`].
pub fn tip_rotational_compliance(beam: &Beam) -> Result<f64, StructureError> {
    check_mechanics(beam)?;
    let scales = Scales::of(beam)?;
    let spring = beam.rotational_stiffness * scales.rotational_flexibility;
    let (slope, curvature) = divide(beam, &scales).arrive(0.0).slope_and_curvature_without_deflection();
    Ok(scales.rotational_flexibility / (curvature / slope + spring))
}

/// What the modes lack of [`tip_rotational_compliance`] (rad/(N m)); rounding may not make it negative.
fn residual_compliance(beam: &Beam, modes: &BeamModes) -> Result<f64, StructureError> {
    let kept: f64 =
        modes.tip_slopes().zip(modes.angular_frequency()).map(|(slope, omega)| (slope / omega).powi(2)).sum();
    Ok((tip_rotational_compliance(beam)? - kept).max(0.0))
}

pub(super) fn damping_ratios(damping: &Damping, angular_frequency: &[f64]) -> Vec<f64> {
    match damping {
        Damping::Uniform(ratio) => vec![*ratio; angular_frequency.len()],
        Damping::PerMode(ratios) => ratios.clone(),
        // C = a M + b K in modal coordinates: 2 ζ ω = a + b ω².
        Damping::Proportional { mass, stiffness } => {
            angular_frequency.iter().map(|omega| 0.5 * (mass / omega + stiffness * omega)).collect()
        }
    }
}
