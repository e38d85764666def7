//! Factors of a sparse complex matrix, by faer.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};
use nalgebra::Complex;

use super::Singular;
use super::condensation::Matrices;
use crate::system::StructureError;

/// LU factors with partial pivoting and an ordering of the columns that keeps them sparse, found once.
pub(super) struct SparseFactors {
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, Complex<f64>>,
    /// Z by columns; as it is symmetric, its rows are its columns.
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<Complex<f64>>,
    /// Size of the largest of the terms that make up Z.
    terms: f64,
    /// Room that the factorisation and the solution need.
    room: MemBuffer,
}

impl std::fmt::Debug for SparseFactors {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = formatter.debug_struct("SparseFactors");
        text.field("size", &self.size()).field("entries", &self.values.len()).finish_non_exhaustive()
    }
}

impl Clone for SparseFactors {
    fn clone(&self) -> Self {
        Self {
            symbolic: self.symbolic.clone(),
            numeric: self.numeric.clone(),
            column_starts: self.column_starts.clone(),
            rows: self.rows.clone(),
            values: self.values.clone(),
            terms: self.terms,
            room: room_for(&self.symbolic),
        }
    }
}

/// Room for one factorisation or the solution of one column.
fn room_for(symbolic: &SymbolicLu<usize>) -> MemBuffer {
    let factorisation = symbolic.factorize_numeric_lu_scratch::<Complex<f64>>(Par::Seq, Default::default());
    MemBuffer::new(factorisation.or(symbolic.solve_in_place_scratch::<Complex<f64>>(1, Par::Seq)))
}

impl SparseFactors {
    /// Finds the ordering.
    pub(super) fn new(matrices: &Matrices) -> Result<Self, StructureError> {
        let size = matrices.size;
        let mut column_starts = vec![0; size + 1];
        matrices.places.iter().for_each(|place| column_starts[place.row + 1] += 1);
        (0..size).for_each(|i| column_starts[i + 1] += column_starts[i]);
        let rows: Vec<usize> = matrices.places.iter().map(|place| place.column).collect();
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &column_starts, None, &rows);
        let too_large =
            |_| StructureError::Unavailable { method: "sparse", reason: "there is not enough memory" };
        let symbolic = factorize_symbolic_lu(pattern, Default::default()).map_err(too_large)?;
        Ok(Self {
            numeric: NumericLu::new(),
            values: vec![Complex::new(0.0, 0.0); rows.len()],
            room: room_for(&symbolic),
            symbolic,
            column_starts,
            rows,
            terms: 0.0,
        })
    }

    fn size(&self) -> usize {
        self.column_starts.len() - 1
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
        let size = self.size();
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &self.column_starts, None, &self.rows);
        let matrix = SparseColMatRef::new(pattern, &self.values);
        let stack = MemStack::new(&mut self.room);
        let parameters = Default::default();
        self.symbolic
            .factorize_numeric_lu(&mut self.numeric, matrix, Par::Seq, stack, parameters)
            .map(|_| ())
            .map_err(|_| Singular)
    }

    /// Replaces a right-hand side by the solution.
    pub(super) fn solve(&mut self, column: &mut [Complex<f64>]) -> Result<(), Singular> {
        let largest = |column: &[Complex<f64>]| column.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let size = column.len();
        let load = largest(column);
        let factors = LuRef::new_unchecked(&self.symbolic, &self.numeric);
        let right_hand_side = MatMut::from_column_major_slice_mut(column, size, 1);
        let stack = MemStack::new(&mut self.room);
        factors.solve_in_place_with_conj(Conj::No, right_hand_side, Par::Seq, stack);
        // The pivots are out of sight; a vanishing one shows in a solution beyond all bounds.
        let bound = load / (4.0 * size as f64 * f64::EPSILON * self.terms);
        let bounded = column.iter().all(|value| value.re.is_finite() && value.im.is_finite());
        if bounded && (load == 0.0 || largest(column) < bound) { Ok(()) } else { Err(Singular) }
    }
}
