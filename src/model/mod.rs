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
mod error;
mod free;
mod law;
mod normal;
mod oscillator;
mod parameters;
mod parse;
mod pin_rig;
mod reference;
mod slots;
mod text;
mod write;

pub use assembled::AssemblyError;
pub use check::SMALLEST_AND_LARGEST;
pub use error::ParameterError;
pub use normal::Normal;
pub use oscillator::GROUND;
pub use parameters::ModelParameter;
pub use pin_rig::PinnedBeam;
pub use reference::{ReferenceKey, ReferenceTable, reference};

pub use crate::contact::Law;
pub use crate::system::{Anchor, Beam, Damping, Mass, Oscillator, PointMass, Spring};

use crate::effects::{AppliedEffect, Changes, Kind};

/// What is wrong with a model file, and where.
pub type ModelError = crate::document::DocumentError;

/// The `schema` of the model files this version reads and writes.
pub const SCHEMA: &str = "stickslip.model/1";

/// A whole model file.
///
/// ```
/// use stickslip::model::{Model, Structure};
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "contact"
///     contact = { law = "jenkins", tangential_stiffness = 2e3, friction_coefficient = 0.1, normal_load = 10.0 }
///     effect = [{ id = "backlash", half_gap = 2e-4 }]
///     "#,
/// )?;
/// assert_eq!(model.structure, Structure::Prescribed);
/// assert_eq!(model.changes().joint.half_gap, 2e-4);
/// # Ok::<(), stickslip::model::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What the contact is attached to.
    pub structure: Structure,
    /// The contact; a beam may have none (then its support may be a rotational spring), a pin rig has one.
    pub contact: Option<Contact>,
    /// `[[effect]]`: effects added, in order.
    pub effects: Vec<AppliedEffect>,
    /// Paths a fit may change, as written in `[fit] free`, where `*` stands for any characters;
    /// defaults when absent. [`Model::parameters`] lists the result.
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
            Structure::PinRig(_) => Kind::PinRig,
        }
    }
}

/// `kind` of the model.
///
/// ```
/// use stickslip::model::{Model, Structure};
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "oscillator"
///     mass = [{ name = "m1", mass = 1.0 }]
///     spring = [{ between = ["ground", "m1"], stiffness = 9.0 }]
///     "#,
/// )?;
/// let Structure::Oscillator(oscillator) = &model.structure else { panic!("an oscillator") };
/// assert_eq!(oscillator.masses[0].mass, 1.0);
/// # Ok::<(), stickslip::model::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Structure {
    /// `kind = "contact"`: displacement (and normal load) are prescribed.
    Prescribed,
    /// `kind = "beam"`.
    Beam(Beam),
    /// `kind = "oscillator"`.
    Oscillator(Oscillator),
    /// `kind = "pin_rig"`.
    PinRig(PinnedBeam),
}

impl Structure {
    /// The beam, of a structure that is one or has one.
    pub fn beam(&self) -> Option<&Beam> {
        match self {
            Self::Beam(beam) | Self::PinRig(PinnedBeam { beam, .. }) => Some(beam),
            Self::Prescribed | Self::Oscillator(_) => None,
        }
    }

    /// As [`Structure::beam`], to be changed.
    pub fn beam_mut(&mut self) -> Option<&mut Beam> {
        match self {
            Self::Beam(beam) | Self::PinRig(PinnedBeam { beam, .. }) => Some(beam),
            Self::Prescribed | Self::Oscillator(_) => None,
        }
    }
}

/// `[contact]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Which law, with the parameters only it has.
    pub law: Law,
    /// Stiffness in stick (N/m), e0 of Valanis' law.
    pub tangential_stiffness: f64,
    /// Coefficient of friction (1).
    pub friction_coefficient: f64,
    /// Constant normal load (N).
    pub normal_load: f64,
    /// Normal stiffness (N/m), by which a measured normal displacement changes the load; 0 when absent.
    pub normal_stiffness: f64,
    /// The normal direction, of a contact in two directions.
    pub normal: Option<Normal>,
}
