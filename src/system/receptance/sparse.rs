//! Factors of a sparse complex matrix. The one file that knows the crate of the sparse factorisation.

use algebra_linear::sparse::{LuMethod, SparseLu};
use nalgebra::Complex;

use super::compliance::Singular;
use super::condensation::Matrices;
use crate::system::StructureError;

/// LU factors with partial pivoting and an ordering of the columns that keeps them sparse, found once.
#[derive(Debug)]
pub(super) struct SparseFactors {
    factors: SparseLu<Complex<f64>>,
    /// Z by columns; as it is symmetric, its rows are its columns.
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<Complex<f64>>,
    /// Size of the largest of the terms that make up Z.
    terms: f64,
}

impl Clone for SparseFactors {
    fn clone(&self) -> Self {
        Self::of(self.column_starts.clone(), self.rows.clone()).expect("a pattern that was ordered before")
    }
}

impl SparseFactors {
    /// Finds the ordering.
    pub(super) fn new(matrices: &Matrices) -> Result<Self, StructureError> {
        let mut column_starts = vec![0; matrices.size + 1];
        matrices.places.iter().for_each(|place| column_starts[place.row + 1] += 1);
        (0..matrices.size).for_each(|i| column_starts[i + 1] += column_starts[i]);
        Self::of(column_starts, matrices.places.iter().map(|place| place.column).collect())
    }

    fn of(column_starts: Vec<usize>, rows: Vec<usize>) -> Result<Self, StructureError> {
        let too_large =
            |_| StructureError::Unavailable { method: "sparse", reason: "there is not enough memory" };
        Ok(Self {
            factors: SparseLu::analyze(&column_starts, &rows, LuMethod::auto()).map_err(too_large)?,
            values: vec![Complex::new(0.0, 0.0); rows.len()],
            column_starts,
            rows,
            terms: 0.0,
        })
    }

    /// Factorises the dynamic stiffness.
    pub(super) fn factorise(
        &mut self,
        matrices: &Matrices,
        damping: Complex<f64>,
        inertia: Complex<f64>,
    ) -> Result<(), Singular> {
        let (damping_size, inertia_size) = (damping.norm(), inertia.norm());
        self.terms = 0.0;
        for (value, place) in self.values.iter_mut().zip(&matrices.places) {
            *value = place.value(damping, inertia);
            self.terms = self.terms.max(place.terms(damping_size, inertia_size));
        }
        self.factors.factorize(&self.column_starts, &self.rows, &self.values).map_err(|_| Singular)
    }

    /// Replaces a right-hand side by the solution.
    pub(super) fn solve(&mut self, column: &mut [Complex<f64>]) -> Result<(), Singular> {
        let largest = |column: &[Complex<f64>]| column.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let size = column.len();
        let load = largest(column);
        self.factors.solve(column).map_err(|_| Singular)?;
        // The pivots are out of sight; a vanishing one shows in a solution beyond all bounds.
        let bound = load / (4.0 * size as f64 * f64::EPSILON * self.terms);
        let bounded = column.iter().all(|value| value.re.is_finite() && value.im.is_finite());
        if bounded && (load == 0.0 || largest(column) < bound) { Ok(()) } else { Err(Singular) }
    }
}
