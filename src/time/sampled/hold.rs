//! A linear structure over a step of fixed length, exactly, under forces that are parabolas over the step.

use nalgebra::{Cholesky, DMatrix, Dyn};

use crate::system::{Entries, LinearStructure, Row};
use crate::time::OscillatorError;

/// Most degrees of freedom: a step costs the square, and its operators the cube, of their number.
pub const MOST_STEPPED: usize = 200;

/// The structure's answers to the forces along its drives and against its contacts, per unit of acceleration.
#[derive(Debug, Clone)]
pub(super) struct Plant {
    pub size: usize,
    /// M⁻¹ K (1/s²) and M⁻¹ C (1/s).
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
    /// M⁻¹ of the drives' rows, then of the contacts' rows, one column each (1/kg).
    forced: DMatrix<f64>,
    /// Rows of the contacts.
    contacts: Vec<Row>,
    drives: usize,
}

/// Operators of one step, all row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct Hold {
    /// Displacements and velocities by those before and by the forces at both ends of the step, row by row:
    /// `[q, v, drives (start, end, bow), contact forces at the start]`.
    pub free: Vec<f64>,
    /// The same by the contact forces at the end, and by their bow.
    pub by_end: Vec<f64>,
    pub by_bow: Vec<f64>,
    /// Displacements and velocities of the contacts by the forces against them at the end.
    pub compliance: Vec<f64>,
    pub mobility: Vec<f64>,
}

fn dense(entries: &Entries, size: usize, field: &'static str) -> Result<DMatrix<f64>, OscillatorError> {
    let mut matrix = DMatrix::zeros(size, size);
    for &(i, j, value) in entries {
        if i >= size || j >= size || !value.is_finite() {
            return Err(OscillatorError::Structure { field });
        }
        matrix[(i, j)] += value;
    }
    Ok(matrix)
}

fn check(row: &Row, size: usize, field: &'static str) -> Result<(), OscillatorError> {
    let legal = row.iter().all(|(i, value)| *i < size && value.is_finite());
    if legal { Ok(()) } else { Err(OscillatorError::Structure { field }) }
}

impl Plant {
    pub fn new(structure: &LinearStructure, drives: &[Row]) -> Result<Self, OscillatorError> {
        let size = structure.size;
        if size == 0 {
            return Err(OscillatorError::Structure { field: "size" });
        }
        if size > MOST_STEPPED {
            return Err(OscillatorError::TooLarge { size, most: MOST_STEPPED });
        }
        let mass: Cholesky<f64, Dyn> =
            Cholesky::new(dense(&structure.mass, size, "mass")?).ok_or(OscillatorError::MassNotPositive)?;
        let mut rows = DMatrix::zeros(size, drives.len() + structure.contacts.len());
        for (column, row) in drives.iter().chain(&structure.contacts).enumerate() {
            check(row, size, "contacts")?;
            row.iter().for_each(|(i, value)| rows[(*i, column)] += value);
        }
        Ok(Self {
            size,
            stiffness: mass.solve(&dense(&structure.stiffness, size, "stiffness")?),
            damping: mass.solve(&dense(&structure.damping, size, "damping")?),
            forced: mass.solve(&rows),
            contacts: structure.contacts.clone(),
            drives: drives.len(),
        })
    }

    /// Accelerations by displacements, velocities, drives and contact forces, row by row.
    pub fn acceleration(&self) -> Vec<f64> {
        let (n, drives) = (self.size, self.drives);
        let mut rows = Vec::with_capacity(n * (2 * n + self.forced.ncols()));
        for i in 0..n {
            rows.extend((0..n).map(|j| -self.stiffness[(i, j)]));
            rows.extend((0..n).map(|j| -self.damping[(i, j)]));
            rows.extend((0..self.forced.ncols()).map(|j| {
                let sign = if j < drives { 1.0 } else { -1.0 };
                sign * self.forced[(i, j)]
            }));
        }
        rows
    }

    /// The operators of a step of `h` (s).
    ///
    /// Van Loan's exponential (IEEE Trans. Automatic Control 23, 1978) of the motion in `(q, h v)` with chains of
    /// integrators behind the forces gives the answers to `1`, `s` and `s²/2` at once, s from 0 to 1 over the step.
    pub fn hold(&self, h: f64) -> Result<Hold, OscillatorError> {
        let (n, forces) = (self.size, self.forced.ncols());
        let (state, order) = (2 * n, 2 * n + 3 * forces);
        let mut generator = DMatrix::zeros(order, order);
        generator.view_mut((0, n), (n, n)).fill_with_identity();
        generator.view_mut((n, 0), (n, n)).copy_from(&(&self.stiffness * (-h * h)));
        generator.view_mut((n, n), (n, n)).copy_from(&(&self.damping * -h));
        generator.view_mut((n, state), (n, forces)).copy_from(&(&self.forced * (h * h)));
        generator.view_mut((state, state + forces), (2 * forces, 2 * forces)).fill_with_identity();
        let all = generator.exp();
        if !all.iter().all(|value| value.is_finite()) {
            return Err(OscillatorError::Input { name: "step", value: h });
        }
        // Back from h v to v, in rows and columns.
        let back = |i: usize| if i < n { 1.0 } else { 1.0 / h };
        let answer =
            |i: usize, power: usize, force: usize| all[(i, state + power * forces + force)] * back(i);
        let end = |i, force| answer(i, 1, force);
        let bow = |i, force| answer(i, 1, force) - 2.0 * answer(i, 2, force);
        let mut hold = Hold::default();
        let (drives, contacts) = (self.drives, self.drives..forces);
        for i in 0..state {
            hold.free.extend((0..state).map(|j| all[(i, j)] * back(i) / back(j)));
            for drive in 0..drives {
                hold.free.extend([answer(i, 0, drive) - end(i, drive), end(i, drive), bow(i, drive)]);
            }
            hold.free.extend(contacts.clone().map(|contact| end(i, contact) - answer(i, 0, contact)));
            hold.by_end.extend(contacts.clone().map(|contact| -end(i, contact)));
            hold.by_bow.extend(contacts.clone().map(|contact| -bow(i, contact)));
        }
        for row in &self.contacts {
            for contact in contacts.clone() {
                let along = |from: usize| row.iter().map(|(i, b)| b * end(from + i, contact)).sum::<f64>();
                hold.compliance.push(along(0));
                hold.mobility.push(along(n));
            }
        }
        Ok(hold)
    }
}
