//! Least squares of which no unknown may be negative.

use nalgebra::{DMatrix, DVector};

/// Gradients below this part of the largest count as zero.
const ROUNDING: f64 = 1e-10;

/// The `x ≥ 0` with the least `|A x − b|`, and which of its entries are above zero: Lawson and Hanson's active sets (*Solving
/// Least Squares Problems*, 1974, chapter 23). `None` where the free columns depend on each other.
pub(crate) fn nonnegative(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<(DVector<f64>, Vec<usize>)> {
    let count = matrix.ncols();
    let (square, product) = (matrix.transpose() * matrix, matrix.transpose() * right);
    let mut found = DVector::zeros(count);
    let mut free: Vec<usize> = Vec::new();
    let tolerance = ROUNDING * product.amax();
    // Each round frees the unknown that helps most; cycles are excluded but for rounding.
    for _ in 0..3 * count {
        let gradient = &product - &square * &found;
        let most =
            (0..count).filter(|k| !free.contains(k)).max_by(|a, b| gradient[*a].total_cmp(&gradient[*b]));
        let Some(most) = most.filter(|most| gradient[*most] > tolerance) else { break };
        free.push(most);
        loop {
            let solved = solved(&square, &product, &free)?;
            // As far towards the solution as no unknown becomes negative.
            let blocked = free.iter().zip(solved.iter()).filter(|(_, value)| **value <= 0.0);
            let fraction = blocked.map(|(k, value)| found[*k] / (found[*k] - value)).fold(1.0, f64::min);
            for (k, value) in free.iter().zip(solved.iter()) {
                found[*k] += fraction * (value - found[*k]);
            }
            if fraction >= 1.0 {
                break;
            }
            let least = free.iter().copied().min_by(|a, b| found[*a].total_cmp(&found[*b]))?;
            found[least] = 0.0;
            free.retain(|k| found[*k] > 0.0);
        }
    }
    free.sort_unstable();
    Some((found, free))
}

fn solved(square: &DMatrix<f64>, product: &DVector<f64>, free: &[usize]) -> Option<DVector<f64>> {
    let inner = DMatrix::from_fn(free.len(), free.len(), |i, k| square[(free[i], free[k])]);
    let right = DVector::from_fn(free.len(), |i, _| product[free[i]]);
    inner.cholesky().map(|factor| factor.solve(&right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_squares_are_met_where_they_are_positive_and_the_gradient_points_outwards_elsewhere() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..200 {
            let matrix = DMatrix::from_fn(9, 6, |_, _| random.f64() - 0.5);
            let right = DVector::from_fn(9, |_, _| random.f64() - 0.5);
            let (found, free) = nonnegative(&matrix, &right).unwrap();
            let gradient = matrix.transpose() * (&right - &matrix * &found);
            for k in 0..6 {
                assert_eq!(free.contains(&k), found[k] > 0.0);
                assert!(found[k] >= 0.0);
                assert!(if found[k] > 0.0 { gradient[k].abs() < 1e-9 } else { gradient[k] < 1e-9 });
            }
        }
    }
}
