//! What a structure answers between its points.

use nalgebra::{Complex, DMatrix};

/// Compliances (m/N) of a linear structure at one pair of factors, and their derivatives.
///
/// Rows: the contacts, then (where asked for) the outputs. Columns: a unit force along each contact's
/// displacement, then the unit excitation.
#[derive(Debug, Clone, PartialEq)]
pub struct Compliance {
    /// The compliances.
    pub value: DMatrix<Complex<f64>>,
    /// Derivative by the damping factor.
    pub by_damping: DMatrix<Complex<f64>>,
    /// Derivative by the inertia factor.
    pub by_inertia: DMatrix<Complex<f64>>,
}

/// Rows wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// The contacts alone.
    Contacts,
    /// The contacts, then the outputs.
    All,
}

/// The dynamic stiffness cannot be inverted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Singular;
