//! One mechanical system, and the structures that make one.
//!
//! `ports`: a linear core, named ports, elements at ports; `resonator`: resonators as coordinates. Builders: [`beam`]
//! ([`ModalBeam::new`] reduces a [`Beam`] to its exact modes; [`rotational_stiffness_from_frequency`] reads the support's
//! stiffness off a measured frequency), `oscillator`, `linear` (matrices), [`pin_rig`] (a beam whose pin slips and slaps).
//! `changes`: what effects change. `receptance`: a linear structure condensed to its points.

pub mod beam;
mod changes;
mod error;
mod linear;
mod oscillator;
pub mod pin_rig;
mod ports;
#[cfg(feature = "analysis")]
mod receptance;
mod resonator;

pub use beam::{
    Beam, Damping, ModalBeam, PointMass, Sensor, rotational_stiffness_from_frequency,
    tip_rotational_compliance,
};
pub use changes::{HangingMass, Place, StructureChanges};
pub use error::StructureError;
pub use linear::{LinearStructure, MOST_DENSE_MODES, NaturalModes, Output};
pub use oscillator::{Anchor, Mass, Oscillator, Spring};
pub use pin_rig::{FiniteElementRigModes, HangingString, ModalPinRig, Pin, PinRig, PinRigModes};
pub use ports::{Core, Element, Entries, Port, Row, System};
#[cfg(feature = "analysis")]
pub use receptance::{Compliance, Method, Receptance, Rows};
