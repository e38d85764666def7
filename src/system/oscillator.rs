//! Masses and springs as a linear structure.

use std::f64::consts::TAU;

use super::linear::{LinearStructure, Output, Sum};
use super::{HangingMass, Place, StructureChanges, StructureError};
use crate::contact::{ContactLaw, CubicSpring, Drag, LawError};
use crate::vocabulary as v;

/// `[[mass]]`, `[[spring]]` and where contact and excitation are: masses on springs, each moving along one line, with a contact between one of them and the ground.
///
/// ```
/// use stickslip::system::{Anchor, Mass, Oscillator, Spring};
/// let oscillator = Oscillator {
///     masses: vec![Mass { name: "m1".into(), mass: 1.0 }],
///     springs: vec![Spring { between: [Anchor::Ground, Anchor::Mass(0)], stiffness: 4.0, damping: 0.1 }],
///     contact: Some(0),
///     excitation: 0,
/// };
/// let structure = oscillator.structure()?;
/// assert_eq!(structure.natural_modes()?.angular_frequency, [2.0]);
/// # Ok::<(), stickslip::system::StructureError>(())
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

impl Oscillator {
    /// The oscillator with the masses of `changes`, those hung at the contact on springs of their own.
    fn changed(&self, changes: &StructureChanges) -> Result<Self, StructureError> {
        let mut changed = self.clone();
        for (place, added) in &changes.added_masses {
            let found = match place {
                Place::Mass(name) => changed.masses.iter_mut().find(|mass| mass.name == *name),
                Place::Position(_) => None,
            };
            let mass = found.ok_or_else(|| StructureError::NoSuchMass { place: place.to_string() })?;
            mass.mass += added;
        }
        for &HangingMass { mass, frequency } in &changes.hanging_masses {
            let contact = self.contact.ok_or(StructureError::NothingToHangAt)?;
            let between = [Anchor::Mass(contact), Anchor::Mass(changed.masses.len())];
            let stiffness = mass * (TAU * frequency).powi(2);
            changed.masses.push(Mass { name: String::new(), mass });
            changed.springs.push(Spring { between, stiffness, damping: 0.0 });
        }
        Ok(changed)
    }

    /// The matrices with `changes`; a mass hung at the contact is one more degree of freedom that is no output. Cubic
    /// stiffness and drag are laws at contacts of their own, which follow the oscillator's: see
    /// [`Oscillator::added_laws`].
    ///
    /// # Errors
    /// As [`Oscillator::structure`]; [`StructureError::NoSuchMass`], [`StructureError::NothingToHangAt`].
    pub fn structure_with(&self, changes: &StructureChanges) -> Result<LinearStructure, StructureError> {
        let mut structure = self.changed(changes)?.structure()?;
        structure.outputs.truncate(self.masses.len());
        let added =
            [changes.cubic_stiffness, changes.quadratic_damping].into_iter().filter(|law| *law != 0.0);
        structure.contacts.extend(added.map(|_| vec![(0, 1.0)]));
        Ok(structure)
    }

    /// The laws that `changes` add between the first mass and the ground, which know no normal load.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn added_laws(changes: &StructureChanges) -> Result<Vec<Box<dyn ContactLaw>>, LawError> {
        let mut added: Vec<Box<dyn ContactLaw>> = Vec::new();
        if changes.cubic_stiffness != 0.0 {
            added.push(Box::new(CubicSpring::new(0.0, changes.cubic_stiffness)?));
        }
        if changes.quadratic_damping != 0.0 {
            added.push(Box::new(Drag::new(changes.quadratic_damping)?));
        }
        Ok(added)
    }

    /// The matrices: one degree of freedom and one output per mass, in their order and by their names.
    ///
    /// Each spring between masses i and j adds `k (qᵢ − qⱼ)` and `c (q̇ᵢ − q̇ⱼ)`. Stiffness and damping may
    /// be zero; what a model file must not say, negative ones, is assembled as it stands. The contact
    /// acts between its mass and the ground.
    ///
    /// # Errors
    /// [`StructureError::OutOfBounds`] for a mass that is not positive or a number that is not finite,
    /// [`StructureError::UnknownMass`] for a reference to a mass that is not there.
    pub fn structure(&self) -> Result<LinearStructure, StructureError> {
        self.check_for_assembly()?;
        let (mut damping, mut stiffness) = (Sum::default(), Sum::default());
        for spring in &self.springs {
            couple(&mut damping, spring, spring.damping);
            couple(&mut stiffness, spring, spring.stiffness);
        }
        let mass = self.masses.iter().enumerate().map(|(i, mass)| (i, i, mass.mass)).collect();
        let output = |(i, mass): (usize, &Mass)| Output { name: mass.name.clone(), row: vec![(i, 1.0)] };
        Ok(LinearStructure {
            size: self.masses.len(),
            mass,
            damping: damping.entries(),
            stiffness: stiffness.entries(),
            contacts: self.contact.iter().map(|mass| vec![(*mass, 1.0)]).collect(),
            excitation: vec![(self.excitation, 1.0)],
            outputs: self.masses.iter().enumerate().map(output).collect(),
        })
    }

    fn check_for_assembly(&self) -> Result<(), StructureError> {
        let count = self.masses.len();
        let there = |path: &dyn Fn() -> String, mass: usize| {
            if mass < count { Ok(()) } else { Err(StructureError::UnknownMass { path: path(), mass, count }) }
        };
        let out_of_bounds =
            |path: String, value: f64, quantity| Err(StructureError::OutOfBounds { path, value, quantity });
        for (index, mass) in self.masses.iter().enumerate() {
            if !(mass.mass > 0.0 && mass.mass.is_finite()) {
                return out_of_bounds(format!("mass[{index}].mass"), mass.mass, &v::MASS);
            }
        }
        for (index, spring) in self.springs.iter().enumerate() {
            for (value, quantity) in [(spring.stiffness, &v::STIFFNESS), (spring.damping, &v::DAMPING)] {
                if !value.is_finite() {
                    return out_of_bounds(format!("spring[{index}].{}", quantity.name), value, quantity);
                }
            }
            for end in spring.between {
                if let Anchor::Mass(mass) = end {
                    there(&|| format!("spring[{index}].between"), mass)?;
                }
            }
        }
        self.contact.map_or(Ok(()), |mass| there(&|| "contact.at".to_owned(), mass))?;
        there(&|| "excitation.at".to_owned(), self.excitation)
    }
}

/// Adds what a spring's end forces are per unit of displacement (or velocity) of its ends.
fn couple(matrix: &mut Sum, spring: &Spring, value: f64) {
    match spring.between {
        [Anchor::Ground, Anchor::Ground] => {}
        [Anchor::Ground, Anchor::Mass(i)] | [Anchor::Mass(i), Anchor::Ground] => matrix.add(i, i, value),
        // Both ends at one mass: never stretched.
        [Anchor::Mass(i), Anchor::Mass(j)] if i == j => {}
        [Anchor::Mass(i), Anchor::Mass(j)] => {
            matrix.add(i, i, value);
            matrix.add(j, j, value);
            matrix.add(i, j, -value);
            matrix.add(j, i, -value);
        }
    }
}
