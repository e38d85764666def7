//! From solutions of `Z x = f` to compliances and their derivatives.

use nalgebra::Complex;

use super::compliance::{Compliance, Rows, Singular};
use crate::system::linear::LinearStructure;
use crate::system::{Entries, Row};

/// K, C and M on the places that any of them has, sorted by row.
#[derive(Debug, Clone)]
pub(super) struct Matrices {
    pub(super) size: usize,
    pub(super) places: Vec<Place>,
}

/// A place of the dynamic stiffness.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) row: usize,
    pub(super) column: usize,
    stiffness: f64,
    damping: f64,
    mass: f64,
}

/// Which of the three matrices a place's value is taken from.
type Part = fn(&Place) -> f64;

impl Place {
    /// The entry of `K + damping · C + inertia · M`.
    pub(super) fn value(&self, damping: Complex<f64>, inertia: Complex<f64>) -> Complex<f64> {
        damping * self.damping + inertia * self.mass + self.stiffness
    }

    /// Size of the terms that make up the entry: what it may have lost by cancellation.
    pub(super) fn terms(&self, damping: f64, inertia: f64) -> f64 {
        damping * self.damping.abs() + inertia * self.mass.abs() + self.stiffness.abs()
    }
}

impl Matrices {
    pub(super) fn new(structure: &LinearStructure) -> Self {
        let mut places = Vec::new();
        let mut add = |entries: &Entries, set: fn(&mut Place, f64)| {
            for (row, column, value) in entries {
                let mut place = Place { row: *row, column: *column, stiffness: 0.0, damping: 0.0, mass: 0.0 };
                set(&mut place, *value);
                places.push(place);
            }
        };
        add(&structure.stiffness, |place, value| place.stiffness = value);
        add(&structure.damping, |place, value| place.damping = value);
        add(&structure.mass, |place, value| place.mass = value);
        places.sort_by_key(|place| (place.row, place.column));
        places.dedup_by(|next, kept| {
            let same = (next.row, next.column) == (kept.row, kept.column);
            if same {
                kept.stiffness += next.stiffness;
                kept.damping += next.damping;
                kept.mass += next.mass;
            }
            same
        });
        Self { size: structure.size, places }
    }
}

/// Points and forces of a structure, with room for the solutions.
#[derive(Debug, Clone)]
pub(super) struct Condensation {
    matrices: Matrices,
    /// The contacts, then the excitation.
    forces: Vec<Row>,
    outputs: Vec<Row>,
    /// Z⁻¹ of each force, one after the other.
    moved: Vec<Complex<f64>>,
    /// One more column.
    work: Vec<Complex<f64>>,
}

impl Condensation {
    pub(super) fn new(structure: &LinearStructure, matrices: Matrices) -> Self {
        let forces: Vec<Row> = structure.contacts.iter().chain([&structure.excitation]).cloned().collect();
        let zero = Complex::new(0.0, 0.0);
        Self {
            moved: vec![zero; forces.len() * matrices.size],
            work: vec![zero; matrices.size],
            outputs: structure.outputs.iter().map(|output| output.row.clone()).collect(),
            forces,
            matrices,
        }
    }

    pub(super) fn matrices(&self) -> &Matrices {
        &self.matrices
    }

    /// Fills `out`, where `solve` replaces a right-hand side by the solution.
    pub(super) fn fill(
        &mut self,
        rows: Rows,
        mut solve: impl FnMut(&mut [Complex<f64>]) -> Result<(), Singular>,
        out: &mut Compliance,
    ) -> Result<(), Singular> {
        let size = self.matrices.size;
        for (column, force) in self.moved.chunks_exact_mut(size).zip(&self.forces) {
            column.fill(Complex::new(0.0, 0.0));
            force.iter().for_each(|(i, factor)| column[*i] += *factor);
            solve(column)?;
        }
        let contacts = self.forces.len() - 1;
        let outputs: &[Row] = if rows == Rows::All { &self.outputs } else { &[] };
        for (k, column) in self.moved.chunks_exact(size).enumerate() {
            for (p, row) in self.forces[..contacts].iter().chain(outputs).enumerate() {
                out.value[(p, k)] = dot(row, column);
            }
            let parts: [Part; 2] = [|place| place.damping, |place| place.mass];
            let derivatives = [&mut out.by_damping, &mut out.by_inertia].into_iter().zip(parts);
            for (derivative, part) in derivatives {
                multiply(&self.matrices, part, column, &mut self.work);
                // Z is symmetric: the contacts' rows of its inverse are their own solutions.
                for (p, observer) in self.moved.chunks_exact(size).take(contacts).enumerate() {
                    derivative[(p, k)] =
                        -observer.iter().zip(&self.work).map(|(a, b)| a * b).sum::<Complex<_>>();
                }
                if !outputs.is_empty() {
                    // However many outputs there are, one more solution serves them all.
                    solve(&mut self.work)?;
                    for (p, row) in outputs.iter().enumerate() {
                        derivative[(contacts + p, k)] = -dot(row, &self.work);
                    }
                }
            }
        }
        Ok(())
    }
}

fn dot(row: &Row, column: &[Complex<f64>]) -> Complex<f64> {
    row.iter().map(|(i, factor)| column[*i] * *factor).sum()
}

/// One of the three matrices times a column.
fn multiply(matrices: &Matrices, part: Part, column: &[Complex<f64>], out: &mut [Complex<f64>]) {
    out.fill(Complex::new(0.0, 0.0));
    for place in &matrices.places {
        out[place.row] += column[place.column] * part(place);
    }
}
