//! The same rig by finite elements: an independent check of the exact modes.

use nalgebra::DMatrix;

use super::PinRig;
use super::end::{End, EndMotion};
use crate::system::StructureError;
use crate::system::beam::FiniteElementModes;
use crate::system::beam::finite_element::System;

/// Coordinates of the end beside the beam's.
const BESIDE: usize = 3;

/// Mass-normalised finite-element modes of the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct FiniteElementRigModes {
    beam: FiniteElementModes,
    beam_fraction: Vec<f64>,
}

impl FiniteElementRigModes {
    /// The first `count` modes with about `elements` elements.
    ///
    /// # Errors
    /// Values out of bounds, or [`StructureError::NotComputable`] where rounding makes the stiffness indefinite.
    pub fn new(rig: &PinRig, elements: usize, count: usize) -> Result<Self, StructureError> {
        rig.check(count)?;
        let (beam, end) = (&rig.beam, End::of(rig));
        let mut system = System::assemble(&bare(rig), elements);
        let size = system.stiffness.nrows();
        let tip = size - 2;
        for matrix in [&mut system.stiffness, &mut system.mass, &mut system.slope_gram] {
            *matrix =
                std::mem::replace(matrix, DMatrix::zeros(0, 0)).resize(size + BESIDE, size + BESIDE, 0.0);
        }
        // Slopes are per beam length there, forces in EI/L³, masses in that of the beam.
        let unit = |place: usize| if place == 1 { 1.0 / beam.length } else { 1.0 };
        let area = beam.width * beam.thickness;
        let bending = beam.youngs_modulus * area * beam.thickness.powi(2) / 12.0 / beam.length.powi(3);
        let own = beam.density * area * beam.length;
        for row in 0..2 + BESIDE {
            for column in 0..2 + BESIDE {
                let factor = unit(row) * unit(column);
                let place = (tip + row, tip + column);
                system.stiffness[place] += factor * end.stiffness[(row, column)] / bending;
                system.mass[place] += factor * end.mass[(row, column)] / own;
            }
        }
        let held = if beam.clamp_stiffness.is_some() { 1 } else { 2 };
        system.free = (held..size + BESIDE).collect();
        let modes = FiniteElementModes::of(beam, system, count)?;
        let fraction = |mode: usize| {
            let at_end = [modes.displacement(mode, beam.length)?, modes.slope(mode, beam.length)?];
            let motion = at_end.into_iter().chain(modes.beside(mode));
            Some(1.0 - end.modal_mass(&EndMotion::from_iterator(motion)))
        };
        let beam_fraction = (0..count).filter_map(fraction).collect();
        Ok(Self { beam: modes, beam_fraction })
    }

    /// ωᵢ (rad/s), ascending.
    pub fn angular_frequency(&self) -> &[f64] {
        self.beam.angular_frequency()
    }

    /// φᵢ(x) (kg^-1/2), of any sign; `mode` counts from 0, `x` (m) is taken into the beam if outside.
    pub fn displacement(&self, mode: usize, x: f64) -> Option<f64> {
        self.beam.displacement(mode, x)
    }

    /// Gᵢⱼ = ∫ φᵢ' φⱼ' dx (1/(kg m)), row-major, by modes of any sign.
    pub fn shortening(&self) -> Vec<f64> {
        self.beam.shortening()
    }

    /// Fraction of each mode's kinetic energy that is the beam's and its masses'.
    pub fn beam_fraction(&self) -> &[f64] {
        &self.beam_fraction
    }
}

/// The beam without what its end has of its own: masses there are the end's.
fn bare(rig: &PinRig) -> crate::system::Beam {
    let mut beam = rig.beam.clone();
    beam.rotational_stiffness = 0.0;
    beam.point_masses.retain(|mass| mass.position < beam.length);
    beam
}
