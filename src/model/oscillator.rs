//! `kind = "oscillator"`: masses in a row of names, springs with dampers between them and the ground.
//!
//! ```toml
//! [[mass]]
//! name = "m1"
//! mass = 1.0                    # kg
//!
//! [[spring]]
//! between = ["ground", "m1"]
//! stiffness = 1.0               # N/m
//! damping = 0.1                 # N s/m
//!
//! [contact]
//! at = "m1"                     # against the ground
//! ```

/// The name that stands for the ground in `between`.
pub const GROUND: &str = "ground";

/// Masses on springs, each moving along one line, with a contact between one of them and the ground.
///
/// ```
/// use stickslip::model::{Anchor, Mass, Oscillator, Spring};
/// let oscillator = Oscillator {
///     masses: vec![Mass { name: "m1".into(), mass: 1.0 }],
///     springs: vec![Spring { between: [Anchor::Ground, Anchor::Mass(0)], stiffness: 4.0, damping: 0.1 }],
///     contact: Some(0),
///     excitation: 0,
/// };
/// let structure = oscillator.structure()?;
/// assert_eq!(structure.natural_modes()?.angular_frequency, [2.0]);
/// # Ok::<(), stickslip::structure::StructureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Oscillator {
    /// `[[mass]]`, in the file's order; their names are distinct.
    pub masses: Vec<Mass>,
    /// `[[spring]]`, in the file's order.
    pub springs: Vec<Spring>,
    /// Which mass the contact touches, `[contact] at`; `None` without a contact.
    pub contact: Option<usize>,
    /// Which mass the excitation acts on, `[excitation] at`; the first when absent.
    pub excitation: usize,
}

/// A mass of an [`Oscillator`].
#[derive(Debug, Clone, PartialEq)]
pub struct Mass {
    /// Its name, under which its displacement is reported.
    pub name: String,
    /// Its mass (kg).
    pub mass: f64,
}

/// A spring and a damper side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Its two ends.
    pub between: [Anchor; 2],
    /// Stiffness (N/m).
    pub stiffness: f64,
    /// Damping (N s/m).
    pub damping: f64,
}

/// What an end of a [`Spring`] is fixed to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The ground, which does not move.
    Ground,
    /// A mass, by its place in [`Oscillator::masses`].
    Mass(usize),
}
