//! A linear structure condensed to the points that matter: its dynamic compliances.

use nalgebra::{Complex, DMatrix};

use super::StructureError;
use super::linear::{LinearStructure, Row};

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

/// Evaluates compliances of one structure.
#[derive(Debug)]
pub struct Receptance {
    mass: DMatrix<Complex<f64>>,
    damping: DMatrix<Complex<f64>>,
    stiffness: DMatrix<Complex<f64>>,
    contacts: Vec<Row>,
    excitation: Row,
    outputs: Vec<Row>,
}

impl Receptance {
    /// Prepares the evaluation.
    ///
    /// # Errors
    /// A structure that cannot be condensed.
    pub fn new(structure: &LinearStructure) -> Result<Self, StructureError> {
        let dense = |entries: &[(usize, usize, f64)]| {
            let mut matrix = DMatrix::zeros(structure.size, structure.size);
            entries.iter().for_each(|(i, j, value)| matrix[(*i, *j)] = Complex::new(*value, 0.0));
            matrix
        };
        Ok(Self {
            mass: dense(&structure.mass),
            damping: dense(&structure.damping),
            stiffness: dense(&structure.stiffness),
            contacts: structure.contacts.clone(),
            excitation: structure.excitation.clone(),
            outputs: structure.outputs.iter().map(|output| output.row.clone()).collect(),
        })
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.contacts.len()
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// A buffer for [`Receptance::evaluate`].
    pub fn compliance(&self, rows: Rows) -> Compliance {
        let outputs = if rows == Rows::All { self.outputs.len() } else { 0 };
        let zeros = DMatrix::zeros(self.contacts.len() + outputs, self.contacts.len() + 1);
        Compliance { value: zeros.clone(), by_damping: zeros.clone(), by_inertia: zeros }
    }

    /// Compliances of `Z = K + damping · C + inertia · M`. A harmonic h of the fundamental Ω has
    /// `damping = ihΩ` and `inertia = −h²Ω²`; for the bias both are zero.
    ///
    /// # Errors
    /// [`StructureError::NotComputable`] where Z is singular.
    pub fn evaluate(
        &mut self,
        damping: Complex<f64>,
        inertia: Complex<f64>,
        rows: Rows,
        out: &mut Compliance,
    ) -> Result<(), StructureError> {
        let dynamic = &self.stiffness + &self.damping * damping + &self.mass * inertia;
        let n = self.mass.nrows();
        let columns = self.contacts.len() + 1;
        let mut forces = DMatrix::zeros(n, columns);
        for (k, row) in self.contacts.iter().chain([&self.excitation]).enumerate() {
            row.iter().for_each(|(i, factor)| forces[(*i, k)] += Complex::new(*factor, 0.0));
        }
        let outputs: &[Row] = if rows == Rows::All { &self.outputs } else { &[] };
        let points: Vec<&Row> = self.contacts.iter().chain(outputs).collect();
        let mut observers = DMatrix::zeros(n, points.len());
        for (k, row) in points.iter().enumerate() {
            row.iter().for_each(|(i, factor)| observers[(*i, k)] += Complex::new(*factor, 0.0));
        }
        let factors = dynamic.lu();
        let singular = StructureError::NotComputable { quantity: "dynamic compliance", value: f64::INFINITY };
        let moved = factors.solve(&forces).ok_or(singular.clone())?;
        // Z is symmetric: the observers' rows of its inverse are solutions too.
        let seen = factors.solve(&observers).ok_or(singular)?;
        out.value = observers.transpose() * &moved;
        out.by_damping = -(seen.transpose() * &self.damping * &moved);
        out.by_inertia = -(seen.transpose() * &self.mass * &moved);
        Ok(())
    }
}
