//! Which harmonics a signal has.

/// A set of harmonics: all of `0..=H`, or the odd ones up to H.
///
/// Coefficients lie in ascending order, cosine before sine: `[a0, c1, s1, c2, s2, …]` for the full set and
/// `[c1, s1, c3, s3, …]` for the odd one; `x(θ) = a0 + Σ c_h cos hθ + s_h sin hθ`, `θ = Ω t`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HarmonicSet {
    highest: usize,
    odd: bool,
}

impl HarmonicSet {
    /// Harmonics `0..=highest`.
    pub const fn full(highest: usize) -> Self {
        Self { highest, odd: false }
    }

    /// Odd harmonics `1, 3, …`, none above `highest`, which is at least 1.
    pub const fn odd(highest: usize) -> Self {
        Self { highest: highest - (1 - highest % 2), odd: true }
    }

    /// The highest harmonic.
    pub const fn highest(&self) -> usize {
        self.highest
    }

    /// Whether only odd harmonics are in the set.
    pub const fn is_odd(&self) -> bool {
        self.odd
    }

    /// Number of coefficients.
    pub const fn len(&self) -> usize {
        if self.odd { self.highest + 1 } else { 2 * self.highest + 1 }
    }

    /// Never true: there is always a harmonic.
    pub const fn is_empty(&self) -> bool {
        false
    }

    /// The harmonics, ascending, each with the place of its first coefficient (its cosine's, or the bias).
    pub fn orders(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let odd = self.odd;
        let count = if odd { self.highest.div_ceil(2) } else { self.highest + 1 };
        // Counted, without a search for the places: this runs in the innermost loops.
        (0..count).map(move |k| match (odd, k) {
            (true, _) => (2 * k + 1, 2 * k),
            (false, 0) => (0, 0),
            (false, _) => (k, 2 * k - 1),
        })
    }

    /// Place of the cosine of harmonic `order` (of the bias for 0); its sine follows.
    pub const fn place(&self, order: usize) -> Option<usize> {
        if order > self.highest {
            None
        } else if self.odd {
            if order % 2 == 1 { Some(order - 1) } else { None }
        } else if order == 0 {
            Some(0)
        } else {
            Some(2 * order - 1)
        }
    }

    /// The same signal on the harmonics of `other`; harmonics this set has not are zero.
    pub fn convert(&self, coefficients: &[f64], other: HarmonicSet, out: &mut [f64]) {
        out.fill(0.0);
        for (order, place) in other.orders() {
            if let Some(from) = self.place(order) {
                let width = if order == 0 { 1 } else { 2 };
                out[place..place + width].copy_from_slice(&coefficients[from..from + width]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_each_other() {
        for set in [HarmonicSet::full(5), HarmonicSet::odd(5), HarmonicSet::odd(6), HarmonicSet::full(0)] {
            let mut next = 0;
            for (order, place) in set.orders() {
                assert_eq!(place, next, "{set:?}");
                next += if order == 0 { 1 } else { 2 };
            }
            assert_eq!(next, set.len());
        }
        assert_eq!(HarmonicSet::odd(6), HarmonicSet::odd(5));
    }

    #[test]
    fn conversion_keeps_what_both_sets_have() {
        let odd = [1.0, 2.0, 3.0, 4.0];
        let mut full = [9.0; 9];
        HarmonicSet::odd(3).convert(&odd, HarmonicSet::full(4), &mut full);
        assert_eq!(full, [0.0, 1.0, 2.0, 0.0, 0.0, 3.0, 4.0, 0.0, 0.0]);
        let mut back = [9.0; 4];
        HarmonicSet::full(4).convert(&full, HarmonicSet::odd(3), &mut back);
        assert_eq!(back, odd);
    }
}
