//! Linear equations of which only products with the matrix are known: GMRES without restart.

/// Most products; an interface of a structure's few modes needs no more than there are modes.
const LONGEST: usize = 30;
/// Relative residual that ends it: a Newton step need not be better.
const ENOUGH: f64 = 1e-10;

/// Y. Saad, M. H. Schultz: GMRES, SIAM Journal on Scientific and Statistical Computing 7 (1986) 856–869.
#[derive(Debug)]
pub(super) struct Krylov {
    basis: Vec<Vec<f64>>,
    /// The triangular factor of the Hessenberg matrix, column by column.
    columns: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    right: Vec<f64>,
}

impl Krylov {
    /// Room for equations in `unknowns`.
    pub fn new(unknowns: usize) -> Self {
        let most = unknowns.min(LONGEST);
        Self {
            basis: vec![vec![0.0; unknowns]; most + 1],
            columns: vec![vec![0.0; most + 1]; most],
            rotations: vec![(1.0, 0.0); most],
            right: vec![0.0; most + 1],
        }
    }

    /// Replaces the right-hand side in `vector` by the solution, from `product(vector, out)`.
    ///
    /// # Errors
    /// Those of `product`.
    pub fn solve<E>(
        &mut self,
        vector: &mut [f64],
        mut product: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<(), E> {
        let length = norm(vector);
        if length == 0.0 || !length.is_finite() {
            return Ok(());
        }
        for (first, value) in self.basis[0].iter_mut().zip(vector.iter()) {
            *first = value / length;
        }
        self.right.fill(0.0);
        self.right[0] = length;
        let mut used = 0;
        while used < self.columns.len() {
            let (before, after) = self.basis.split_at_mut(used + 1);
            let next = &mut after[0];
            product(&before[used], next)?;
            let column = &mut self.columns[used];
            for (entry, other) in column.iter_mut().zip(before.iter()) {
                *entry = dot(other, next);
                next.iter_mut().zip(other).for_each(|(value, other)| *value -= *entry * other);
            }
            let rest = norm(next);
            let size = norm(&column[..=used]).hypot(rest);
            if !size.is_finite() || size == 0.0 {
                break;
            }
            for (row, (cosine, sine)) in self.rotations[..used].iter().enumerate() {
                let (above, below) = (column[row], column[row + 1]);
                column[row] = cosine * above + sine * below;
                column[row + 1] = cosine * below - sine * above;
            }
            let radius = column[used].hypot(rest);
            let (cosine, sine) = (column[used] / radius, rest / radius);
            self.rotations[used] = (cosine, sine);
            column[used] = radius;
            self.right[used + 1] = -sine * self.right[used];
            self.right[used] *= cosine;
            used += 1;
            if rest <= 1e-14 * size || self.right[used].abs() <= ENOUGH * length {
                break;
            }
            next.iter_mut().for_each(|value| *value /= rest);
        }
        for row in (0..used).rev() {
            let known: f64 =
                (row + 1..used).map(|column| self.columns[column][row] * self.right[column]).sum();
            self.right[row] = (self.right[row] - known) / self.columns[row][row];
        }
        vector.fill(0.0);
        for (share, basis) in self.right.iter().zip(&self.basis).take(used) {
            vector.iter_mut().zip(basis).for_each(|(value, basis)| *value += share * basis);
        }
        Ok(())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut vector = vec![0.0; size];
        apply(&wanted, &mut vector);
        let mut products = 0;
        let solved = Krylov::new(size).solve::<()>(&mut vector, |x, out| {
            products += 1;
            apply(x, out);
            Ok(())
        });
        assert!(solved.is_ok() && products <= 4, "{products}");
        let error = vector.iter().zip(&wanted).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(error < 1e-8, "{error:e}");
    }
}
