//! Where a nonlinear mode begins: the mode of the structure with its contacts as they are at rest.

use super::held::Held;
use crate::harmonic::HarmonicError;
use crate::system::{LinearStructure, Row};

/// What moves less than this fraction of the mode's largest entry stands still.
const STILL: f64 = 1e-9;

/// The mode of the structure with its contacts linearised at rest.
pub(super) struct LinearStart {
    pub angular_frequency: f64,
    pub damping_ratio: f64,
    /// Degrees of freedom where the node's displacement is 1.
    pub shape: Vec<f64>,
    /// Sum of the squares of the contacts' displacements in the mode of unit modal mass (1/kg).
    pub contact_fraction: f64,
    /// Largest entry of the mode of unit modal mass.
    largest: f64,
}

impl LinearStart {
    pub fn new(
        structure: &LinearStructure,
        stiffness: impl Iterator<Item = f64>,
        mode: usize,
        node: usize,
    ) -> Result<Self, HarmonicError> {
        let Some(output) = structure.outputs.get(node) else {
            return Err(HarmonicError::InvalidInput("the structure has no such node"));
        };
        let mut stuck = structure.clone();
        stuck.stiffness.extend(structure.along_contacts(stiffness));
        let modes = stuck.natural_modes()?;
        let Some(angular_frequency) = modes.angular_frequency.get(mode).copied() else {
            return Err(HarmonicError::InvalidInput("the structure has no such mode"));
        };
        if angular_frequency == 0.0 {
            return Err(HarmonicError::InvalidInput(
                "a body that is free to move has no vibration in this mode",
            ));
        }
        let shape = modes.shapes.column(mode);
        let of = |row: &Row| row.iter().map(|(i, factor)| factor * shape[*i]).sum::<f64>();
        let node = of(&output.row);
        if node.abs() <= STILL * shape.amax() {
            return Err(HarmonicError::InvalidInput("the node does not move in this mode"));
        }
        let contact_fraction: f64 = structure.contacts.iter().map(|row| of(row).powi(2)).sum();
        let rate: f64 = structure.damping.iter().map(|(i, j, c)| shape[*i] * c * shape[*j]).sum();
        Ok(Self {
            angular_frequency,
            damping_ratio: 0.5 * rate / angular_frequency,
            shape: shape.iter().map(|x| x / node).collect(),
            contact_fraction,
            largest: shape.amax(),
        })
    }

    /// The same of a mode in which a contact moves.
    pub fn moving(
        structure: &LinearStructure,
        stiffness: impl Iterator<Item = f64>,
        held: &Held,
    ) -> Result<Self, HarmonicError> {
        let start = Self::new(structure, stiffness, held.mode, held.node)?;
        if start.is_linear() {
            return Err(HarmonicError::InvalidInput("no contact moves in this mode: it is linear"));
        }
        Ok(start)
    }

    /// Whether no contact moves.
    pub fn is_linear(&self) -> bool {
        self.contact_fraction.sqrt() <= STILL * self.largest
    }

    /// Displacement of a row where that of the node is 1.
    pub fn displacement(&self, row: &Row) -> f64 {
        row.iter().map(|(i, factor)| factor * self.shape[*i]).sum()
    }
}
