//! Krylov–Duncan functions and the exact transfer across a short piece of a uniform beam.

/// Terms of each series. With a phase up to [`LARGEST_PHASE`] the first one left out is below
/// 2^28/28! ≈ 9e-22 of the sum.
const TERMS: usize = 7;

/// Longest piece crossed in one step, as phase β·h (1). The transfer grows like e^phase: at 2 a step
/// loses less than one digit, and it stays far below 4.73, the first clamped–clamped frequency of the
/// piece, where a count of natural frequencies would have to look inside it.
pub(in crate::system) const LARGEST_PHASE: f64 = 2.0;

/// 1/(4n + d)! in row d, term n.
const INVERSE_FACTORIAL: [[f64; TERMS]; 4] = inverse_factorials();

const fn inverse_factorials() -> [[f64; TERMS]; 4] {
    let mut table = [[0.0; TERMS]; 4];
    let mut factorial = 1.0;
    let mut order = 0;
    while order < 4 * TERMS {
        if order > 0 {
            factorial *= order as f64;
        }
        table[order % 4][order / 4] = 1.0 / factorial;
        order += 1;
    }
    table
}

/// `k_d = Σ z⁴ⁿ/(4n+d)!` for d = 0..=3, where z is the phase: `z^d k_d` are the Krylov–Duncan functions
/// (cosh z + cos z)/2, (sinh z + sin z)/2, (cosh z − cos z)/2, (sinh z − sin z)/2.
///
/// The differences cancel for short pieces, the series do not.
pub(in crate::system) fn krylov_duncan(phase: f64) -> [f64; 4] {
    let square = phase * phase;
    let fourth = square * square;
    INVERSE_FACTORIAL.map(|row| row.iter().rev().fold(0.0, |sum, coefficient| sum * fourth + coefficient))
}

/// Deflection, slope, curvature and third derivative of a piece of beam, as multiples of powers of a
/// length: see [`Transfer`].
pub(in crate::system) type State = [f64; 4];

/// The exact map of the state across a piece of a uniform beam vibrating with wave number b
/// (EI w'''' = ω² ρA w, Eq. 5 of the paper), all lengths as fractions of the beam's.
///
/// The state is `(w, w'/s, w''/s², w'''/s³)` with the scale `s = max(b, 1)`: entries then stay of order
/// one for high modes, and a beam at rest (b = 0) is a regular case.
#[derive(Debug, Clone, Copy)]
pub(in crate::system) struct Transfer {
    /// Above and on the diagonal, by distance from it.
    pub upper: [f64; 4],
    /// Below the diagonal, by distance from the corner.
    pub lower: [f64; 4],
}

impl Transfer {
    /// Across a piece of length `length` (fraction of the beam).
    pub fn new(wave_number: f64, length: f64) -> Self {
        let scale = scale(wave_number);
        let ratio = (wave_number / scale).powi(4);
        let step = scale * length;
        let [k0, k1, k2, k3] = krylov_duncan(wave_number * length);
        let upper = [k0, step * k1, step * step * k2, step * step * step * k3];
        Self { upper, lower: upper.map(|entry| ratio * entry) }
    }

    /// The state at the far end.
    pub fn apply(&self, [w, slope, curvature, third]: &State) -> State {
        let [u0, u1, u2, u3] = self.upper;
        let [_, l1, l2, l3] = self.lower;
        [
            u0 * w + u1 * slope + u2 * curvature + u3 * third,
            l3 * w + u0 * slope + u1 * curvature + u2 * third,
            l2 * w + l3 * slope + u0 * curvature + u1 * third,
            l1 * w + l2 * slope + l3 * curvature + u0 * third,
        ]
    }
}

/// The scale s of the state at a wave number.
pub(in crate::system) fn scale(wave_number: f64) -> f64 {
    wave_number.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_are_the_krylov_duncan_functions() {
        for phase in [0.5_f64, 1.0, 1.7, LARGEST_PHASE] {
            let (cosh, sinh, cos, sin) = (phase.cosh(), phase.sinh(), phase.cos(), phase.sin());
            let closed = [(cosh + cos) / 2.0, (sinh + sin) / 2.0, (cosh - cos) / 2.0, (sinh - sin) / 2.0];
            for (order, (series, closed)) in krylov_duncan(phase).into_iter().zip(closed).enumerate() {
                let value = series * phase.powi(order as i32);
                assert!(
                    (value - closed).abs() < 1e-14 * closed.abs(),
                    "{order} at {phase}: {value} {closed}"
                );
            }
        }
    }

    #[test]
    fn crossing_two_pieces_is_crossing_their_sum() {
        let state = [0.3, -1.2, 0.7, 2.0];
        let (first, second, whole) =
            (Transfer::new(6.0, 0.1), Transfer::new(6.0, 0.2), Transfer::new(6.0, 0.3));
        for (stepped, at_once) in second.apply(&first.apply(&state)).into_iter().zip(whole.apply(&state)) {
            assert!((stepped - at_once).abs() < 1e-13 * at_once.abs());
        }
    }
}
