//! Products of signals on their coefficients.
//!
//! The product of a wave of harmonic n and one of harmonic b is half of waves of the harmonics n + b and n − b. Where
//! `p_n = (c_n, s_n)` are the coefficients of a signal k, `p_−n = (c_n, −s_n)`, and `r_n = (s_n, −c_n)`, its product with
//! `cos bθ` has the coefficients `½ (p_{a−b} + p_{a+b})` in harmonic a, and that with `sin bθ` has `½ (r_{a+b} − r_{a−b})`:
//! sums of two stretches of one array, whatever b. As a wave of harmonic 0 the mean counts twice, `p_0 = (2 a_0, 0)`, and the
//! mean of a product is half of what the other coefficients are.

use crate::numeric::HarmonicSet;

/// "Multiply by k, and keep some harmonics" for signals of given harmonics, as a matrix on coefficients or applied.
#[derive(Debug)]
pub(crate) struct Multiplication {
    /// Harmonics that are kept.
    rows: HarmonicSet,
    /// Harmonics of the signals that are multiplied.
    columns: HarmonicSet,
    /// ½ p_n, and ½ r_n, for n from the lowest difference to the highest sum.
    along: Vec<[f64; 2]>,
    across: Vec<[f64; 2]>,
}

/// The product with one wave: the harmonics that are kept, side by side.
struct Column<'a> {
    /// The mean, where that is kept.
    mean: f64,
    /// Cosines and sines of the others: these, and these with the sign added.
    pairs: [&'a [[f64; 2]]; 2],
    sign: f64,
}

impl Default for Multiplication {
    fn default() -> Self {
        let mean = HarmonicSet::full(0);
        Self { rows: mean, columns: mean, along: vec![[0.0; 2]], across: vec![[0.0; 2]] }
    }
}

impl Multiplication {
    /// Sets k by `of(n)`, its coefficients of cosine and sine of harmonic n, of n = 0 twice its mean; signals on `columns`
    /// are multiplied, and the harmonics of `rows` kept.
    pub fn set(&mut self, rows: HarmonicSet, columns: HarmonicSet, of: impl Fn(usize) -> [f64; 2]) {
        (self.rows, self.columns) = (rows, columns);
        let lowest = columns.highest();
        let count = rows.highest() + 2 * lowest + 1;
        self.along.resize(count, [0.0; 2]);
        self.across.resize(count, [0.0; 2]);
        for shifted in 0..count {
            let [c, s] = of(shifted.abs_diff(lowest)).map(|x| 0.5 * x);
            let s = if shifted < lowest { -s } else { s };
            let place = self.place(shifted);
            (self.along[place], self.across[place]) = ([c, s], [s, -c]);
        }
    }

    /// Sets k to the signal `[a0, c1, s1, …]`; signals of harmonics `0..=columns` are multiplied, and the harmonics
    /// `0..=rows` kept.
    pub fn set_signal(&mut self, signal: &[f64], rows: usize, columns: usize) {
        self.set(HarmonicSet::full(rows), HarmonicSet::full(columns), |n| match n {
            0 => [2.0 * signal[0], 0.0],
            n if 2 * n < signal.len() => [signal[2 * n - 1], signal[2 * n]],
            _ => [0.0; 2],
        });
    }

    /// Where a harmonic lies that is `shifted` above the lowest, such that those of neighbouring rows lie side by side.
    fn place(&self, shifted: usize) -> usize {
        if self.rows.is_odd() { (shifted % 2) * self.along.len().div_ceil(2) + shifted / 2 } else { shifted }
    }

    /// The columns of the matrix.
    fn columns(&self) -> impl Iterator<Item = Column<'_>> {
        let (lowest, count) = (self.columns.highest(), self.rows.len() / 2);
        self.columns.orders().flat_map(move |(b, _)| {
            let (below, above) = (self.place(lowest + 1 - b), self.place(lowest + 1 + b));
            // The mean is half of what the others are; an odd set has none.
            let [cosine, sine] = self.along[self.place(lowest + b)];
            let (above, below) = (above..above + count, below..below + count);
            let pairs = [&self.along[above.clone()], &self.along[below.clone()]];
            let cosine = Column { mean: cosine, pairs, sign: 1.0 };
            let sine = Column { mean: sine, pairs: [&self.across[above], &self.across[below]], sign: -1.0 };
            std::iter::once(cosine).chain((b > 0).then_some(sine))
        })
    }

    /// Writes the columns of the matrix to the first places of the `slots`.
    pub fn write<'o>(&self, slots: impl Iterator<Item = &'o mut [f64]>) {
        for (column, slot) in self.columns().zip(slots) {
            column.write(&mut slot[..self.rows.len()]);
        }
    }

    /// Adds the product with `signal` to `out`.
    pub fn add_product(&self, signal: &[f64], out: &mut [f64]) {
        for (column, weight) in self.columns().zip(signal) {
            column.add(*weight, out);
        }
    }
}

impl Column<'_> {
    fn write(&self, out: &mut [f64]) {
        let (mean, pairs) = out.split_at_mut(out.len() % 2);
        mean.fill(self.mean);
        let [these, those] = self.pairs.map(<[_]>::as_flattened);
        for ((out, this), that) in pairs.iter_mut().zip(these).zip(those) {
            *out = this + self.sign * that;
        }
    }

    fn add(&self, weight: f64, out: &mut [f64]) {
        let (mean, pairs) = out.split_at_mut(out.len() % 2);
        mean.iter_mut().for_each(|mean| *mean += weight * self.mean);
        let [these, those] = self.pairs.map(<[_]>::as_flattened);
        let signed = weight * self.sign;
        for ((out, this), that) in pairs.iter_mut().zip(these).zip(those) {
            *out += weight * this + signed * that;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::fourier::{coefficient_count, value};

    #[test]
    fn matrix_and_product_multiply_signals() {
        let factor = [0.3, -1.0, 2.0, 0.5, -0.7, 0.2, 0.9];
        let other = [1.1, 0.4, -0.6, 0.8, 1.3];
        let mut k = Multiplication::default();
        k.set_signal(&factor, 5, 2);
        let rows = coefficient_count(5);
        let mut matrix = vec![f64::NAN; rows * other.len()];
        k.write(matrix.chunks_exact_mut(rows));
        let mut product = vec![0.0; rows];
        for (column, x) in matrix.chunks(rows).zip(&other) {
            product.iter_mut().zip(column).for_each(|(p, c)| *p += c * x);
        }
        for phase in [0.0, 0.7, 2.1, 4.4] {
            let expected = value(&factor, phase) * value(&other, phase);
            assert!((value(&product, phase) - expected).abs() < 1e-14);
        }
        let mut applied = vec![0.0; rows];
        k.add_product(&other, &mut applied);
        for (a, b) in product.iter().zip(&applied) {
            assert!((a - b).abs() < 1e-15);
        }
        // Cutting the rows cuts harmonics of the product and changes nothing else.
        k.set_signal(&factor, 2, 2);
        let mut cut = vec![f64::NAN; 5 * other.len()];
        k.write(cut.chunks_exact_mut(5));
        for (cut, column) in cut.chunks(5).zip(matrix.chunks(rows)) {
            assert_eq!(cut, &column[..5]);
        }
    }

    #[test]
    fn odd_sets_are_parts_of_full_ones() {
        let factor: Vec<f64> = (0..21).map(|n| (1.7 * f64::from(n) + 0.4).sin()).collect();
        let of = |n: usize| if n == 0 { [2.0 * factor[0], 0.0] } else { [factor[2 * n - 1], factor[2 * n]] };
        let matrix = |rows: HarmonicSet, columns: HarmonicSet| {
            let mut k = Multiplication::default();
            k.set(rows, columns, of);
            let mut matrix = vec![f64::NAN; rows.len() * columns.len()];
            k.write(matrix.chunks_exact_mut(rows.len()));
            matrix
        };
        let all = HarmonicSet::full(5);
        let whole = matrix(all, all);
        for (rows, columns) in [
            (HarmonicSet::odd(5), HarmonicSet::odd(3)),
            (HarmonicSet::full(4), HarmonicSet::odd(3)),
            (HarmonicSet::odd(5), HarmonicSet::full(2)),
            (HarmonicSet::full(0), HarmonicSet::odd(1)),
        ] {
            let part = matrix(rows, columns);
            for (b, column) in columns.orders() {
                for (a, row) in rows.orders() {
                    for (right, left) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        if left > a || right > b {
                            continue; // a mean has no sine
                        }
                        let there = (2 * b).saturating_sub(1) + right;
                        let expected = whole[there * all.len() + (2 * a).saturating_sub(1) + left];
                        assert_eq!(part[(column + right) * rows.len() + row + left], expected);
                    }
                }
            }
        }
    }
}
