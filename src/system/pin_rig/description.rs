//! The rig as an engineer describes it.

use crate::system::beam::checks::{
    check, check_attachments, check_damping, check_mechanics, check_mode_count,
};
use crate::system::{Beam, StructureError};
use crate::vocabulary as v;

/// Standard acceleration of free fall as the paper's preload has it: 68.67 N of 7 kg (m/s²).
pub(super) const GRAVITY: f64 = 9.81;

/// A beam with a pin at its free end, pressed on its support by a mass on a string.
///
/// Of the [`Beam`] the offset is the tangential lever r of the contact; its rotational spring, static correction and
/// contact points play no part.
///
/// ```
/// use stickslip::system::{Beam, Damping, HangingString, Pin, PinRig, PinRigModes, PointMass};
/// let beam = Beam {
///     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 2e11,
///     modes: 8, static_correction: false, damping: Damping::Uniform(0.003),
///     point_masses: vec![PointMass { position: 0.55, mass: 0.025 }],
///     offset: 0.006, rotational_stiffness: 0.0, clamp_stiffness: None,
///     excitation_position: 0.55, sensors: vec![], contact_points: vec![],
/// };
/// let rig = PinRig {
///     pin: Pin::solid(0.006, beam.width, 7850.0),
///     string: HangingString { stiffness: 1e6, length: 0.3, mass: 7.0, inertia: 0.0 },
///     stuck_stiffness: [3.95e6, 2.37e7],
///     beam,
/// };
/// assert!((rig.preload() - 68.67).abs() < 1e-9);
/// let modes = PinRigModes::new(&rig, 8)?;
/// // The pendulum and the mass that bounces on its string are modes, too, but not the beam's.
/// assert!(modes.beam_modes().len() < 8);
/// # Ok::<(), stickslip::system::StructureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PinRig {
    /// The beam, with its masses, excitation, sensors and damping.
    pub beam: Beam,
    /// The pin.
    pub pin: Pin,
    /// String and hanging mass.
    pub string: HangingString,
    /// Tangential and normal stiffness (N/m) of the contact in the base linear system, of which the modes are those.
    pub stuck_stiffness: [f64; 2],
}

/// The pin at the end of the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pin {
    /// Mass m_p (kg).
    pub mass: f64,
    /// Moment of inertia J_p about its own axis (kg m²).
    pub inertia: f64,
    /// Distance of the pin's axis, over the line of the normal force, from the end of the beam (m).
    pub normal_lever: f64,
}

/// The string with the mass that hangs from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HangingString {
    /// Axial stiffness k_s (N/m).
    pub stiffness: f64,
    /// Length l_s (m).
    pub length: f64,
    /// Mass m_s (kg).
    pub mass: f64,
    /// Moment of inertia J_s of the mass about its own axis (kg m²).
    pub inertia: f64,
}

impl Pin {
    /// A solid round pin of `radius`, `length` (m) and `density` (kg/m³), its lever the radius.
    pub fn solid(radius: f64, length: f64, density: f64) -> Self {
        let mass = density * std::f64::consts::PI * radius * radius * length;
        Self { mass, inertia: 0.5 * mass * radius * radius, normal_lever: radius }
    }
}

impl HangingString {
    /// Weight of the hanging mass (N).
    pub fn weight(&self) -> f64 {
        self.mass * GRAVITY
    }
}

impl PinRig {
    /// Weight of the hanging mass (N): what presses the pin on its support at rest.
    pub fn preload(&self) -> f64 {
        self.string.weight()
    }

    pub(super) fn check(&self, modes: usize) -> Result<(), StructureError> {
        check_mode_count(modes)?;
        check_mechanics(&self.beam)?;
        check_attachments(&self.beam)?;
        check_damping(&self.beam.damping, self.beam.modes)?;
        let Self { pin, string, stuck_stiffness: [tangential, normal], .. } = self;
        check("pin.mass".into(), pin.mass, &v::MASS)?;
        check("pin.inertia".into(), pin.inertia, &v::INERTIA)?;
        check("pin.normal_lever".into(), pin.normal_lever, &v::NORMAL_LEVER)?;
        check("string.stiffness".into(), string.stiffness, &v::STRING_STIFFNESS)?;
        check("string.length".into(), string.length, &v::STRING_LENGTH)?;
        check("string.mass".into(), string.mass, &v::MASS)?;
        check("string.inertia".into(), string.inertia, &v::INERTIA)?;
        check("contact.tangential_stiffness".into(), *tangential, &v::STIFFNESS)?;
        check("contact.normal_stiffness".into(), *normal, &v::NORMAL_STIFFNESS)
    }
}
