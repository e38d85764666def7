//! What a contact is made of.

use crate::physics::gradual::Gradual;
use crate::physics::unknown::Unknown;

/// What the contact is made of. SI units; zero changes nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Stiffness of all sliders in stick (N/m).
    pub stiffness: f64,
    /// μ: limit over normal load (1).
    pub friction_coefficient: f64,
    /// Half-width of the sliders' yield displacements over their mean, in [0, 1).
    pub spread: f64,
    /// Spring beside the sliders (N/m).
    pub residual_stiffness: f64,
    /// Damper beside the sliders (N s/m).
    pub damping: f64,
    /// Cubic spring beside the sliders (N/m³).
    pub cubic_stiffness: f64,
    /// δ (1) and v_s (m/s) of the limit's factor 1 + δ exp(−|v|/v_s).
    pub weakening: Option<(f64, f64)>,
    /// Change of the limit with the distance slipped (1/m).
    pub wear: f64,
    /// a: limit · (1 + a) against positive force, (1 − a) against negative.
    pub asymmetry: f64,
    /// Half of the play in series (m).
    pub half_gap: f64,
    /// What the sliders are replaced by, if they are.
    pub gradual: Option<Gradual>,
    /// What no catalogue knows.
    pub unknown: Option<Unknown>,
}

impl Joint {
    /// Jenkins' element: one slider.
    pub fn jenkins(stiffness: f64, friction_coefficient: f64) -> Self {
        Self {
            stiffness,
            friction_coefficient,
            spread: 0.0,
            residual_stiffness: 0.0,
            damping: 0.0,
            cubic_stiffness: 0.0,
            weakening: None,
            wear: 0.0,
            asymmetry: 0.0,
            half_gap: 0.0,
            gradual: None,
            unknown: None,
        }
    }
}
