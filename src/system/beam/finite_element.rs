//! The same beam by Hermite-cubic finite elements: an independent check of the exact solution.
//!
//! Shares nothing with the characteristic solution but the model: own mesh, own matrices, own
//! eigensolver. The frequencies converge from above with the fourth power of the element length.

use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

use super::checks::{check_mechanics, check_mode_count};
use crate::system::{Beam, StructureError};

/// Most elements: the dense eigenproblem has twice as many unknowns and costs their third power.
const MOST_ELEMENTS: usize = 400;

/// A mass nearer to its neighbour (or an end) than this part of an element gets no node of its own, since
/// very short elements spoil the stiffness matrix; its shape functions carry it.
const SHORTEST_PART: f64 = 0.25;

/// Rounds allowed to the eigensolver; it needs a few per unknown.
const MOST_ROUNDS: usize = 100_000;

/// Mass-normalised finite-element modes of a beam, positive in slope at x = L.
#[derive(Debug, Clone, PartialEq)]
pub struct FiniteElementModes {
    length: f64,
    /// Fractions of the length.
    nodes: Vec<f64>,
    angular_frequency: Vec<f64>,
    /// Deflection and slope (per beam length) of each node, a column per mode (kg^-1/2).
    coordinates: DMatrix<f64>,
    /// ∫ N' N'ᵀ over all unknowns (1).
    slope_gram: DMatrix<f64>,
}

impl FiniteElementModes {
    /// The first `count` modes with about `elements` elements: nodes at the masses, parts divided evenly.
    ///
    /// # Errors
    /// Values out of bounds as in [`ModalBeam::new`](crate::system::ModalBeam::new),
    /// [`StructureError::ElementCount`], or [`StructureError::NotComputable`] where rounding makes the
    /// stiffness indefinite.
    pub fn new(beam: &Beam, elements: usize, count: usize) -> Result<Self, StructureError> {
        check_mechanics(beam)?;
        check_mode_count(count)?;
        let least = count + 1;
        if !(least..=MOST_ELEMENTS).contains(&elements) {
            return Err(StructureError::ElementCount { elements, least, most: MOST_ELEMENTS });
        }
        Self::of(beam, System::assemble(beam, elements), count)
    }

    /// The modes of `system`, which is the beam with what may be fixed to its end.
    pub(in crate::system) fn of(beam: &Beam, system: System, count: usize) -> Result<Self, StructureError> {
        let (eigenvalues, coordinates) = system.solve(count)?;
        let area = beam.width * beam.thickness;
        let bending = beam.youngs_modulus * area * beam.thickness.powi(2) / 12.0;
        let mass = beam.density * area * beam.length;
        let stiffness_over_mass = bending / (mass * beam.length.powi(3));
        Ok(Self {
            length: beam.length,
            nodes: system.nodes,
            angular_frequency: eigenvalues.iter().map(|value| (stiffness_over_mass * value).sqrt()).collect(),
            coordinates: coordinates / mass.sqrt(),
            slope_gram: system.slope_gram,
        })
    }

    /// A mode's values of the unknowns beside those of the beam (kg^-1/2).
    pub(in crate::system) fn beside(&self, mode: usize) -> Vec<f64> {
        self.coordinates.column(mode).iter().skip(2 * self.nodes.len()).copied().collect()
    }

    /// ωᵢ (rad/s), ascending.
    pub fn angular_frequency(&self) -> &[f64] {
        &self.angular_frequency
    }

    /// φᵢ(x) (kg^-1/2); `mode` counts from 0, `x` (m) is taken into the beam if outside. `None` when
    /// there is no such mode.
    pub fn displacement(&self, mode: usize, x: f64) -> Option<f64> {
        let (element, shape) = self.locate(x, hermite);
        self.combine(mode, element, shape)
    }

    /// φᵢ'(x) (kg^-1/2 m^-1); arguments as for [`displacement`](Self::displacement).
    pub fn slope(&self, mode: usize, x: f64) -> Option<f64> {
        let (element, shape) = self.locate(x, hermite_slope);
        self.combine(mode, element, shape).map(|slope| slope / self.length)
    }

    /// Gᵢⱼ = ∫ φᵢ' φⱼ' dx (1/(kg m)), row-major.
    pub fn shortening(&self) -> Vec<f64> {
        let gram = self.coordinates.transpose() * &self.slope_gram * &self.coordinates;
        gram.transpose().iter().map(|entry| entry / self.length).collect()
    }

    fn locate(&self, x: f64, shape: fn(f64, f64) -> [f64; 4]) -> (usize, [f64; 4]) {
        let position = (x / self.length).clamp(0.0, 1.0);
        let element = element_at(&self.nodes, position);
        let (start, size) = (self.nodes[element], self.nodes[element + 1] - self.nodes[element]);
        (element, shape((position - start) / size, size))
    }

    fn combine(&self, mode: usize, element: usize, shape: [f64; 4]) -> Option<f64> {
        let column = (mode < self.coordinates.ncols()).then(|| self.coordinates.column(mode))?;
        Some((0..4).map(|local| shape[local] * column[2 * element + local]).sum())
    }
}

/// The element that holds a position, by its left node.
fn element_at(nodes: &[f64], position: f64) -> usize {
    nodes.partition_point(|&node| node <= position).saturating_sub(1).min(nodes.len() - 2)
}

/// Hermite cubics of (w₁, w₁', w₂, w₂') at ξ of an element of length h.
fn hermite(xi: f64, h: f64) -> [f64; 4] {
    let square = xi * xi;
    [
        1.0 - square * (3.0 - 2.0 * xi),
        h * xi * (1.0 - xi) * (1.0 - xi),
        square * (3.0 - 2.0 * xi),
        h * square * (xi - 1.0),
    ]
}

/// Their derivatives.
fn hermite_slope(xi: f64, h: f64) -> [f64; 4] {
    let bow = 6.0 * xi * (1.0 - xi) / h;
    [-bow, (1.0 - xi) * (1.0 - 3.0 * xi), bow, xi * (3.0 * xi - 2.0)]
}

/// Stiffness, mass and slope products of one element of length h, for unit EI and ρA.
fn element_matrices(h: f64) -> [[[f64; 4]; 4]; 3] {
    let (h2, h3) = (h * h, h * h * h);
    let stiffness = [
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h2, -6.0 * h, 2.0 * h2],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h2, -6.0 * h, 4.0 * h2],
    ];
    let mass = [
        [156.0, 22.0 * h, 54.0, -13.0 * h],
        [22.0 * h, 4.0 * h2, 13.0 * h, -3.0 * h2],
        [54.0, 13.0 * h, 156.0, -22.0 * h],
        [-13.0 * h, -3.0 * h2, -22.0 * h, 4.0 * h2],
    ];
    let slope = [
        [36.0, 3.0 * h, -36.0, 3.0 * h],
        [3.0 * h, 4.0 * h2, -3.0 * h, -h2],
        [-36.0, -3.0 * h, 36.0, -3.0 * h],
        [3.0 * h, -h2, -3.0 * h, 4.0 * h2],
    ];
    let scaled = |matrix: [[f64; 4]; 4], factor: f64| matrix.map(|row| row.map(|entry| factor * entry));
    [scaled(stiffness, 1.0 / h3), scaled(mass, h / 420.0), scaled(slope, 1.0 / (30.0 * h))]
}

/// Matrices of the whole beam for unit length, EI and ρA, over deflection and slope of every node.
pub(in crate::system) struct System {
    pub nodes: Vec<f64>,
    pub stiffness: DMatrix<f64>,
    pub mass: DMatrix<f64>,
    pub slope_gram: DMatrix<f64>,
    /// Unknowns the supports leave free.
    pub free: Vec<usize>,
}

impl System {
    /// The beam on its pin.
    pub fn assemble(beam: &Beam, elements: usize) -> Self {
        let nodes = mesh(beam, elements);
        let size = 2 * nodes.len();
        let [mut stiffness, mut mass, mut slope_gram] = std::array::from_fn(|_| DMatrix::zeros(size, size));
        for (element, ends) in nodes.windows(2).enumerate() {
            let local = element_matrices(ends[1] - ends[0]);
            for (matrix, local) in [&mut stiffness, &mut mass, &mut slope_gram].into_iter().zip(local) {
                for (row, entries) in local.into_iter().enumerate() {
                    for (column, entry) in entries.into_iter().enumerate() {
                        matrix[(2 * element + row, 2 * element + column)] += entry;
                    }
                }
            }
        }
        let beam_mass = beam.density * beam.width * beam.thickness * beam.length;
        for point in &beam.point_masses {
            let position = point.position / beam.length;
            let element = element_at(&nodes, position);
            let h = nodes[element + 1] - nodes[element];
            let shape = hermite((position - nodes[element]) / h, h);
            for row in 0..4 {
                for column in 0..4 {
                    mass[(2 * element + row, 2 * element + column)] +=
                        point.mass / beam_mass * shape[row] * shape[column];
                }
            }
        }
        let bending = beam.youngs_modulus * beam.width * beam.thickness.powi(3) / 12.0;
        stiffness[(size - 1, size - 1)] += beam.rotational_stiffness * beam.length / bending;
        let clamp = beam.clamp_stiffness.map(|spring| spring * beam.length / bending);
        stiffness[(1, 1)] += clamp.unwrap_or(0.0);
        let held = |unknown: usize| unknown == 0 || unknown == size - 2 || (unknown == 1 && clamp.is_none());
        let free = (0..size).filter(|&unknown| !held(unknown)).collect();
        Self { nodes, stiffness, mass, slope_gram, free }
    }

    /// Eigenvalues ω² (ascending) and mass-normalised eigenvectors over all unknowns.
    ///
    /// Cholesky reduction with the *stiffness*: its inverse makes the lowest modes the largest eigenvalues,
    /// which the symmetric solver gives to full relative precision.
    pub fn solve(&self, count: usize) -> Result<(Vec<f64>, DMatrix<f64>), StructureError> {
        let failed = |value| StructureError::NotComputable { quantity: "finite-element stiffness", value };
        let reduced = |matrix: &DMatrix<f64>| matrix.select_rows(&self.free).select_columns(&self.free);
        let (stiffness, mass) = (reduced(&self.stiffness), reduced(&self.mass));
        let finite = stiffness.iter().chain(mass.iter()).all(|entry| entry.is_finite());
        let lower =
            finite.then(|| Cholesky::new(stiffness)).flatten().ok_or_else(|| failed(f64::NAN))?.unpack();
        let half = lower.solve_lower_triangular(&mass).ok_or_else(|| failed(0.0))?;
        let flexibility = lower.solve_lower_triangular(&half.transpose()).ok_or_else(|| failed(0.0))?;
        let eigen = SymmetricEigen::try_new(flexibility, f64::EPSILON, MOST_ROUNDS)
            .ok_or_else(|| failed(f64::INFINITY))?;
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let mut eigenvalues = Vec::with_capacity(count);
        let mut coordinates = DMatrix::zeros(self.stiffness.nrows(), count);
        for (mode, &index) in order.iter().take(count).enumerate() {
            let modal_mass = eigen.eigenvalues[index];
            let vector = lower
                .tr_solve_lower_triangular(&eigen.eigenvectors.column(index))
                .ok_or_else(|| failed(0.0))?;
            // The last unknown is the slope at the pin.
            let sign = vector.iter().next_back().map_or(1.0, |slope| slope.signum());
            for (&unknown, entry) in self.free.iter().zip(vector.iter()) {
                coordinates[(unknown, mode)] = sign * entry / modal_mass.sqrt();
            }
            eigenvalues.push(1.0 / modal_mass);
        }
        Ok((eigenvalues, coordinates))
    }
}

/// Nodes at the ends and masses, parts between them divided into elements of about equal length.
fn mesh(beam: &Beam, elements: usize) -> Vec<f64> {
    let nominal = 1.0 / elements as f64;
    let mut breaks: Vec<f64> = beam.point_masses.iter().map(|point| point.position / beam.length).collect();
    breaks.sort_by(f64::total_cmp);
    let mut nodes = vec![0.0];
    let mut start = 0.0;
    for end in breaks.into_iter().filter(|position| 1.0 - position > SHORTEST_PART * nominal).chain([1.0]) {
        if end - start <= SHORTEST_PART * nominal {
            continue;
        }
        let pieces = ((end - start) / nominal).round().max(1.0) as usize;
        nodes.extend((1..pieces).map(|piece| start + (end - start) * piece as f64 / pieces as f64));
        nodes.push(end);
        start = end;
    }
    nodes
}
