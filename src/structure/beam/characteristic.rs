//! Natural frequencies and mode shapes from the characteristic equation of the beam, divided at its masses.
//!
//! The segments' exact dynamic stiffness is assembled in the displacements and rotations of the divisions;
//! the structure's natural frequencies are where its determinant vanishes. Wittrick and Williams' count
//! (Q. J. Mech. Appl. Math. 24, 1971) tells how many lie below a trial frequency, so that bisection finds
//! every one, the close and the double included, whatever the determinant looks like.

use nalgebra::{DMatrix, SymmetricEigen, Vector4};

use super::segment::{Segment, SegmentShape};
use crate::model::Beam;

/// Nodes closer than this share of the length are one: a mass at x and another a rounding error away.
const SAME_NODE: f64 = 1e-9;
/// Bisections of the frequency: from a bracket within a factor of two of it down to round-off.
const BISECTIONS: usize = 52;

/// The beam as segments between nodes, with what sits at the nodes.
#[derive(Debug, Clone)]
pub(super) struct Assembly {
    pub(super) segments: Vec<Segment>,
    /// Mass at each node (kg), one more than segments.
    pub(super) masses: Vec<f64>,
    /// Rotational spring at x = 0 (N m/rad); `None` is a rigid clamp.
    clamp_stiffness: Option<f64>,
    /// Rotational spring at x = L (N m/rad).
    end_stiffness: f64,
}

/// A mass-normalised mode.
#[derive(Debug, Clone)]
pub(super) struct Mode {
    pub(super) omega: f64,
    shapes: Vec<SegmentShape>,
    scale: f64,
}

impl Mode {
    /// φ and φ' at `x` (m from the clamp).
    pub(super) fn at(&self, x: f64) -> (f64, f64) {
        let index = self.shapes.partition_point(|shape| shape.segment.start <= x).saturating_sub(1);
        let shape = &self.shapes[index];
        let (value, slope) = shape.at((x - shape.segment.start).clamp(0.0, shape.segment.length));
        (self.scale * value, self.scale * slope)
    }
}

impl Assembly {
    /// Divides `beam` at its masses and at `extra` positions (m), which carry nothing.
    pub(super) fn new(beam: &Beam, extra: &[f64]) -> Self {
        let mut positions = vec![0.0, beam.length];
        positions.extend(beam.point_masses.iter().map(|mass| mass.position));
        positions.extend(extra);
        positions.sort_by(f64::total_cmp);
        positions.dedup_by(|a, b| (*a - *b).abs() <= SAME_NODE * beam.length);
        let mut masses = vec![0.0; positions.len()];
        for mass in &beam.point_masses {
            let node = positions.partition_point(|x| *x < mass.position - SAME_NODE * beam.length);
            masses[node.min(positions.len() - 1)] += mass.mass;
        }
        let segments = positions
            .windows(2)
            .map(|ends| Segment {
                start: ends[0],
                length: ends[1] - ends[0],
                bending_stiffness: beam.youngs_modulus * beam.width * beam.thickness.powi(3) / 12.0,
                mass_per_length: beam.density * beam.width * beam.thickness,
            })
            .collect();
        Self {
            segments,
            masses,
            clamp_stiffness: beam.clamp_stiffness,
            end_stiffness: beam.rotational_stiffness,
        }
    }

    /// Freedoms left by the supports, of the two (w, θ) at every node.
    pub(super) fn free(&self) -> Vec<usize> {
        let last = 2 * self.segments.len();
        let first_rotation = self.clamp_stiffness.map(|_| 1);
        first_rotation.into_iter().chain(2..last).chain([last + 1]).collect()
    }

    /// Sums `element` matrices and `at_nodes` (per freedom) over the free freedoms.
    pub(super) fn assemble(
        &self,
        element: impl Fn(&Segment) -> nalgebra::Matrix4<f64>,
        diagonal: impl Fn(usize) -> f64,
    ) -> DMatrix<f64> {
        let count = 2 * self.masses.len();
        let mut full = DMatrix::zeros(count, count);
        for (index, segment) in self.segments.iter().enumerate() {
            let mut block = full.fixed_view_mut::<4, 4>(2 * index, 2 * index);
            block += element(segment);
        }
        for freedom in 0..count {
            full[(freedom, freedom)] += diagonal(freedom);
        }
        let free = self.free();
        DMatrix::from_fn(free.len(), free.len(), |row, column| full[(free[row], free[column])])
    }

    /// Rotational springs per freedom (N m/rad).
    pub(super) fn spring(&self, freedom: usize) -> f64 {
        match freedom {
            1 => self.clamp_stiffness.unwrap_or(0.0),
            _ if freedom == 2 * self.segments.len() + 1 => self.end_stiffness,
            _ => 0.0,
        }
    }

    /// Point masses per freedom (kg).
    pub(super) fn mass(&self, freedom: usize) -> f64 {
        if freedom % 2 == 0 { self.masses[freedom / 2] } else { 0.0 }
    }

    fn dynamic_stiffness(&self, omega: f64) -> DMatrix<f64> {
        self.assemble(
            |segment| segment.dynamic_stiffness(omega),
            |freedom| self.spring(freedom) - omega * omega * self.mass(freedom),
        )
    }

    /// Natural frequencies below `omega` (rad/s).
    pub(super) fn count_below(&self, omega: f64) -> usize {
        let clamped: usize = self.segments.iter().map(|segment| segment.clamped_count(omega)).sum();
        clamped + negative_pivots(self.dynamic_stiffness(omega))
    }

    /// The first `count` natural frequencies (rad/s), ascending.
    pub(super) fn natural_frequencies(&self, count: usize) -> Vec<f64> {
        let total: f64 = self.segments.iter().map(|segment| segment.length).sum();
        let wave = self.segments[0].wave_number(1.0) * total;
        // Scale of the first frequency: λ of the order of π.
        let mut low = (0.1 / wave).powi(2);
        while self.count_below(low) > 0 {
            low *= 0.5;
        }
        let mut frequencies = Vec::with_capacity(count);
        for index in 0..count {
            let mut high = 2.0 * low;
            while self.count_below(high) <= index {
                low = high;
                high *= 2.0;
            }
            let mut bracket = (low, high);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (bracket.0 + bracket.1);
                if self.count_below(middle) <= index { bracket.0 = middle } else { bracket.1 = middle }
            }
            frequencies.push(0.5 * (bracket.0 + bracket.1));
            low = bracket.0;
        }
        frequencies
    }

    /// The mass-normalised mode at the natural frequency `omega` (rad/s), its slope at x = L positive.
    pub(super) fn mode(&self, omega: f64) -> Mode {
        let eigen = SymmetricEigen::new(self.scaled(self.dynamic_stiffness(omega)));
        let smallest = eigen.eigenvalues.iamin();
        let mut values = vec![0.0; 2 * self.masses.len()];
        for (entry, freedom) in eigen.eigenvectors.column(smallest).iter().zip(self.free()) {
            values[freedom] = entry * self.freedom_scale(freedom);
        }
        let shapes: Vec<SegmentShape> = self
            .segments
            .iter()
            .zip(values.windows(4).step_by(2))
            .map(|(segment, ends)| segment.shape(omega, Vector4::from_column_slice(ends)))
            .collect();
        let mut mode = Mode { omega, shapes, scale: 1.0 };
        let distributed: f64 = self
            .quadrature(omega)
            .map(|(x, weight)| weight * self.segments[0].mass_per_length * mode.at(x).0.powi(2))
            .sum();
        let concentrated: f64 =
            self.masses.iter().enumerate().map(|(node, mass)| mass * values[2 * node].powi(2)).sum();
        let sign = if values[values.len() - 1] < 0.0 { -1.0 } else { 1.0 };
        mode.scale = sign / (distributed + concentrated).sqrt();
        mode
    }

    /// Rotations have a length in them that displacements have not; scaled by it, all freedoms weigh alike
    /// in the search for the vector that the stiffness annihilates.
    fn freedom_scale(&self, freedom: usize) -> f64 {
        if freedom % 2 == 0 { 1.0 } else { self.masses.len() as f64 / self.span() }
    }

    fn span(&self) -> f64 {
        self.segments.iter().map(|segment| segment.length).sum()
    }

    fn scaled(&self, mut matrix: DMatrix<f64>) -> DMatrix<f64> {
        let free = self.free();
        for row in 0..free.len() {
            for column in 0..free.len() {
                matrix[(row, column)] *= self.freedom_scale(free[row]) * self.freedom_scale(free[column]);
            }
        }
        matrix
    }

    /// Points and weights for integrals along the whole beam of products of two modes up to `omega`.
    pub(super) fn quadrature(&self, omega: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.segments.iter().flat_map(move |segment| {
            let panels = (segment.wave_number(omega) * segment.length).ceil().max(1.0) as usize;
            let width = segment.length / panels as f64;
            (0..panels).flat_map(move |panel| {
                let middle = segment.start + (panel as f64 + 0.5) * width;
                GAUSS.iter().flat_map(move |&(point, weight)| {
                    [-point, point].map(|at| (middle + 0.5 * width * at, 0.5 * width * weight))
                })
            })
        })
    }
}

/// Gauss–Legendre, 8 points on [−1, 1]: the positive half. On a panel of one radian the error for the
/// product of two modes is below 1e-15.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Number of negative eigenvalues of a symmetric matrix, as that of negative pivots (Sylvester).
///
/// Without exchange of rows, as the count demands; a pivot that vanishes exactly is moved off zero, for the
/// frequency is then a root to round-off and either count will do.
fn negative_pivots(mut matrix: DMatrix<f64>) -> usize {
    let mut negative = 0;
    for pivot in 0..matrix.nrows() {
        let mut value = matrix[(pivot, pivot)];
        if value == 0.0 {
            value = f64::MIN_POSITIVE;
        }
        negative += usize::from(value < 0.0);
        for row in pivot + 1..matrix.nrows() {
            let factor = matrix[(row, pivot)] / value;
            for column in pivot + 1..matrix.ncols() {
                let change = factor * matrix[(pivot, column)];
                matrix[(row, column)] -= change;
            }
        }
    }
    negative
}
