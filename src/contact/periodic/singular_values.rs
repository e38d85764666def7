//! Small square matrices, row-major, and their singular value decomposition.

/// Makes the `n × n` `matrix` the identity.
pub(crate) fn set_identity(matrix: &mut [f64], n: usize) {
    matrix.fill(0.0);
    for i in 0..n {
        matrix[i * n + i] = 1.0;
    }
}

/// `out = left · right`, all `n × n`, row-major.
pub(crate) fn multiply(left: &[f64], right: &[f64], n: usize, out: &mut [f64]) {
    out.fill(0.0);
    for i in 0..n {
        for k in 0..n {
            let factor = left[i * n + k];
            if factor != 0.0 {
                for j in 0..n {
                    out[i * n + j] += factor * right[k * n + j];
                }
            }
        }
    }
}

/// Rotates the columns of the `n × n` row-major `matrix` until they are orthogonal (one-sided Jacobi):
/// `matrix` becomes U Σ and `rotation` V of its singular value decomposition.
pub(crate) fn orthogonalize_columns(matrix: &mut [f64], rotation: &mut [f64], n: usize) {
    const SWEEPS: usize = 60;
    set_identity(rotation, n);
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let (mut pp, mut qq, mut pq) = (0.0, 0.0, 0.0);
                for i in 0..n {
                    let (a, b) = (matrix[i * n + p], matrix[i * n + q]);
                    pp += a * a;
                    qq += b * b;
                    pq += a * b;
                }
                if pq.abs() <= 1e-15 * (pp * qq).sqrt() {
                    continue;
                }
                rotated = true;
                let zeta = (qq - pp) / (2.0 * pq);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = tangent.hypot(1.0).recip();
                let sine = cosine * tangent;
                for i in 0..n {
                    for values in [&mut *matrix, &mut *rotation] {
                        let (a, b) = (values[i * n + p], values[i * n + q]);
                        values[i * n + p] = cosine * a - sine * b;
                        values[i * n + q] = sine * a + cosine * b;
                    }
                }
            }
        }
        if !rotated {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{multiply, orthogonalize_columns};

    #[test]
    fn rotated_columns_are_orthogonal_and_rotate_back() {
        // Rank 2: the third column is the sum of the first two.
        let original = [1.0, -4.0, -3.0, 2.0, 0.5, 2.5, 1e-3, 7.0, 7.001];
        let (mut matrix, mut rotation, mut back) = (original, [0.0; 9], [0.0; 9]);
        orthogonalize_columns(&mut matrix, &mut rotation, 3);
        let dot = |p: usize, q: usize| (0..3).map(|i| matrix[3 * i + p] * matrix[3 * i + q]).sum::<f64>();
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            assert!(dot(p, q).abs() < 1e-13);
        }
        assert!((0..3).any(|j| dot(j, j) < 1e-28), "one singular value is zero");
        multiply(&original, &rotation, 3, &mut back);
        assert!(back.iter().zip(&matrix).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}
