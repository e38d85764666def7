//! Bending modes of the clamped–pinned beam with point masses, by finite elements of Hermite cubics.

use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

/// Elements of equal length: the six lowest frequencies are then right within 1e-6. A resonance of a lightly damped beam at a
/// harmonic of the drive tells an error of its frequency by a hundredth of its damping ratio.
const ELEMENTS: usize = 120;

/// A beam, clamped at 0 and pinned at its length.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// m.
    pub length: f64,
    /// m.
    pub width: f64,
    /// In the direction of bending (m).
    pub thickness: f64,
    /// kg/m³.
    pub density: f64,
    /// Pa.
    pub youngs_modulus: f64,
    /// Positions (m, of a node: multiples of length/120) and masses (kg).
    pub point_masses: Vec<(f64, f64)>,
    /// Rotational spring in place of the clamp (N m/rad).
    pub clamp_stiffness: Option<f64>,
}

impl Geometry {
    /// E I (N m²).
    pub fn bending_stiffness(&self) -> f64 {
        self.youngs_modulus * self.width * self.thickness.powi(3) / 12.0
    }

    /// E A / L (N/m).
    pub fn axial_stiffness(&self) -> f64 {
        self.youngs_modulus * self.width * self.thickness / self.length
    }
}

/// Modes, mass-normalised.
#[derive(Debug, Clone)]
pub struct Modes {
    /// rad/s, rising.
    pub angular_frequencies: Vec<f64>,
    /// Deflection and slope of each mode at each node: `shapes[mode][2 node]`, `[2 node + 1]`.
    shapes: Vec<Vec<f64>>,
    /// ∫ φ_i' φ_j' dx.
    pub shortening: Vec<Vec<f64>>,
    spacing: f64,
}

impl Modes {
    /// The `count` lowest modes.
    pub fn of(beam: &Geometry, count: usize) -> Self {
        let l = beam.length / ELEMENTS as f64;
        let line_mass = beam.density * beam.width * beam.thickness;
        let stiffness = assemble(
            beam.bending_stiffness() / l.powi(3),
            [
                [12.0, 6.0 * l, -12.0, 6.0 * l],
                [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
                [-12.0, -6.0 * l, 12.0, -6.0 * l],
                [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
            ],
        );
        let mut mass = assemble(
            line_mass * l / 420.0,
            [
                [156.0, 22.0 * l, 54.0, -13.0 * l],
                [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
                [54.0, 13.0 * l, 156.0, -22.0 * l],
                [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
            ],
        );
        let slopes = assemble(
            1.0 / (30.0 * l),
            [
                [36.0, 3.0 * l, -36.0, 3.0 * l],
                [3.0 * l, 4.0 * l * l, -3.0 * l, -l * l],
                [-36.0, -3.0 * l, 36.0, -3.0 * l],
                [3.0 * l, -l * l, -3.0 * l, 4.0 * l * l],
            ],
        );
        for (position, extra) in &beam.point_masses {
            let node = (position / l).round() as usize;
            mass[(2 * node, 2 * node)] += extra;
        }
        let mut stiffness = stiffness;
        let mut fixed = vec![0, 2 * ELEMENTS];
        match beam.clamp_stiffness {
            Some(spring) => stiffness[(1, 1)] += spring,
            None => fixed.push(1),
        }
        let free: Vec<usize> = (0..2 * (ELEMENTS + 1)).filter(|dof| !fixed.contains(dof)).collect();
        let (angular_frequencies, shapes) = solve(&stiffness, &mass, &free, count);
        let shortening = (0..count)
            .map(|i| (0..count).map(|j| product(&slopes, &shapes[i], &shapes[j])).collect())
            .collect();
        Self { angular_frequencies, shapes, shortening, spacing: l }
    }

    /// Deflections of the modes at a node.
    pub fn deflections(&self, position: f64) -> Vec<f64> {
        self.row(2 * (position / self.spacing).round() as usize)
    }

    /// Slopes of the modes at the pin.
    pub fn slopes_at_pin(&self) -> Vec<f64> {
        self.row(2 * ELEMENTS + 1)
    }

    fn row(&self, dof: usize) -> Vec<f64> {
        self.shapes.iter().map(|shape| shape[dof]).collect()
    }
}

fn assemble(factor: f64, element: [[f64; 4]; 4]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(2 * (ELEMENTS + 1), 2 * (ELEMENTS + 1));
    for first in (0..ELEMENTS).map(|index| 2 * index) {
        for (row, values) in element.iter().enumerate() {
            for (column, value) in values.iter().enumerate() {
                matrix[(first + row, first + column)] += factor * value;
            }
        }
    }
    matrix
}

/// K x = ω² M x as M in the coordinates of K's Cholesky factor, whose largest eigenvalues 1/ω² are precise.
fn solve(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    free: &[usize],
    count: usize,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let part = |matrix: &DMatrix<f64>| matrix.select_rows(free).select_columns(free);
    // A held beam's stiffness matrix is positive definite.
    let factor = Cholesky::new(part(stiffness)).expect("stiffness of a held beam").l();
    let half = factor.solve_lower_triangular(&part(mass)).expect("a factor has no zero on its diagonal");
    let whole =
        factor.solve_lower_triangular(&half.transpose()).expect("a factor has no zero on its diagonal");
    let eigen = SymmetricEigen::new(whole);
    let mut order: Vec<usize> = (0..free.len()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    order
        .into_iter()
        .take(count)
        .map(|index| {
            let frequency = 1.0 / eigen.eigenvalues[index].sqrt();
            let vector = eigen.eigenvectors.column(index).clone_owned();
            let vector = factor.transpose().solve_upper_triangular(&vector).expect("as above") * frequency;
            let mut shape = vec![0.0; stiffness.nrows()];
            for (value, dof) in vector.iter().zip(free) {
                shape[*dof] = *value;
            }
            (frequency, shape)
        })
        .unzip()
}

fn product(matrix: &DMatrix<f64>, left: &[f64], right: &[f64]) -> f64 {
    let left = DMatrix::from_column_slice(left.len(), 1, left);
    let right = DMatrix::from_column_slice(right.len(), 1, right);
    (left.transpose() * matrix * right)[(0, 0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bare() -> Geometry {
        Geometry {
            length: 0.6,
            width: 0.04,
            thickness: 0.005,
            density: 7850.0,
            youngs_modulus: 2e11,
            point_masses: Vec::new(),
            clamp_stiffness: None,
        }
    }

    fn wave_numbers(beam: &Geometry) -> Vec<f64> {
        let line_mass = beam.density * beam.width * beam.thickness;
        let modes = Modes::of(beam, 6);
        let number = |w: &f64| (w * w * line_mass / beam.bending_stiffness()).powf(0.25) * beam.length;
        modes.angular_frequencies.iter().map(number).collect()
    }

    #[test]
    fn clamped_pinned_beam_has_its_characteristic_values() {
        // Roots of tan x = tanh x.
        let roots = [3.926602312, 7.068582746, 10.21017612, 13.35176878, 16.49336143, 19.63495408];
        for (found, exact) in wave_numbers(&bare()).iter().zip(roots) {
            assert!((found / exact - 1.0).abs() < 5e-7, "{found} {exact}");
        }
    }

    #[test]
    fn a_clamp_of_no_stiffness_is_a_pin_and_a_stiff_one_a_clamp() {
        let soft = Geometry { clamp_stiffness: Some(1e-6), ..bare() };
        assert!((wave_numbers(&soft)[0] / std::f64::consts::PI - 1.0).abs() < 1e-6);
        let stiff = Geometry { clamp_stiffness: Some(1e12), ..bare() };
        assert!((wave_numbers(&stiff)[0] / 3.926602312 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_mass_lowers_frequencies_by_rayleighs_quotient() {
        let light = Modes::of(&bare(), 1);
        let small = 1e-5;
        let loaded = Modes::of(&Geometry { point_masses: vec![(0.3, small)], ..bare() }, 1);
        let expected = -0.5 * small * light.deflections(0.3)[0].powi(2);
        let found = loaded.angular_frequencies[0] / light.angular_frequencies[0] - 1.0;
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }
}
