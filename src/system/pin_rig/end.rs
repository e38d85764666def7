//! What is fixed to the end of the beam: five coordinates with a mass and a stiffness.

use nalgebra::{Matrix5, SMatrix, SymmetricEigen, Vector5};

use super::PinRig;
use super::description::GRAVITY;

/// Deflection (m) and slope of the beam's end, axial stretch (m), stretch of the string (m) and its angle.
pub(super) type EndMotion = Vector5<f64>;

/// Place of the end's deflection, slope, and of the axial stretch, the string's stretch and its angle.
const W: usize = 0;
const SLOPE: usize = 1;
const AXIAL: usize = 2;
const STRETCH: usize = 3;
const ANGLE: usize = 4;

/// Rows of displacements, and matrices, over [`EndMotion`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct End {
    /// Of the contact, tangential without the shortening, and normal.
    pub tangential: EndMotion,
    pub normal: EndMotion,
    /// Of the hanging mass along the beam, without the shortening.
    pub hanging: EndMotion,
    pub mass: Matrix5<f64>,
    pub stiffness: Matrix5<f64>,
}

impl End {
    pub fn of(rig: &PinRig) -> Self {
        let PinRig { beam, pin, string, stuck_stiffness } = rig;
        let unit = |place: usize| EndMotion::ith(place, 1.0);
        let tangential = beam.offset * unit(SLOPE) + unit(AXIAL);
        let normal = unit(W) + pin.normal_lever * unit(SLOPE);
        let hanging = unit(AXIAL) - beam.offset * unit(SLOPE) + string.length * unit(ANGLE);
        let across = normal - unit(STRETCH);
        let at_end: f64 =
            beam.point_masses.iter().filter(|at| at.position >= beam.length).map(|at| at.mass).sum();
        let sum = |terms: &[(f64, EndMotion)]| {
            terms.iter().fold(Matrix5::zeros(), |sum, (value, row)| sum + row * row.transpose() * *value)
        };
        let mass = sum(&[
            (pin.mass, normal),
            (pin.mass, unit(AXIAL)),
            (pin.inertia, unit(SLOPE)),
            (string.mass, across),
            (string.mass, hanging),
            (string.inertia, unit(ANGLE)),
            (at_end, unit(W)),
        ]);
        let stiffness = sum(&[
            (beam.youngs_modulus * beam.width * beam.thickness / beam.length, unit(AXIAL)),
            (string.stiffness, unit(STRETCH)),
            (string.mass * GRAVITY * string.length, unit(ANGLE)),
            (stuck_stiffness[0], tangential),
            (stuck_stiffness[1], normal),
        ]);
        Self { tangential, normal, hanging, mass, stiffness }
    }

    /// Its energy of motion as a part of the modal mass of 1, of a mode with this end.
    pub fn modal_mass(&self, end: &EndMotion) -> f64 {
        (end.transpose() * self.mass * end)[0]
    }
}

/// Negative eigenvalues of a symmetric matrix, and the eigenvector of the eigenvalue nearest to zero, of the matrix scaled to
/// a diagonal of ones.
pub(super) fn inertia(matrix: &Matrix5<f64>) -> Option<(usize, EndMotion)> {
    let scale = matrix.diagonal().map(|entry| if entry == 0.0 { 1.0 } else { 1.0 / entry.abs().sqrt() });
    let scales = SMatrix::from_diagonal(&scale);
    let eigen = SymmetricEigen::try_new(scales * matrix * scales, f64::EPSILON, 1000)?;
    let negative = eigen.eigenvalues.iter().filter(|value| **value < 0.0).count();
    let least = eigen.eigenvalues.map(f64::abs).imin();
    Some((negative, eigen.eigenvectors.column(least).component_mul(&scale)))
}
