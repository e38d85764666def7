//! Structures as the contact sees them: modal mass, damping, stiffness and the map to the contact.
//!
//! [`ModalBeam::new`] reduces a [`Beam`] to its exact modes;
//! [`rotational_stiffness_from_frequency`] reads the support's stiffness off a measured frequency.

pub mod beam;
mod changes;
mod error;
mod linear;
mod oscillator;
mod ports;
#[cfg(feature = "analysis")]
mod receptance;

pub use beam::{Beam, Damping, PointMass, rotational_stiffness_from_frequency, tip_rotational_compliance};
pub use changes::{HangingMass, Place, StructureChanges};
pub use error::StructureError;
pub use linear::{Entries, LinearStructure, MOST_DENSE_MODES, NaturalModes, Output, Row};
pub use oscillator::{Anchor, Mass, Oscillator, Spring};
pub use ports::{Core, Element, Port, System};
#[cfg(feature = "analysis")]
pub use receptance::{Compliance, Method, Receptance, Rows};

/// A beam reduced to mass-normalised modes with a contact at its end.
///
/// `q̈ᵢ + 2 ζᵢ ωᵢ q̇ᵢ + ωᵢ² qᵢ + T [cᵢ − Σⱼ Gᵢⱼ qⱼ] = f φᵢ(S)` and, at the contact,
/// `u = Σ cᵢ qᵢ − ½ qᵀ G q − T · axial_flexibility` with `cᵢ = r φᵢ'(L)`.
///
/// Effects add to the left-hand side of mode i stretching of the mid-plane, `κ e Σⱼ Gᵢⱼ qⱼ` with `e = qᵀ G q`, what the
/// shortening does to the string of a hanging mass, `− k (y Σⱼ Gᵢⱼ qⱼ + ½ e sᵢ)` with `y = Σ sᵢ qᵢ`, and
/// drag at the excitation, `d |ẏ| ẏ φᵢ(S)` with `y = Σ φᵢ(S) qᵢ`; see [`ModalBeam::with_changes`].
///
/// Every mode has a positive slope at the contact, so `contact_shape` has the sign of the offset.
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
    /// Flexibility in series with the contact (m/N): L/(E A), with the static correction also
    /// r² times the rotational compliance that the modes lack.
    pub axial_flexibility: f64,
    /// κ (N/m): stretching, the derivative of the potential `κ/4 (qᵀ G q)²`; 0 for none.
    pub stretching_stiffness: f64,
    /// k (N/m): of the string, the derivative of the potential `− k y ½ qᵀ G q`; 0 for none.
    pub string_stiffness: f64,
    /// sᵢ (kg^-1/2): by how much each mode stretches the string; empty for none.
    pub string_stretch: Vec<f64>,
    /// d (N s²/m²): drag at the excitation; 0 for none.
    pub quadratic_damping: f64,
    /// Sensors.
    pub sensors: Vec<Sensor>,
    /// Where forces from outside push across the beam besides the contact at its end: each adds `Tₖ φᵢ(xₖ)` to the
    /// left-hand side of mode i.
    pub contact_points: Vec<Sensor>,
}

impl ModalBeam {
    /// Whether anything but a contact pulls along the beam, by its shortening.
    pub(crate) fn pulls_along(&self) -> bool {
        self.stretching_stiffness != 0.0 || self.string_stiffness != 0.0
    }
}

/// A sensor on a [`ModalBeam`], or another place of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Distance from the clamp (m).
    pub position: f64,
    /// φᵢ(position) (kg^-1/2).
    pub shape: Vec<f64>,
}
