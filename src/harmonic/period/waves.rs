//! `cos nθ` and `sin nθ` for many n, sums of them, and the products they make up.
//!
//! The product of two basis functions is half the sum of two waves of the orders' sum and difference. So
//! `∫ k(θ) bᵢ bⱼ dθ` for all pairs follows from the `∫ k cos nθ dθ` and `∫ k sin nθ dθ`, n up to twice the
//! highest harmonic: a contribution to `k` costs as much as a vector, not as a matrix.

use std::f64::consts::PI;

use crate::numeric::HarmonicSet;
use crate::numeric::multiplication::Multiplication;

/// Pairs `[cos, sin]` of even orders 0, 2, … and of odd orders 1, 3, …
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Waves {
    pub even: Vec<[f64; 2]>,
    pub odd: Vec<[f64; 2]>,
}

impl Waves {
    /// Orders up to `even` and up to `odd`, either −1 for none.
    fn up_to(even: i64, odd: i64) -> Self {
        let count = |highest: i64, first: i64| ((highest - first).div_euclid(2) + 1).max(0) as usize;
        Self { even: vec![[0.0; 2]; count(even, 0)], odd: vec![[0.0; 2]; count(odd, 1)] }
    }

    /// The orders that occur in signals on `set`.
    pub fn single(set: HarmonicSet) -> Self {
        let highest = set.highest() as i64;
        Self::up_to(if set.is_odd() { -1 } else { highest }, highest)
    }

    /// The orders that occur in products of two signals, on `left` and on `right`.
    pub fn product(left: HarmonicSet, right: HarmonicSet) -> Self {
        let highest = (left.highest() + right.highest()) as i64;
        let both_odd = left.is_odd() && right.is_odd();
        Self::up_to(highest, if both_odd { -1 } else { highest })
    }

    /// The orders that occur in either.
    pub fn either(a: &Waves, b: &Waves) -> Self {
        let longer = |x: &Vec<[f64; 2]>, y: &Vec<[f64; 2]>| vec![[0.0; 2]; x.len().max(y.len())];
        Self { even: longer(&a.even, &b.even), odd: longer(&a.odd, &b.odd) }
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.even.fill([0.0; 2]);
        self.odd.fill([0.0; 2]);
    }

    /// The waves at `phase` (rad).
    pub fn fill(&mut self, phase: f64) {
        let (sin, cos) = phase.sin_cos();
        let turn = (cos * cos - sin * sin, 2.0 * sin * cos);
        let turned =
            |pair: [f64; 2]| [pair[0] * turn.0 - pair[1] * turn.1, pair[1] * turn.0 + pair[0] * turn.1];
        let (mut even, mut odd) = ([1.0, 0.0], [cos, sin]);
        let both = self.even.len().min(self.odd.len());
        // Side by side the two recurrences take the time of one.
        for (e, o) in self.even.iter_mut().zip(&mut self.odd) {
            (*e, *o) = (even, odd);
            (even, odd) = (turned(even), turned(odd));
        }
        for e in &mut self.even[both..] {
            *e = even;
            even = turned(even);
        }
        for o in &mut self.odd[both..] {
            *o = odd;
            odd = turned(odd);
        }
    }

    /// Adds `weight` times the waves of the orders present here.
    pub fn add(&mut self, weight: f64, waves: &Waves) {
        let axpy = |sum: &mut [[f64; 2]], wave: &[[f64; 2]]| {
            for (s, w) in sum.iter_mut().zip(wave) {
                s[0] += weight * w[0];
                s[1] += weight * w[1];
            }
        };
        axpy(&mut self.even, &waves.even);
        axpy(&mut self.odd, &waves.odd);
    }

    /// Takes a sum of waves at the ends of intervals, with the phase itself in place of order 0, for the sum of
    /// the integrals over them.
    pub fn integrate(&mut self) {
        for (j, pair) in self.even.iter_mut().enumerate().skip(1) {
            let scale = 0.5 / j as f64;
            *pair = [scale * pair[1], -scale * pair[0]];
        }
        for (j, pair) in self.odd.iter_mut().enumerate() {
            let scale = 1.0 / (2 * j + 1) as f64;
            *pair = [scale * pair[1], -scale * pair[0]];
        }
    }

    /// `[cos, sin]` of an order that is present.
    #[inline(always)]
    pub fn of(&self, order: usize) -> [f64; 2] {
        if order.is_multiple_of(2) { self.even[order / 2] } else { self.odd[order / 2] }
    }

    /// Coefficients on `set` of the signal whose integrals with the waves these are, `fraction` of a
    /// period having been integrated.
    pub fn coefficients(&self, set: HarmonicSet, fraction: f64, out: &mut [f64]) {
        let norm = 1.0 / (fraction * PI);
        for (order, place) in set.orders() {
            if order == 0 {
                out[place] = 0.5 * norm * self.even[0][0];
            } else {
                let [cos, sin] = self.of(order);
                out[place] = norm * cos;
                out[place + 1] = norm * sin;
            }
        }
    }

    /// Sets `product` to multiply signals on `columns` by the signal whose integrals with the waves these are, `fraction`
    /// of a period having been integrated, and to keep the harmonics of `rows`.
    pub fn multiply(
        &self,
        rows: HarmonicSet,
        columns: HarmonicSet,
        fraction: f64,
        product: &mut Multiplication,
    ) {
        let norm = 1.0 / (fraction * PI);
        let of = |order: usize| {
            let pair =
                if order.is_multiple_of(2) { self.even.get(order / 2) } else { self.odd.get(order / 2) };
            // No column uses odd orders between two odd sets.
            debug_assert!(pair.is_some() || order % 2 == 1 && rows.is_odd() && columns.is_odd());
            pair.map_or([0.0; 2], |pair| pair.map(|x| norm * x))
        };
        product.set(rows, columns, of);
    }

    /// Values of the basis functions on `set`.
    pub fn basis(&self, set: HarmonicSet, out: &mut [f64]) {
        for (order, place) in set.orders() {
            let [cos, sin] = self.of(order);
            out[place] = cos;
            if order > 0 {
                out[place + 1] = sin;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use nalgebra::DMatrix;

    use super::*;

    #[test]
    fn waves_are_cosines_and_sines() {
        let mut waves = Waves::product(HarmonicSet::full(20), HarmonicSet::full(20));
        waves.fill(5.1);
        for n in 0..=40 {
            let [cos, sin] = waves.of(n);
            let (expected_sin, expected_cos) = (n as f64 * 5.1).sin_cos();
            assert!((cos - expected_cos).abs() < 1e-13 && (sin - expected_sin).abs() < 1e-13, "{n}");
        }
    }

    #[test]
    fn multiplication_matches_quadrature() {
        for (rows, columns) in [
            (HarmonicSet::full(4), HarmonicSet::full(3)),
            (HarmonicSet::odd(5), HarmonicSet::odd(3)),
            (HarmonicSet::full(4), HarmonicSet::odd(3)),
            (HarmonicSet::odd(5), HarmonicSet::full(2)),
        ] {
            let k = |x: f64| 1.0 + 0.3 * x.cos() - 0.7 * (2.0 * x).sin() + 0.2 * (4.0 * x + 0.3).cos();
            let mut sum = Waves::product(rows, columns);
            let mut waves = sum.clone();
            let mut expected: DMatrix<f64> = DMatrix::zeros(rows.len(), columns.len());
            let n = 64;
            let (mut left, mut right) = (vec![0.0; rows.len()], vec![0.0; columns.len()]);
            for i in 0..n {
                let phase = TAU * i as f64 / n as f64;
                waves.fill(phase);
                sum.add(TAU / n as f64 * k(phase), &waves);
                let mut basis = Waves::either(&Waves::single(rows), &Waves::single(columns));
                basis.fill(phase);
                basis.basis(rows, &mut left);
                basis.basis(columns, &mut right);
                for (r, l) in left.iter().enumerate() {
                    let norm = if r == 0 && !rows.is_odd() { 1.0 } else { 2.0 };
                    for (c, x) in right.iter().enumerate() {
                        expected[(r, c)] += norm / n as f64 * k(phase) * l * x;
                    }
                }
            }
            let (mut product, mut found) =
                (Multiplication::default(), DMatrix::zeros(rows.len(), columns.len()));
            sum.multiply(rows, columns, 2.0 * 0.5, &mut product);
            product.write(found.as_mut_slice().chunks_exact_mut(rows.len()));
            assert!((found - expected).abs().max() < 1e-14, "{rows:?} {columns:?}");
        }
    }
}
