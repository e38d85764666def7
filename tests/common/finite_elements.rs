//! A finite-element beam of the tests' own, independent of the library's reduction: Hermite elements,
//! clamped at x = 0, pinned at x = L, lumped masses at nodes.

use nalgebra::{DMatrix, SymmetricEigen};
use stickslip::system::{ModalBeam, Sensor};

use super::beam::modal;

/// The published beam with a frictional support: 600 × 40 × 5 mm steel, 25.15 g at the exciter.
pub fn published_beam(modes: usize, elements: usize) -> ModalBeam {
    let masses = [(0.55, 25.15e-3), (0.3, 5e-3), (0.1, 5e-3)];
    beam(197.1e9, &masses, 0.003, modes, elements)
}

/// Beam of those dimensions with Young's modulus `youngs_modulus` (Pa), point masses `(m, kg)` at nodes
/// of the mesh and one damping ratio.
pub fn beam(
    youngs_modulus: f64,
    masses: &[(f64, f64)],
    damping_ratio: f64,
    modes: usize,
    elements: usize,
) -> ModalBeam {
    let (length, width, thickness, density, offset) = (0.6, 0.04, 0.005, 7850.0, 0.006);
    let area = width * thickness;
    let bending = youngs_modulus * width * thickness * thickness * thickness / 12.0;
    let line_mass = density * area;
    let l = length / elements as f64;
    let size = 2 * (elements + 1);
    let (mut mass, mut stiffness, mut slope): (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) =
        (DMatrix::zeros(size, size), DMatrix::zeros(size, size), DMatrix::zeros(size, size));
    let m = [
        [156.0, 22.0 * l, 54.0, -13.0 * l],
        [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
        [54.0, 13.0 * l, 156.0, -22.0 * l],
        [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
    ];
    let k = [
        [12.0, 6.0 * l, -12.0, 6.0 * l],
        [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
        [-12.0, -6.0 * l, 12.0, -6.0 * l],
        [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
    ];
    let g = [
        [36.0, 3.0 * l, -36.0, 3.0 * l],
        [3.0 * l, 4.0 * l * l, -3.0 * l, -l * l],
        [-36.0, -3.0 * l, 36.0, -3.0 * l],
        [3.0 * l, -l * l, -3.0 * l, 4.0 * l * l],
    ];
    for e in 0..elements {
        for i in 0..4 {
            for j in 0..4 {
                let at = (2 * e + i, 2 * e + j);
                mass[at] += line_mass * l / 420.0 * m[i][j];
                stiffness[at] += bending / (l * l * l) * k[i][j];
                slope[at] += g[i][j] / (30.0 * l);
            }
        }
    }
    let node = |x: f64| (x / l).round() as usize;
    for (x, m) in masses {
        mass[(2 * node(*x), 2 * node(*x))] += m;
    }
    // Kept: everything but the clamp's two and the pin's displacement.
    let kept: Vec<usize> = (2..size).filter(|i| *i != size - 2).collect();
    let reduce = |a: &DMatrix<f64>| DMatrix::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
    let factor = reduce(&mass).cholesky().expect("the mass matrix is positive definite");
    let half = factor.l().solve_lower_triangular(&reduce(&stiffness)).expect("regular");
    let full = factor.l().solve_lower_triangular(&half.transpose()).expect("regular");
    let eigen = SymmetricEigen::new(0.5 * (&full + full.transpose()));
    let mut order: Vec<usize> = (0..kept.len()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let shapes: Vec<Vec<f64>> = order[..modes]
        .iter()
        .map(|k| {
            let column = eigen.eigenvectors.column(*k).clone_owned();
            let phi = factor.l().transpose().solve_upper_triangular(&column).expect("regular");
            let mut all = vec![0.0; size];
            kept.iter().zip(phi.iter()).for_each(|(i, x)| all[*i] = *x);
            all
        })
        .collect();
    let at = |x: f64| -> Vec<f64> { shapes.iter().map(|s| s[2 * node(x)]).collect() };
    let mut shortening = vec![0.0; modes * modes];
    for i in 0..modes {
        for j in 0..modes {
            for a in 0..size {
                for b in a.saturating_sub(3)..(a + 4).min(size) {
                    shortening[i * modes + j] += shapes[i][a] * slope[(a, b)] * shapes[j][b];
                }
            }
        }
    }
    let omega: Vec<f64> = order[..modes].iter().map(|k| eigen.eigenvalues[*k].sqrt()).collect();
    let contact: Vec<f64> = shapes.iter().map(|s| offset * s[size - 1]).collect();
    ModalBeam {
        shortening,
        axial_flexibility: length / (youngs_modulus * area),
        sensors: [0.55, 0.3, 0.1].iter().map(|x| Sensor { position: *x, shape: at(*x) }).collect(),
        ..modal(&omega, &vec![damping_ratio; modes], &contact, &at(0.55))
    }
}
