//! Structures as the contact sees them: modal mass, damping, stiffness and the map to the contact.

mod beam;

pub use beam::{characteristic_frequencies, finite_element_frequencies, rotational_stiffness_from_frequency};

/// Why a structure could not be reduced.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StructureError {
    /// A value that makes no physical sense.
    #[error("`{name}` = {value} must be {wanted}")]
    OutOfBounds {
        /// Name of the quantity, as in model files.
        name: &'static str,
        /// The value, SI.
        value: f64,
        /// What would be legal.
        wanted: &'static str,
    },
    /// As many damping ratios as modes are needed.
    #[error("`damping_ratio` has {given} entries, but there are {modes} modes")]
    DampingRatios {
        /// Entries given.
        given: usize,
        /// Modes kept.
        modes: usize,
    },
    /// No rotational spring gives the frequency asked for.
    #[error(
        "no rotational spring gives {frequency} Hz; from none to rigid the beam has {lowest:.3} to {highest:.3} Hz"
    )]
    FrequencyOutOfReach {
        /// The frequency asked for (Hz).
        frequency: f64,
        /// Without a spring (Hz).
        lowest: f64,
        /// With a rigid one (Hz).
        highest: f64,
    },
    /// The mass matrix is not positive definite.
    #[error("the mass matrix is singular")]
    Singular,
}

/// A beam reduced to mass-normalised modes with a contact at its end.
///
/// `q̈ᵢ + 2 ζᵢ ωᵢ q̇ᵢ + ωᵢ² qᵢ + T [cᵢ − Σⱼ Gᵢⱼ qⱼ] = f φᵢ(S)` and, at the contact,
/// `u = Σ cᵢ qᵢ − ½ qᵀ G q − T · axial_flexibility` with `cᵢ = r φᵢ'(L)`.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalBeam {
    /// ωᵢ (rad/s), ascending.
    pub angular_frequency: Vec<f64>,
    /// ζᵢ (1).
    pub damping_ratio: Vec<f64>,
    /// cᵢ = r φᵢ'(L) (kg^-1/2).
    pub contact_shape: Vec<f64>,
    /// φᵢ(S) (kg^-1/2).
    pub excitation_shape: Vec<f64>,
    /// Gᵢⱼ = ∫ φᵢ' φⱼ' dx (1/(kg m)), row-major, symmetric.
    pub shortening: Vec<f64>,
    /// L/(E A) (m/N).
    pub axial_flexibility: f64,
    /// Sensors.
    pub sensors: Vec<Sensor>,
}

/// A sensor on a [`ModalBeam`].
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Distance from the clamp (m).
    pub position: f64,
    /// φᵢ(position) (kg^-1/2).
    pub shape: Vec<f64>,
}
