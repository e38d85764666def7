//! A linear structure condensed to the points that matter: its dynamic compliances.
//!
//! Three ways to the same numbers ([`Method`]), of which [`Receptance::new`] takes the cheapest that holds:
//!
//! - **modal**: where the undamped modes diagonalise the damping matrix (`C M⁻¹ K` symmetric to rounding;
//!   Caughey & O'Kelly 1965) a compliance is a sum over modes, `Σ bᵣ eᵣ / (ωᵣ² + d cᵣ + s)`, with all modes
//!   kept: nothing is truncated.
//! - **dense**: complex LU factors of `Z = K + d C + s M` with partial pivoting; effort ∝ size³.
//! - **sparse**: the same of a sparse Z, its ordering found once; effort ∝ size for a chain.
//!
//! Derivatives by the factors come from the same solutions, as `∂Z⁻¹ = −Z⁻¹ ∂Z Z⁻¹` and Z is symmetric.
//! In [`Receptance::evaluate`] the sparse factors alone allocate: fifteen times, at any size.

mod compliance;
mod condensation;
mod lu;
mod modal;
mod sparse;
#[cfg(test)]
mod tests;

use nalgebra::{Complex, DMatrix};

pub use compliance::{Compliance, Rows};

use super::StructureError;
use super::linear::LinearStructure;
use compliance::Singular;
use condensation::{Condensation, Matrices};
use lu::DenseFactors;
use modal::Modal;

/// Largest structure that is factorised as a dense matrix.
const MOST_DENSE: usize = 40;

/// How compliances are computed; see the module's documentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Sums over undamped modes.
    Modal,
    /// Factors of a dense matrix.
    Dense,
    /// Factors of a sparse matrix.
    Sparse,
}

/// Evaluates compliances of one structure.
#[derive(Debug, Clone)]
pub struct Receptance {
    contacts: usize,
    outputs: usize,
    /// Outputs that move with a part that nothing holds, if there is one.
    free: Option<String>,
    solver: Solver,
}

#[derive(Debug, Clone)]
enum Solver {
    Modal(Modal),
    Dense(Condensation, DenseFactors),
    Sparse(Condensation, Box<sparse::SparseFactors>),
}

impl Receptance {
    /// Prepares the evaluation, by the cheapest way that holds for the structure.
    ///
    /// # Errors
    /// [`StructureError::NoSuchFreedom`] for a row or an entry beyond the structure's size,
    /// [`StructureError::NotComputable`] for an entry that is not finite,
    /// [`StructureError::NotSymmetric`] for a matrix that lacks its other triangle.
    pub fn new(structure: &LinearStructure) -> Result<Self, StructureError> {
        check(structure)?;
        if let Some(modal) = Modal::new(structure) {
            return Ok(Self::with_solver(structure, Solver::Modal(modal)));
        }
        if structure.size > MOST_DENSE {
            return Self::with_method(structure, Method::Sparse);
        }
        Self::with_method(structure, Method::Dense)
    }

    /// Prepares the evaluation by one way, whether it is the cheapest or not.
    ///
    /// # Errors
    /// As [`Receptance::new`]; [`StructureError::Unavailable`] for modes that do not diagonalise the damping
    /// or are too many.
    pub fn with_method(structure: &LinearStructure, method: Method) -> Result<Self, StructureError> {
        check(structure)?;
        let solver = match method {
            Method::Modal => Solver::Modal(Modal::new(structure).ok_or(StructureError::Unavailable {
                method: "modal",
                reason: "the modes are too many, or do not diagonalise the damping",
            })?),
            Method::Dense => {
                let matrices = Matrices::new(structure);
                Solver::Dense(Condensation::new(structure, matrices), DenseFactors::new(structure.size))
            }
            Method::Sparse => {
                let matrices = Matrices::new(structure);
                let factors = Box::new(sparse::SparseFactors::new(&matrices)?);
                Solver::Sparse(Condensation::new(structure, matrices), factors)
            }
        };
        Ok(Self::with_solver(structure, solver))
    }

    fn with_solver(structure: &LinearStructure, solver: Solver) -> Self {
        Self {
            contacts: structure.contacts.len(),
            outputs: structure.outputs.len(),
            free: free_part(structure),
            solver,
        }
    }

    /// How the compliances are computed.
    pub fn method(&self) -> Method {
        match &self.solver {
            Solver::Modal(_) => Method::Modal,
            Solver::Dense(..) => Method::Dense,
            Solver::Sparse(..) => Method::Sparse,
        }
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// A buffer for [`Receptance::evaluate`].
    pub fn compliance(&self, rows: Rows) -> Compliance {
        let zeros = DMatrix::zeros(self.rows(rows), self.contacts + 1);
        Compliance { value: zeros.clone(), by_damping: zeros.clone(), by_inertia: zeros }
    }

    fn rows(&self, rows: Rows) -> usize {
        self.contacts + if rows == Rows::All { self.outputs } else { 0 }
    }

    /// Compliances of `Z = K + damping · C + inertia · M`. A harmonic h of the fundamental Ω has
    /// `damping = ihΩ` and `inertia = −h²Ω²`; for the bias both are zero.
    ///
    /// `out` is a buffer from [`Receptance::compliance`] for the same rows; one of another shape is replaced.
    ///
    /// # Errors
    /// Where Z is singular: [`StructureError::FreeBody`] for a bias that nothing holds,
    /// [`StructureError::UndampedResonance`] at any other pair of factors.
    /// [`StructureError::NotComputable`] for factors that are not finite.
    pub fn evaluate(
        &mut self,
        damping: Complex<f64>,
        inertia: Complex<f64>,
        rows: Rows,
        out: &mut Compliance,
    ) -> Result<(), StructureError> {
        if let Some(value) =
            [damping.re, damping.im, inertia.re, inertia.im].into_iter().find(|value| !value.is_finite())
        {
            return Err(StructureError::NotComputable { quantity: "angular frequency", value });
        }
        if out.value.shape() != (self.rows(rows), self.contacts + 1) {
            *out = self.compliance(rows);
        }
        let done = match &mut self.solver {
            Solver::Modal(modal) => modal.evaluate(damping, inertia, rows, out),
            Solver::Dense(condensation, factors) => factors
                .factorise(condensation.matrices(), damping, inertia)
                .and_then(|()| condensation.fill(rows, |column| factors.solve(column), out)),
            Solver::Sparse(condensation, factors) => factors
                .factorise(condensation.matrices(), damping, inertia)
                .and_then(|()| condensation.fill(rows, |column| factors.solve(column), out)),
        };
        done.map_err(|Singular| self.singular(damping, inertia))
    }

    fn singular(&self, damping: Complex<f64>, inertia: Complex<f64>) -> StructureError {
        let zero = Complex::new(0.0, 0.0);
        if damping == zero && inertia == zero {
            let part = self.free.clone().unwrap_or_else(|| "a part of the structure".to_owned());
            StructureError::FreeBody { part }
        } else {
            StructureError::UndampedResonance { angular_frequency: inertia.norm().sqrt() }
        }
    }
}

/// Refuses what is empty, out of range or not a number.
fn check(structure: &LinearStructure) -> Result<(), StructureError> {
    let size = structure.size;
    let inside = |index: usize| {
        if index < size { Ok(()) } else { Err(StructureError::NoSuchFreedom { index, size }) }
    };
    inside(0)?;
    let finite = |value: f64| {
        if value.is_finite() {
            Ok(())
        } else {
            Err(StructureError::NotComputable { quantity: "matrix or row of the structure", value })
        }
    };
    for (i, j, value) in structure.mass.iter().chain(&structure.damping).chain(&structure.stiffness) {
        inside(*i)?;
        inside(*j)?;
        finite(*value)?;
    }
    let outputs = structure.outputs.iter().map(|output| &output.row);
    for (i, value) in structure.contacts.iter().chain([&structure.excitation]).chain(outputs).flatten() {
        inside(*i)?;
        finite(*value)?;
    }
    structure.check_symmetry()
}

/// Names of the outputs that move with a part of the structure that may be shifted as a whole without any
/// force, if there is such a part.
fn free_part(structure: &LinearStructure) -> Option<String> {
    let size = structure.size;
    // Each degree of freedom points towards the representative of its part.
    let mut parent: Vec<usize> = (0..size).collect();
    fn representative(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let (mut sum, mut magnitude) = (vec![0.0; size], vec![0.0; size]);
    for (i, j, value) in &structure.stiffness {
        sum[*i] += value;
        magnitude[*i] += value.abs();
        let (left, right) = (representative(&mut parent, *i), representative(&mut parent, *j));
        parent[left] = right;
    }
    let mut held = vec![false; size];
    for i in 0..size {
        let part = representative(&mut parent, i);
        held[part] |= f64::abs(sum[i]) > 8.0 * f64::EPSILON * magnitude[i];
    }
    let mut is_free = |i: usize| !held[representative(&mut parent, i)];
    let names: Vec<&str> = structure
        .outputs
        .iter()
        .filter(|output| output.row.iter().any(|(i, factor)| *factor != 0.0 && is_free(*i)))
        .map(|output| output.name.as_str())
        .collect();
    match names.as_slice() {
        [] => None,
        [one] => Some(format!("`{one}`")),
        [first, second] => Some(format!("`{first}` with `{second}`")),
        [first, .., last] => Some(format!("`{first}` … `{last}` ({} outputs)", names.len())),
    }
}
