//! What effects change of a structure. It is made part of the structure's description before any solver sees it.

use std::f64::consts::TAU;
use std::fmt;

use super::ports::Element;

/// A place of a structure.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// A mass of an oscillator, by its name.
    Mass(String),
    /// A position on a beam (m from the clamp).
    Position(f64),
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mass(name) => formatter.write_str(name),
            Self::Position(position) => write!(formatter, "x={position}"),
        }
    }
}

/// Changes of the structure.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StructureChanges {
    /// Masses (kg) added at places.
    pub added_masses: Vec<(Place, f64)>,
    /// Rotational stiffness (N m/rad) of a clamp that was rigid.
    pub clamp_stiffness: Option<f64>,
    /// Resonators hung at the contact.
    pub hanging_masses: Vec<HangingMass>,
    /// N/m³. Oscillator: `k3 x³` from the ground on the first mass. Beam: mid-plane stretching with the
    /// potential `k3/4 · (∫w'² dx / G₁)²`, where G₁ is `∫w'² dx` of the first mode with unit displacement at
    /// the excitation, so that k3 is the cubic stiffness of the first mode there.
    pub cubic_stiffness: f64,
    /// q (N s²/m²): `q |v| v` on the first mass, or on the beam at the excitation.
    pub quadratic_damping: f64,
}

/// A resonator hung at the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HangingMass {
    /// Mass (kg).
    pub mass: f64,
    /// Natural frequency with the contact held (Hz).
    pub frequency: f64,
}

impl HangingMass {
    /// The resonator at `port`, a place in [`System::ports`](crate::system::System::ports), damped by `damping_ratio` (1).
    pub(crate) fn at(&self, port: usize, damping_ratio: f64) -> Element {
        let angular_frequency = TAU * self.frequency;
        Element::Resonator { port, mass: self.mass, angular_frequency, damping_ratio }
    }
}
