//! A beam as an engineer describes it; [`ModalBeam::new`](crate::system::ModalBeam::new) makes its modes.

/// `[beam]` with its masses, support and excitation. Clamped at x = 0, pinned at x = length.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// Length (m).
    pub length: f64,
    /// Width (m).
    pub width: f64,
    /// Thickness in the direction of bending (m).
    pub thickness: f64,
    /// Density (kg/m³).
    pub density: f64,
    /// Young's modulus (Pa).
    pub youngs_modulus: f64,
    /// Number of modes kept.
    pub modes: usize,
    /// Whether a static correction stands for the flexibility of the modes left out against a moment at
    /// the pin, `[beam] static_correction`; false when absent.
    pub static_correction: bool,
    /// Damping of the modes.
    pub damping: Damping,
    /// Masses fixed to the beam.
    pub point_masses: Vec<PointMass>,
    /// Distance of the contact's line of action from the neutral axis (m), `[support] offset`.
    pub offset: f64,
    /// Rotational spring at x = length (N m/rad), `[support] rotational_stiffness`; 0 when absent.
    pub rotational_stiffness: f64,
    /// Rotational spring that replaces the clamp at x = 0 (N m/rad), `[support] clamp_stiffness`;
    /// `None` is a rigid clamp.
    pub clamp_stiffness: Option<f64>,
    /// Where the excitation acts (m from the clamp), `[excitation] position`.
    pub excitation_position: f64,
    /// Positions of sensors (m): `[[sensor]] position`; the point masses' positions when absent.
    pub sensors: Vec<f64>,
    /// Where contacts besides the support push across the beam (m): `[[contact_point]] position`. Their forces come
    /// from outside, in a co-simulation; elsewhere the beam is free there.
    pub contact_points: Vec<f64>,
}

/// A mass at a position of the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMass {
    /// Distance from the clamp (m).
    pub position: f64,
    /// Mass (kg).
    pub mass: f64,
}

/// Modal damping.
#[derive(Debug, Clone, PartialEq)]
pub enum Damping {
    /// `damping_ratio = 0.003`: the same ratio for every mode.
    Uniform(f64),
    /// `damping_ratio = [0.003, 0.004, ...]`, one per mode.
    PerMode(Vec<f64>),
    /// `mass_damping` (1/s) and `stiffness_damping` (s): C = a M + b K.
    Proportional {
        /// a (1/s).
        mass: f64,
        /// b (s).
        stiffness: f64,
    },
}
