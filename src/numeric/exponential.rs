//! Exponential of a matrix, by scaling and squaring: its cost grows with the logarithm of the time.

use nalgebra::DMatrix;

/// Degree of the Taylor polynomial, and the norm for which it ends at rounding.
const DEGREE: usize = 16;
const NORM: f64 = 0.5;
/// Powers that the polynomial is put together from (Paterson & Stockmeyer 1973).
const POWERS: usize = 4;
/// Products that the polynomial takes.
pub(crate) const PRODUCTS: usize = POWERS - 1 + DEGREE / POWERS - 1;

/// Squarings that `exp` of a matrix of this norm takes.
pub(crate) fn squarings(norm: f64) -> i32 {
    (norm / NORM).log2().ceil().max(0.0) as i32
}

/// `exp(matrix)`, whose norm is `norm`.
pub(crate) fn exponential(mut matrix: DMatrix<f64>, norm: f64) -> DMatrix<f64> {
    let squarings = squarings(norm);
    matrix *= 2f64.powi(-squarings);
    let size = matrix.nrows();
    let mut powers = vec![DMatrix::identity(size, size), matrix];
    while powers.len() <= POWERS {
        powers.push(&powers[powers.len() - 1] * &powers[1]);
    }
    let mut factor = 1.0;
    let factors: Vec<f64> = (0..=DEGREE)
        .map(|k| {
            factor /= k.max(1) as f64;
            factor
        })
        .collect();
    let block = |first: usize, last: usize| -> DMatrix<f64> {
        let terms = (first..last).map(|k| &powers[k - first] * factors[k]);
        terms.fold(DMatrix::zeros(size, size), |sum, term| sum + term)
    };
    // The highest power stands by itself in its block.
    let mut sum = block(DEGREE - POWERS, DEGREE + 1);
    for first in (0..DEGREE - POWERS).step_by(POWERS).rev() {
        sum = &sum * &powers[POWERS] + block(first, first + POWERS);
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    sum
}

/// Largest sum of magnitudes of a column or a row, whichever is smaller.
pub(crate) fn norm(matrix: &DMatrix<f64>) -> f64 {
    let columns = matrix.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max);
    let rows = matrix.row_iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    columns.min(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_and_a_chain_of_integrators() {
        for angle in [0.1, 1.0, 40.0, 1e4] {
            let turn = DMatrix::from_row_slice(2, 2, &[0.0, angle, -angle, 0.0]);
            let (sin, cos) = f64::sin_cos(angle);
            let expected = DMatrix::from_row_slice(2, 2, &[cos, sin, -sin, cos]);
            let size = norm(&turn);
            assert!((exponential(turn, size) - expected).amax() < 1e-15 * (10.0 + 10.0 * angle), "{angle}");
        }
        let chain = DMatrix::from_row_slice(3, 3, &[0.0, 3.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0]);
        let expected = DMatrix::from_row_slice(3, 3, &[1.0, 3.0, 4.5, 0.0, 1.0, 3.0, 0.0, 0.0, 1.0]);
        let size = norm(&chain);
        assert!((exponential(chain, size) - expected).amax() < 1e-14);
    }
}
