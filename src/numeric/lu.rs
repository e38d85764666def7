//! Triangular factors of a small dense matrix, in a buffer that is used again and again.

use std::ops::Range;

use nalgebra::{DMatrixView, DMatrixViewMut};

/// Columns that are eliminated one by one before the others are updated by all of them at once.
const PANEL: usize = 32;

/// `P A = L U` by elimination with row pivoting. Column-major.
#[derive(Debug, Clone, Default)]
pub(crate) struct Factors {
    size: usize,
    values: Vec<f64>,
    pivots: Vec<usize>,
}

impl Factors {
    /// Sets the size and hands out the matrix, zero and column-major, to be filled before [`Self::factor`].
    pub fn reset(&mut self, size: usize) -> &mut [f64] {
        self.size = size;
        self.values.clear();
        self.values.resize(size * size, 0.0);
        self.pivots.resize(size, 0);
        &mut self.values
    }

    /// Number of equations.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Factors the matrix in place; false where it is singular or not finite.
    pub fn factor(&mut self) -> bool {
        (0..self.size).step_by(PANEL).all(|first| {
            let end = (first + PANEL).min(self.size);
            self.factor_panel(first..end) && {
                self.update_after(first..end);
                true
            }
        })
    }

    /// Factors the `panel` of columns below its first row, and swaps the rows of all columns alike.
    fn factor_panel(&mut self, panel: Range<usize>) -> bool {
        let n = self.size;
        for k in panel.clone() {
            let (done, rest) = self.values.split_at_mut((k + 1) * n);
            let column = &mut done[k * n..];
            let mut pivot = k;
            for i in k + 1..n {
                if column[i].abs() > column[pivot].abs() {
                    pivot = i;
                }
            }
            let value = column[pivot];
            if value == 0.0 || !value.is_finite() {
                return false;
            }
            self.pivots[k] = pivot;
            let inverse = 1.0 / value;
            column.swap(k, pivot);
            column[k + 1..].iter_mut().for_each(|x| *x *= inverse);
            let factors = &column[k + 1..];
            for target in rest.chunks_exact_mut(n).take(panel.end - k - 1) {
                target.swap(k, pivot);
                let (head, tail) = target.split_at_mut(k + 1);
                let weight = head[k];
                if weight != 0.0 {
                    tail.iter_mut().zip(factors).for_each(|(t, f)| *t -= weight * f);
                }
            }
        }
        // The part of L to the left is swapped too, so that a solve can apply all swaps first.
        let beside = (0..panel.start).chain(panel.end..n);
        for column in beside {
            panel.clone().for_each(|k| self.values.swap(column * n + k, column * n + self.pivots[k]));
        }
        // Within the panel a column knows the swaps of those before it.
        for column in panel.clone() {
            (column + 1..panel.end)
                .for_each(|k| self.values.swap(column * n + k, column * n + self.pivots[k]));
        }
        true
    }

    /// The rows of U beside the factored `panel`, and what it takes off the columns after it.
    fn update_after(&mut self, panel: Range<usize>) {
        let n = self.size;
        let (done, rest) = self.values.split_at_mut(panel.end * n);
        let factored = &done[panel.start * n..];
        for target in rest.chunks_exact_mut(n) {
            for (place, k) in panel.clone().enumerate() {
                let (head, tail) = target[..panel.end].split_at_mut(k + 1);
                let below = &factored[place * n + k + 1..place * n + panel.end];
                tail.iter_mut().zip(below).for_each(|(t, f)| *t -= head[k] * f);
            }
        }
        let columns = rest.len() / n;
        if columns == 0 {
            return;
        }
        let factored = DMatrixView::from_slice(factored, n, panel.len());
        let mut rest = DMatrixViewMut::from_slice(rest, n, columns);
        let beside = rest.rows(panel.start, panel.len()).into_owned();
        rest.rows_mut(panel.end, n - panel.end).gemm(
            -1.0,
            &factored.rows(panel.end, n - panel.end),
            &beside,
            1.0,
        );
    }

    /// Sign of the determinant of what was factored last.
    pub fn orientation(&self) -> f64 {
        let n = self.size;
        let swaps = self.pivots.iter().enumerate().filter(|(k, pivot)| *k != **pivot).count();
        let negative = (0..n).filter(|k| self.values[k * n + k] < 0.0).count();
        if (swaps + negative).is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    /// Replaces every column of `right` by `A⁻¹` times it; faster than one by one where they are many.
    pub fn solve_many(&self, right: &mut DMatrixViewMut<f64>) {
        let n = self.size;
        for mut column in right.column_iter_mut() {
            (0..n).for_each(|k| column.swap_rows(k, self.pivots[k]));
        }
        let factors = DMatrixView::from_slice(&self.values, n, n);
        for first in (0..n).step_by(PANEL) {
            let end = (first + PANEL).min(n);
            let (mut solved, mut below) = right.rows_range_pair_mut(first..end, end..n);
            for mut column in solved.column_iter_mut() {
                self.solve_lower(first, column.as_mut_slice());
            }
            if end < n {
                below.gemm(-1.0, &factors.view((end, first), (n - end, end - first)), &solved, 1.0);
            }
        }
        for first in (0..n).step_by(PANEL).rev() {
            let end = (first + PANEL).min(n);
            let (mut above, mut solved) = right.rows_range_pair_mut(0..first, first..end);
            for mut column in solved.column_iter_mut() {
                self.solve_upper(first, column.as_mut_slice());
            }
            if first > 0 {
                above.gemm(-1.0, &factors.view((0, first), (first, end - first)), &solved, 1.0);
            }
        }
    }

    /// Solves with the rows and columns of L from `first` on, as many as `right` has.
    fn solve_lower(&self, first: usize, right: &mut [f64]) {
        for k in 0..right.len() {
            let (head, tail) = right.split_at_mut(k + 1);
            let (weight, diagonal) = (head[k], (first + k) * (self.size + 1));
            // Many right sides start with zeros.
            if weight == 0.0 {
                continue;
            }
            let column = &self.values[diagonal + 1..][..tail.len()];
            tail.iter_mut().zip(column).for_each(|(t, f)| *t -= weight * f);
        }
    }

    /// The same of U.
    fn solve_upper(&self, first: usize, right: &mut [f64]) {
        for k in (0..right.len()).rev() {
            let column = &self.values[(first + k) * self.size + first..][..=k];
            let value = right[k] / column[k];
            right[k] = value;
            right[..k].iter_mut().zip(column).for_each(|(t, f)| *t -= value * f);
        }
    }

    /// Replaces `right` by `A⁻¹ right`.
    pub fn solve(&self, right: &mut [f64]) {
        for k in 0..self.size {
            right.swap(k, self.pivots[k]);
        }
        self.solve_lower(0, right);
        self.solve_upper(0, right);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solution_reproduces_the_right_side() {
        // Needs swaps: the first pivot is zero.
        let matrix = [0.0, 2.0, -1.0, 3.0, 1.0, 0.5, 4.0, 0.1, 1.0, 1.0, 7.0, 0.2, 2.0, 5.0, 0.3, 1.0];
        let mut factors = Factors::default();
        factors.reset(4).copy_from_slice(&matrix);
        assert!(factors.factor());
        let mut x = [1.0, -2.0, 3.0, 0.5];
        factors.solve(&mut x);
        for (i, right) in [1.0, -2.0, 3.0, 0.5].iter().enumerate() {
            let product: f64 = (0..4).map(|j| matrix[4 * j + i] * x[j]).sum();
            assert!((product - right).abs() < 1e-14, "{i}: {product}");
        }
    }

    #[test]
    fn matrices_of_several_panels_are_solved() {
        for size in [PANEL - 1, PANEL, PANEL + 1, 3 * PANEL + 5] {
            let mut random = crate::numeric::random::Random::new(size as u64);
            let matrix: Vec<f64> = (0..size * size).map(|_| random.normal()).collect();
            let right: Vec<f64> = (0..size).map(|_| random.normal()).collect();
            let mut factors = Factors::default();
            factors.reset(size).copy_from_slice(&matrix);
            assert!(factors.factor());
            let mut x = right.clone();
            factors.solve(&mut x);
            for (i, right) in right.iter().enumerate() {
                let product: f64 = (0..size).map(|j| matrix[size * j + i] * x[j]).sum();
                assert!((product - right).abs() < 1e-9, "{size}, {i}: {product}");
            }
            for columns in [1, 3, 7] {
                let mut many: Vec<f64> =
                    (1..=columns).flat_map(|c| right.iter().map(move |x| c as f64 * x)).collect();
                factors.solve_many(&mut DMatrixViewMut::from_slice(&mut many, size, columns));
                for (c, one) in (1..=columns).zip(many.chunks_exact(size)) {
                    let near = |(a, b): (&f64, &f64)| (a - c as f64 * b).abs() < 1e-9 * (1.0 + b.abs());
                    assert!(one.iter().zip(&x).all(near), "{size}, {c} of {columns}");
                }
            }
        }
    }

    #[test]
    fn orientation_is_the_sign_of_the_determinant() {
        for (matrix, sign) in [
            ([2.0, 1.0, 1.0, 3.0], 1.0),
            ([1.0, 3.0, 2.0, 1.0], -1.0),
            ([0.0, 1.0, -1.0, 0.0], 1.0),
            ([-1.0, 0.0, 0.0, 2.0], -1.0),
        ] {
            let mut factors = Factors::default();
            factors.reset(2).copy_from_slice(&matrix);
            assert!(factors.factor());
            assert_eq!(factors.orientation(), sign, "{matrix:?}");
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut factors = Factors::default();
        factors.reset(2).copy_from_slice(&[1.0, 2.0, 2.0, 4.0]);
        assert!(!factors.factor());
        factors.reset(1)[0] = f64::NAN;
        assert!(!factors.factor());
    }
}
