//! A beam with a pin that slips and slaps on its support under a hanging mass.
//!
//! Source: "Identifying slip-slap forces in the contact interface using dual-mode excitation". In comes a [`PinRig`]
//! (description.rs), out goes a [`ModalPinRig`] (modal.rs) and from it a [`System`](super::System) (elements.rs). What is
//! fixed to the beam's end is five coordinates with a mass and a stiffness (end.rs). The modes are exact
//! (modes.rs), and those by finite elements are an independent check of them (finite_element.rs).
//!
//! # Equations
//! With the end's deflection w and slope θ, the axial stretch u, the string's stretch y and its angle p
//! - tangential `ξ = r θ + u − s` and normal `η = w + r θ` displacement of the contact, `s = ½ ∫ w'² dx`;
//! - the hanging mass moves by `h = u − r θ + l p − s` along the beam and by `η − y` across it;
//! - `M z̈ + C ż + K z + (c − G z) S + d N − m ḧ G z − m d_h s̈ = b f`, S and N restoring, N without the preload.
//!
//! The paper's eq. 7 has the wrong sign of N(t): with it the contact pushes the pin away from its rest.
//!
//! # Limits of validity
//! As of the beam; small angles of the string; the string never slack.

mod description;
mod end;
mod finite_element;
mod modal;
mod modes;

pub use description::{HangingString, Pin, PinRig};
pub use finite_element::FiniteElementRigModes;
pub use modal::ModalPinRig;
pub use modes::PinRigModes;
