//! The engineer's model (`model.toml`): types, parsing with positions, parameters by path.
//!
//! ```
//! use stickslip::model::Model;
//!
//! let mut model = Model::parse(
//!     r#"
//!     schema = "stickslip.model/1"
//!     kind = "contact"
//!
//!     [contact]
//!     law = "jenkins"
//!     tangential_stiffness = 5.1e6   # N/m
//!     friction_coefficient = 0.47
//!     normal_load = 162.0            # N
//!     "#,
//! )?;
//! model.set("contact.friction_coefficient", 0.5)?;
//! assert_eq!(model.get("contact.friction_coefficient"), Some(0.5));
//! assert_eq!(Model::parse(&model.to_toml())?, model);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Model::parse`] reports the first thing wrong with the byte range it stands at;
//! [`Model::check`] holds the rules themselves, for models built or changed in code.

mod assembled;
mod check;
mod effects;
mod free;
mod law;
mod oscillator;
mod parameters;
mod parse;
mod write;

pub use assembled::{Assembled, AssemblyError};
pub use check::{ParameterError, SMALLEST_AND_LARGEST};
pub use oscillator::{Anchor, GROUND, Mass, Oscillator, Spring};
pub use parameters::ModelParameter;

use crate::effects::{AppliedEffect, Changes, Kind};

/// What is wrong with a model file, and where.
pub type ModelError = crate::document::DocumentError;

/// The `schema` of the model files this version reads and writes.
pub const SCHEMA: &str = "stickslip.model/1";

/// A whole model file.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What the contact is attached to.
    pub structure: Structure,
    /// The contact; a beam may have none (then its support may be a rotational spring).
    pub contact: Option<Contact>,
    /// `[[effect]]`: effects added, in order.
    pub effects: Vec<AppliedEffect>,
    /// Paths a fit may change, as written in `[fit] free`, where `*` stands for any characters;
    /// defaults when absent. [`Model::parameters`] says what they come to.
    pub free: Option<Vec<String>>,
}

impl Model {
    /// What the model's effects change together.
    pub fn changes(&self) -> Changes {
        let mut changes = Changes::default();
        for effect in &self.effects {
            effect.apply(&mut changes);
        }
        changes
    }

    /// The kind of the model, without its numbers.
    pub fn kind(&self) -> Kind {
        match self.structure {
            Structure::Prescribed => Kind::Contact,
            Structure::Beam(_) => Kind::Beam,
            Structure::Oscillator(_) => Kind::Oscillator,
        }
    }
}

/// `kind` of the model.
#[derive(Debug, Clone, PartialEq)]
pub enum Structure {
    /// `kind = "contact"`: displacement (and normal load) are prescribed.
    Prescribed,
    /// `kind = "beam"`.
    Beam(Beam),
    /// `kind = "oscillator"`.
    Oscillator(Oscillator),
}

/// `[contact]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Which law, with the parameters only it has.
    pub law: Law,
    /// Stiffness in stick (N/m), e0 for Valanis.
    pub tangential_stiffness: f64,
    /// Coefficient of friction (1).
    pub friction_coefficient: f64,
    /// Constant normal load (N).
    pub normal_load: f64,
    /// Normal stiffness (N/m), by which a measured normal displacement changes the load; 0 when absent.
    pub normal_stiffness: f64,
}

/// The contact laws a model file can name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// One spring, one slider.
    Jenkins,
    /// Valanis' endochronic law; `λ` follows from e0 and the limit μN.
    Valanis {
        /// κ in [0, 1): 0 rounds the loop most, 1 would be Jenkins.
        smoothness: f64,
        /// e_t (N/m), slope left in macro-slip, below the tangential stiffness.
        residual_stiffness: f64,
    },
    /// Segalman's four-parameter Iwan element.
    Iwan {
        /// χ in (−1, 0]: small loops dissipate with the power χ + 3 of the amplitude.
        exponent: f64,
        /// β ≥ 0: stiffness of the sliders that yield last, all at once, over that of all others.
        ratio: f64,
    },
}

impl Law {
    /// The name in model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jenkins => "jenkins",
            Self::Valanis { .. } => "valanis",
            Self::Iwan { .. } => "iwan",
        }
    }
}

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
