//! Linear equations by generalised minimal residuals (Saad & Schultz 1986), with buffers that are used again.

use std::convert::Infallible;

/// Most directions; beyond them a factorisation is better.
const MOST_DIRECTIONS: usize = 60;
/// A new direction this much shorter than what it was made from is rounding: the space is complete.
const COMPLETE: f64 = 1e-14;

/// Workspace of the solution.
#[derive(Debug, Default)]
pub(crate) struct Krylov {
    /// Orthonormal directions, one after the other.
    basis: Vec<f64>,
    /// The triangle that the rotations make of the equations in these directions, column after column.
    triangle: Vec<f64>,
    /// Cosine and sine.
    rotations: Vec<(f64, f64)>,
    /// Right side after the rotations; the last is the residual.
    reduced: Vec<f64>,
}

impl Krylov {
    /// Solves `A x = right`, A being applied by `apply(v, A v)`, until the residual is the fraction `tolerance` of the
    /// right side; false where it does not become as small.
    pub fn solve(
        &mut self,
        mut apply: impl FnMut(&[f64], &mut [f64]),
        right: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> bool {
        let apply = |v: &[f64], out: &mut [f64]| {
            apply(v, out);
            Ok::<(), Infallible>(())
        };
        self.try_solve(apply, right, x, tolerance).unwrap_or(false)
    }

    /// As [`Krylov::solve`], of a product that may fail. Where the residual does not become small enough x is the best
    /// that was found.
    ///
    /// # Errors
    /// Those of `apply`.
    pub fn try_solve<E>(
        &mut self,
        mut apply: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
        right: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<bool, E> {
        let size = right.len();
        x.fill(0.0);
        let scale = length(right);
        if scale == 0.0 || !scale.is_finite() {
            return Ok(scale == 0.0);
        }
        self.triangle.clear();
        self.rotations.clear();
        self.reduced.clear();
        self.reduced.push(scale);
        self.basis.clear();
        self.basis.extend(right.iter().map(|r| r / scale));
        let mut solved = false;
        for count in 1..=MOST_DIRECTIONS.min(size) {
            self.basis.resize((count + 1) * size, 0.0);
            let (known, next) = self.basis.split_at_mut(count * size);
            apply(&known[(count - 1) * size..], next)?;
            let before = length(next);
            let start = self.triangle.len();
            self.triangle.resize(start + count, 0.0);
            // Twice, that rounding leaves nothing of the known directions.
            for _ in 0..2 {
                for (entry, direction) in self.triangle[start..].iter_mut().zip(known.chunks_exact(size)) {
                    let part = dot(direction, next);
                    *entry += part;
                    next.iter_mut().zip(direction).for_each(|(n, d)| *n -= part * d);
                }
            }
            let mut rest = length(next);
            if !rest.is_finite() {
                self.triangle.truncate(start);
                break;
            }
            if rest <= COMPLETE * before {
                rest = 0.0;
            } else {
                next.iter_mut().for_each(|n| *n /= rest);
            }
            self.rotate(start, rest);
            solved = self.reduced[count].abs() <= tolerance * scale;
            if solved || rest == 0.0 {
                break;
            }
        }
        Ok(self.combine(size, x) && solved)
    }

    /// Makes the column of the equations that begins at `start` one of the triangle.
    fn rotate(&mut self, start: usize, rest: f64) {
        let column = &mut self.triangle[start..];
        for (k, (cos, sin)) in self.rotations.iter().enumerate() {
            let (a, b) = (column[k], column[k + 1]);
            (column[k], column[k + 1]) = (cos * a + sin * b, cos * b - sin * a);
        }
        let last = column.len() - 1;
        let length = column[last].hypot(rest);
        let (cos, sin) = if length > 0.0 { (column[last] / length, rest / length) } else { (1.0, 0.0) };
        column[last] = length;
        let right = self.reduced[last];
        self.reduced[last] = cos * right;
        self.reduced.push(-sin * right);
        self.rotations.push((cos, sin));
    }

    /// The solution from the triangle, without the directions in which that is singular; false where there is one.
    fn combine(&mut self, size: usize, x: &mut [f64]) -> bool {
        let mut regular = true;
        for k in (0..self.rotations.len()).rev() {
            let column = &self.triangle[k * (k + 1) / 2..][..=k];
            if column[k] == 0.0 {
                regular = false;
                continue;
            }
            let weight = self.reduced[k] / column[k];
            self.reduced[..k].iter_mut().zip(column).for_each(|(r, c)| *r -= weight * c);
            let direction = &self.basis[k * size..(k + 1) * size];
            x.iter_mut().zip(direction).for_each(|(x, d)| *x += weight * d);
        }
        regular
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of 5 × 5 that is not symmetric, by rows.
    const MATRIX: [[f64; 5]; 5] = [
        [2.0, -1.0, 0.0, 0.3, 0.0],
        [0.5, -3.0, 1.0, 0.0, 0.2],
        [0.0, 0.7, 1.5, -2.0, 0.0],
        [0.1, 0.0, 0.4, 4.0, 1.0],
        [1.0, 0.2, 0.0, -0.6, 0.8],
    ];

    fn multiply(v: &[f64], out: &mut [f64]) {
        out.iter_mut().zip(&MATRIX).for_each(|(o, row)| *o = dot(row, v));
    }

    #[test]
    fn the_solution_solves_the_equations() {
        let right = [1.0, -2.0, 0.5, 0.0, 3.0];
        let (mut x, mut product) = ([0.0; 5], [0.0; 5]);
        let mut krylov = Krylov::default();
        // Twice, with the buffers of the first.
        for _ in 0..2 {
            assert!(krylov.solve(multiply, &right, &mut x, 1e-13));
            multiply(&x, &mut product);
            for (p, r) in product.iter().zip(right) {
                assert!((p - r).abs() < 1e-12, "{p} {r}");
            }
        }
    }

    #[test]
    fn a_loose_tolerance_is_met_and_needs_fewer_products() {
        let right = [1.0, -2.0, 0.5, 0.0, 3.0];
        let mut products = 0;
        let mut x = [0.0; 5];
        let near_identity = |v: &[f64], out: &mut [f64]| {
            products += 1;
            multiply(v, out);
            out.iter_mut().zip(v).for_each(|(o, v)| *o = v + 0.01 * *o);
        };
        assert!(Krylov::default().solve(near_identity, &right, &mut x, 1e-3));
        assert!(products <= 2, "{products}");
    }

    #[test]
    fn what_has_no_solution_is_refused() {
        let singular = |v: &[f64], out: &mut [f64]| {
            out.copy_from_slice(v);
            out[0] = 0.0;
        };
        assert!(!Krylov::default().solve(singular, &[1.0, 1.0], &mut [0.0; 2], 1e-12));
        assert!(!Krylov::default().solve(singular, &[f64::NAN, 1.0], &mut [0.0; 2], 1e-12));
        let mut x = [1.0; 2];
        assert!(Krylov::default().solve(singular, &[0.0; 2], &mut x, 1e-12) && x == [0.0; 2]);
    }

    #[test]
    fn as_many_products_as_the_matrix_has_ranks_solve_it() {
        // The identity less two dyads: three distinct eigenvalues.
        let size = 40;
        let (a, b): (Vec<f64>, Vec<f64>) =
            (0..size).map(|i| ((0.3 * i as f64).sin(), (0.7 * i as f64 + 1.0).cos())).unzip();
        let wanted: Vec<f64> = (0..size).map(|i| 1.0 + 0.1 * i as f64).collect();
        let apply = |x: &[f64], out: &mut [f64]| {
            let (p, q) = (dot(&a, x), dot(&b, x));
            for i in 0..size {
                out[i] = x[i] - 0.4 * a[i] * q + 0.05 * b[i] * p;
            }
        };
        let (mut right, mut x) = (vec![0.0; size], vec![0.0; size]);
        apply(&wanted, &mut right);
        let mut products = 0;
        let counted = |x: &[f64], out: &mut [f64]| {
            products += 1;
            apply(x, out);
        };
        assert!(Krylov::default().solve(counted, &right, &mut x, 1e-10) && products <= 4, "{products}");
        let error = x.iter().zip(&wanted).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(error < 1e-8, "{error:e}");
    }

    #[test]
    fn a_product_that_fails_ends_it_and_what_is_found_is_kept() {
        let failing = |_: &[f64], _: &mut [f64]| Err("no product");
        assert_eq!(Krylov::default().try_solve(failing, &[1.0, 2.0], &mut [0.0; 2], 1e-9), Err("no product"));
        // The second direction has no solution: the first is kept.
        let (mut x, mut right) = ([0.0; 2], [3.0, 0.0]);
        let singular = |v: &[f64], out: &mut [f64]| {
            out.copy_from_slice(&[v[0], 0.0]);
            Ok::<(), ()>(())
        };
        assert_eq!(Krylov::default().try_solve(singular, &right, &mut x, 1e-9), Ok(true));
        assert_eq!(x, [3.0, 0.0]);
        right[1] = 1.0;
        assert_eq!(Krylov::default().try_solve(singular, &right, &mut x, 1e-9), Ok(false));
        assert!((x[0] - 3.0).abs() < 1e-9, "{x:?}");
    }
}
