//! The same beam by cubic finite elements, as an independent witness for the characteristic equation.

use std::f64::consts::TAU;

use nalgebra::SymmetricEigen;

use super::characteristic::Assembly;
use super::{StructureError, check};
use crate::model::Beam;

/// Natural frequencies (Hz), ascending, of `beam` divided into about `elements` Hermite cubic elements of
/// equal length, with nodes at the masses. Their error falls with the fourth power of the element length.
///
/// # Errors
/// [`StructureError`] names what is out of bounds.
pub fn finite_element_frequencies(beam: &Beam, elements: usize) -> Result<Vec<f64>, StructureError> {
    check(beam)?;
    let elements = elements.max(2);
    let nodes: Vec<f64> = (1..elements).map(|node| beam.length * node as f64 / elements as f64).collect();
    let assembly = Assembly::new(beam, &nodes);
    let stiffness =
        assembly.assemble(|segment| segment.cubic_element().0, |freedom| assembly.spring(freedom));
    let mass = assembly.assemble(|segment| segment.cubic_element().1, |freedom| assembly.mass(freedom));
    // K φ = ω² M φ as L⁻¹ K L⁻ᵀ with M = L Lᵀ; the mass matrix of an elastic beam is positive definite.
    let factor = mass.cholesky().ok_or(StructureError::Singular)?.l();
    let half = factor.solve_lower_triangular(&stiffness).ok_or(StructureError::Singular)?;
    let whole = factor.solve_lower_triangular(&half.transpose()).ok_or(StructureError::Singular)?;
    let mut squares: Vec<f64> = SymmetricEigen::new(whole).eigenvalues.iter().copied().collect();
    squares.sort_by(f64::total_cmp);
    Ok(squares.into_iter().map(|square| square.max(0.0).sqrt() / TAU).collect())
}
