//! Factors of a dense complex matrix, in storage of their own.

use nalgebra::Complex;

use super::compliance::Singular;
use super::condensation::Matrices;

/// LU factors with partial pivoting.
#[derive(Debug, Clone)]
pub(super) struct DenseFactors {
    size: usize,
    /// L below the diagonal (of ones), U above it, the inverses of U's diagonal on it; row-major.
    factors: Vec<Complex<f64>>,
    /// The row exchanged with row k in step k.
    exchanged: Vec<usize>,
    /// Size of the terms that made up each row's largest entry.
    terms: Vec<f64>,
}

impl DenseFactors {
    pub(super) fn new(size: usize) -> Self {
        let factors = vec![Complex::new(0.0, 0.0); size * size];
        Self { size, factors, exchanged: vec![0; size], terms: vec![0.0; size] }
    }

    /// Factorises the dynamic stiffness.
    pub(super) fn factorise(
        &mut self,
        matrices: &Matrices,
        damping: Complex<f64>,
        inertia: Complex<f64>,
    ) -> Result<(), Singular> {
        let n = self.size;
        let (damping_size, inertia_size) = (damping.norm(), inertia.norm());
        self.factors.fill(Complex::new(0.0, 0.0));
        self.terms.fill(0.0);
        for place in &matrices.places {
            self.factors[place.row * n + place.column] = place.value(damping, inertia);
            let terms = &mut self.terms[place.row];
            *terms = terms.max(place.terms(damping_size, inertia_size));
        }
        (0..n).try_for_each(|k| self.eliminate(k))
    }

    fn eliminate(&mut self, k: usize) -> Result<(), Singular> {
        let n = self.size;
        let magnitude = |i: usize| self.factors[i * n + k].norm_sqr();
        let pivot = (k..n).fold(k, |best, i| if magnitude(i) > magnitude(best) { i } else { best });
        let rounding = 4.0 * n as f64 * f64::EPSILON * self.terms[pivot];
        // A pivot that is not a number is no pivot either.
        if magnitude(pivot).is_nan() || magnitude(pivot) <= rounding * rounding {
            return Err(Singular);
        }
        self.exchanged[k] = pivot;
        if pivot != k {
            self.terms.swap(pivot, k);
            let (upper, lower) = self.factors.split_at_mut(pivot * n);
            upper[k * n..][..n].swap_with_slice(&mut lower[..n]);
        }
        let (upper, lower) = self.factors.split_at_mut((k + 1) * n);
        let upper = &mut upper[k * n..];
        let inverse = upper[k].inv();
        upper[k] = inverse;
        for row in lower.chunks_exact_mut(n) {
            // Rows of a chain are mostly empty.
            if row[k].re == 0.0 && row[k].im == 0.0 {
                continue;
            }
            let factor = row[k] * inverse;
            row[k] = factor;
            for (entry, above) in row[k + 1..].iter_mut().zip(&upper[k + 1..]) {
                *entry -= factor * above;
            }
        }
        Ok(())
    }

    /// Replaces a right-hand side by the solution.
    pub(super) fn solve(&self, column: &mut [Complex<f64>]) -> Result<(), Singular> {
        let n = self.size;
        for (k, pivot) in self.exchanged.iter().enumerate() {
            column.swap(k, *pivot);
        }
        for (i, row) in self.factors.chunks_exact(n).enumerate() {
            let (known, rest) = column.split_at_mut(i);
            rest[0] -= row.iter().zip(known).map(|(factor, value)| factor * *value).sum::<Complex<f64>>();
        }
        for (i, row) in self.factors.chunks_exact(n).enumerate().rev() {
            let (rest, known) = column.split_at_mut(i + 1);
            let sum = row[i + 1..].iter().zip(known).map(|(f, value)| f * *value).sum::<Complex<f64>>();
            rest[i] = (rest[i] - sum) * row[i];
        }
        Ok(())
    }
}
