//! The approach of a hysteretic force to its limit: `dx/dw = 1 − a xⁿ`, x over the limit, integrated to rounding.

use crate::contact::quadrature::GAUSS_LEGENDRE_16;

/// Both integrals of the curve of the power `n ≥ 1` and the factor a: 1 towards the limit, `−1 ≤ a ≤ 0` away from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Saturation {
    pub n: f64,
    pub a: f64,
}

/// Where the curve ends, from 0 to 1.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reached {
    pub x: f64,
    /// ∂x/∂x₀.
    pub by_start: f64,
    /// The slope of the curve there.
    pub slope: f64,
    /// `∫ x |a| xⁿ/(1 − a xⁿ) dx`: work less the energy kept, at least zero.
    pub lost: f64,
}

/// Where series end.
struct EndBySeries {
    x: f64,
    /// The slope at the start, where one was needed.
    before: Option<f64>,
    lost: f64,
}

/// A series in `a xⁿ` serves up to here, which takes at most 50 terms; quadrature beyond.
const NEAR: f64 = 0.5;

/// Terms of a power series in the way at most, the size of the last one that is left over the place, and the place from where
/// such series serve for any way: where x is 0 the curve is not analytic.
const TERMS: usize = 20;
const LAST: f64 = 1e-17;
const ANY: f64 = 0.25;
/// 1, 1/2, 1/3, …
const OVER: [f64; TERMS] = {
    let (mut over, mut k) = ([1.0; TERMS], 0);
    while k < TERMS {
        over[k] /= (k + 1) as f64;
        k += 1;
    }
    over
};

/// What `(x − x₀) s'` takes of the product of the coefficients a and k − a of s, for both orders of them.
const SHIFTED: [[f64; TERMS / 2 + 1]; TERMS] = {
    let mut shifted = [[0.0; TERMS / 2 + 1]; TERMS];
    let mut k = 0;
    while k < TERMS {
        let mut a = 0;
        while 2 * a <= k {
            let (one, other) = (a as f64, (k - a) as f64);
            shifted[k][a] = other / (one + 1.0) + one / (other + 1.0);
            a += 1;
        }
        k += 1;
    }
    shifted
};

/// As many ways downwards do not reach zero, and a series serves.
const AWAY: f64 = 4.0;

/// Slope below which the gap to the limit falls exponentially to eight digits.
const NEARLY: f64 = 1e-8;

/// More rounds than any step needs; the bound only stops a NaN.
const ROUNDS: usize = 60;

fn integral(from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let pair = |&(node, weight): &(f64, f64)| weight * (of(middle - half * node) + of(middle + half * node));
    half * GAUSS_LEGENDRE_16.iter().map(pair).sum::<f64>()
}

impl Saturation {
    /// `1 − a xⁿ`, the slope of the curve.
    pub fn slope(&self, x: f64) -> f64 {
        match self.a {
            0.0 => 1.0,
            1.0 => -(self.n * x.ln()).exp_m1(),
            a => 1.0 - a * x.powf(self.n),
        }
    }

    /// Follows the curve from `x`, in `[0, 1]` where a = 1, over the way `w ≥ 0` upwards.
    pub fn rise(&self, x: f64, w: f64) -> Reached {
        if let Some(reached) = self.rise_by_series(x, w) {
            return reached;
        }
        let whole = self.way(x) + w;
        // The last number below one.
        if !(x < 1.0 && whole < self.way(1.0 - 0.5 * f64::EPSILON)) {
            return self.risen(self.slope(x), 1.0, w, self.lost_rising(x, 1.0, w));
        }
        // The way is concave in −ln(1 − x): from below Newton's steps never go too far.
        let mut gap = (1.0 - x) * (-w).exp();
        for _ in 0..ROUNDS {
            let at = 1.0 - gap;
            let next = gap * (-(whole - self.way(at)) * self.slope(at) / gap).exp();
            if next.is_nan() || next >= gap * (1.0 - f64::EPSILON) {
                break;
            }
            gap = next;
        }
        let end = (1.0 - gap).max(x);
        self.risen(self.slope(x), end, w, self.lost_rising(x, end, w))
    }

    /// The end of [`Saturation::rise`] alone.
    pub fn risen_to(&self, x: f64, w: f64) -> f64 {
        self.end_by_series(x, w).map_or_else(|| self.rise(x, w).x, |end| end.x)
    }

    /// [`Saturation::rise`] by power series in the way, where x is not small against that.
    fn rise_by_series(&self, x: f64, w: f64) -> Option<Reached> {
        let EndBySeries { x: end, before, lost } = self.end_by_series(x, w)?;
        Some(self.risen(before.unwrap_or_else(|| self.slope(x)), end, w, lost))
    }

    /// Where that ends, the energy lost, and the slope at the start.
    fn end_by_series(&self, x: f64, w: f64) -> Option<EndBySeries> {
        if !(w >= 0.0 && (x > ANY || x > w && x > f64::EPSILON)) {
            return None;
        }
        let (mut gap, mut left, mut lost, mut before) = (1.0 - x, w, 0.0, None);
        while left > 0.0 && gap > 0.25 * f64::EPSILON {
            let logarithm = self.n * (-gap).ln_1p();
            let (slope, power) = (-logarithm.exp_m1(), logarithm.exp());
            before.get_or_insert(slope);
            let (part, change, mean) = self.advance(1.0 - gap, [slope, power], 1.0, left);
            let next = gap - change;
            // ∫ x dw − ∫ x dx.
            lost += part * (1.0 - gap + mean) - 0.5 * (gap - next) * (2.0 - gap - next);
            (gap, left) = (next, left - part);
        }
        // At the limit all work is lost.
        Some(EndBySeries { x: (1.0 - gap).clamp(x, 1.0), before, lost: (lost + left).max(0.0) })
    }

    /// From `x` over the way `left`, or as much of it as a series allows: that part, the change of x upwards (`sign` 1) or
    /// downwards (−1), and the mean change. `s = 1 − a xⁿ` there and `a xⁿ` are given; from `x' = ±s` follows
    /// `x s' = ∓n s (1 − s)`.
    fn advance(&self, x: f64, [slope, power]: [f64; 2], sign: f64, left: f64) -> (f64, f64, f64) {
        // Coefficients of s and of ±x.
        let (mut slopes, mut places) = ([0.0; TERMS], [0.0; TERMS]);
        slopes[0] = slope;
        let (mut part, mut small, mut terms) = (left, 0, TERMS);
        let (mut power_of_left, rate, twice) = (1.0, sign / x, 2.0 * self.n);
        for k in 0..TERMS - 1 {
            let over = OVER[k];
            places[k + 1] = slopes[k] * over;
            power_of_left *= left;
            // Two small terms one after the other are no chance.
            small = if places[k + 1].abs() * power_of_left < LAST * x { small + 1 } else { 0 };
            if small == 2 {
                terms = k + 2;
                break;
            }
            // Of `−n s (1 − s) − (x − x₀) s'` the products with s₀, and each other product once.
            let own = if k == 0 { -self.n * power } else { self.n * (slope - power) - slope * k as f64 };
            let half = k.div_ceil(2);
            let pairs = slopes[..half].iter().zip(slopes[..=k].iter().rev()).zip(&SHIFTED[k]).skip(1);
            let mut sum: f64 = pairs.map(|((a, b), shifted)| a * b * (twice - shifted)).sum();
            if k > 0 && k % 2 == 0 {
                sum += slopes[half].powi(2) * (self.n - 0.5 * SHIFTED[k][half]);
            }
            slopes[k + 1] = rate * (own * slopes[k] + sum) * over;
        }
        if terms == TERMS {
            let reach = |k: usize| (LAST * x / places[k].abs()).powf(1.0 / k as f64);
            part = reach(TERMS - 1).min(reach(TERMS - 2)).min(left);
        }
        let (mut change, mut mean) = (0.0, 0.0);
        for k in (1..terms).rev() {
            change = (change + places[k]) * part;
            mean = (mean + places[k] / (k + 1) as f64) * part;
        }
        (part, change, mean)
    }

    /// The end `x` of a way `w` upwards from where the curve has the slope `before`: near the limit the gap falls exponentially,
    /// where its rounded values have no digits left.
    fn risen(&self, before: f64, x: f64, w: f64, lost: f64) -> Reached {
        let slope = self.slope(x);
        let by_start = if before < NEARLY { (-self.n * w).exp() } else { slope / before };
        Reached { x, by_start, slope, lost }
    }

    /// Follows the curve from `x ≥ 0` downwards over the way `w ≥ 0`, to zero at the least; the way left over.
    pub fn fall(&self, x: f64, w: f64) -> (Reached, f64) {
        if self.a == 0.0 {
            let end = (x - w).max(0.0);
            return (Reached { x: end, by_start: 1.0, slope: 1.0, lost: 0.0 }, (w - x).max(0.0));
        }
        if w >= 0.0 && x > AWAY * w && x > f64::EPSILON {
            return (self.fall_by_series(x, w), 0.0);
        }
        let whole = self.way(x) - w;
        if whole <= 0.0 {
            let by_start = 1.0 / self.slope(x);
            return (Reached { x: 0.0, by_start, slope: 1.0, lost: self.lost(x).abs() }, -whole);
        }
        // The way is concave in x.
        let mut end = (x - w * self.slope(x)).max(0.0);
        for _ in 0..ROUNDS {
            let next = end + (whole - self.way(end)) * self.slope(end);
            if next.is_nan() || next <= end * (1.0 + f64::EPSILON) {
                break;
            }
            end = next;
        }
        let end = end.min(x);
        let (lost, slope) = ((self.lost(x) - self.lost(end)).abs(), self.slope(end));
        (Reached { x: end, by_start: slope / self.slope(x), slope, lost }, 0.0)
    }

    /// The same by power series in the way, where that is short of zero.
    fn fall_by_series(&self, x: f64, w: f64) -> Reached {
        let before = self.slope(x);
        let (mut end, mut left, mut lost, mut slope) = (x, w, 0.0, before);
        while left > 0.0 {
            let (part, change, mean) = self.advance(end, [slope, 1.0 - slope], -1.0, left);
            // ∫ x dx − ∫ x dw.
            lost += 0.5 * change * (2.0 * end - change) - part * (end - mean);
            (end, left) = (end - change, left - part);
            slope = self.slope(end);
        }
        Reached { x: end, by_start: slope / before, slope, lost: lost.max(0.0) }
    }

    /// `∫₀ˣ dt/(1 − a tⁿ)`, infinite at the limit.
    fn way(&self, x: f64) -> f64 {
        let near = self.near().min(x);
        let series = near * self.series(near, |k| 1.0 / (1.0 + k));
        if near == x {
            return series;
        }
        series
            + if self.a == 1.0 {
                let n = self.n;
                let smooth = integral(near, x, |t| 1.0 / self.slope(t) - 1.0 / (n * (1.0 - t)));
                smooth + ((1.0 - near) / (1.0 - x)).ln() / n
            } else {
                integral(near, x, |t| 1.0 / self.slope(t))
            }
    }

    /// `∫₀ˣ a tⁿ⁺¹/(1 − a tⁿ) dt`.
    fn lost(&self, x: f64) -> f64 {
        let near = self.near().min(x);
        let series = near * near * (self.series(near, |k| 1.0 / (2.0 + k)) - 0.5);
        let beyond = |t: f64| t * (1.0 / self.slope(t) - 1.0);
        if near == x { series } else { series + integral(near, x, beyond) }
    }

    /// As [`Saturation::lost`] between `x` and `end`, where `w` is the way between them.
    fn lost_rising(&self, x: f64, end: f64, w: f64) -> f64 {
        let near = self.near();
        if end <= near {
            return (self.lost(end) - self.lost(x)).max(0.0);
        }
        let (from, before, way) = if x < near {
            (near, self.lost(near) - self.lost(x), w - (self.way(near) - self.way(x)))
        } else {
            (x, 0.0, w)
        };
        // Of the integral without bound the way is known.
        let bounded = integral(from, end, |t| if t < 1.0 { (1.0 - t) / self.slope(t) } else { 1.0 / self.n });
        (before + way - bounded - 0.5 * (end * end - from * from)).max(0.0)
    }

    fn near(&self) -> f64 {
        (NEAR / self.a.abs()).powf(1.0 / self.n)
    }

    /// `Σ (a xⁿ)ᵏ c(k n)` from k = 0.
    fn series(&self, x: f64, coefficient: impl Fn(f64) -> f64) -> f64 {
        let ratio = self.a * x.powf(self.n);
        let (mut power, mut k, mut sum) = (1.0_f64, 0.0, 0.0);
        while power.abs() > 1e-17 && k < 60.0 {
            sum += power * coefficient(k * self.n);
            power *= ratio;
            k += 1.0;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_integrals_are_the_closed_forms_of_the_first_two_powers() {
        for x in [1e-9, 0.1, 0.49, 0.51, 0.7, 0.72, 0.9, 0.999, 1.0 - 1e-9] {
            let close = |found: f64, expected: f64| {
                assert!(
                    (found - expected).abs() < 2e-14 * expected.abs().max(1e-3),
                    "{x}: {found} {expected}"
                );
            };
            close(Saturation { n: 1.0, a: 1.0 }.way(x), -(-x).ln_1p());
            close(Saturation { n: 2.0, a: 1.0 }.way(x), x.atanh());
            close(Saturation { n: 1.0, a: -1.0 }.way(x), x.ln_1p());
            close(Saturation { n: 2.0, a: -1.0 }.way(x), x.atan());
            close(Saturation { n: 1.0, a: -1.0 }.lost(x), x - 0.5 * x * x - x.ln_1p());
            let one = Saturation { n: 1.0, a: 1.0 };
            close(one.lost_rising(0.0, x, one.way(x)), -(-x).ln_1p() - x - 0.5 * x * x);
        }
    }

    #[test]
    fn a_short_way_ends_where_the_whole_integrals_say() {
        for n in [1.0, 1.3, 2.0, 4.5, 20.0] {
            let up = Saturation { n, a: 1.0 };
            let mut short = 0;
            for x in [1e-3, 0.1, 0.4, 0.7, 0.9, 0.99, 1.0 - 1e-9] {
                for w in [0.0, 1e-9, 1e-4, 0.003, 0.03, 0.1] {
                    let Some(reached) = up.rise_by_series(x, w) else { continue };
                    short += 1;
                    let way = up.way(reached.x) - up.way(x);
                    let room = 1.0 - reached.x;
                    assert!((way - w).abs() < 1e-15 / room, "{n} {x} {w}: {way}");
                    let lost = up.lost_rising(x, reached.x, w);
                    assert!(
                        (reached.lost - lost).abs() < 1e-14 * lost.max(1.0),
                        "{n} {x} {w}: {lost} {reached:?}"
                    );
                }
            }
            assert!(short > 20, "{short}");
        }
    }

    #[test]
    fn a_short_way_down_ends_where_the_whole_integrals_say() {
        for n in [1.0, 1.3, 2.0, 4.5, 20.0] {
            for a in [-1.0, -0.3, -1e-3] {
                let down = Saturation { n, a };
                for x in [1e-6, 1e-3, 0.1, 0.4, 0.7, 0.99, 1.0] {
                    for w in [1e-9, 1e-4, 0.003, 0.03, 0.1, 0.2, 0.249].map(|part| part * x) {
                        let (reached, rest) = down.fall(x, w);
                        let way = down.way(x) - down.way(reached.x);
                        assert!(rest == 0.0 && (way - w).abs() < 1e-15 * x, "{n} {a} {x} {w}: {way}");
                        let lost = (down.lost(x) - down.lost(reached.x)).abs();
                        assert!((reached.lost - lost).abs() < 1e-15 * x * x, "{n} {a} {x} {w}: {lost}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_way_up_and_down_is_the_sum_of_its_parts() {
        for n in [1.0, 1.3, 2.0, 4.5, 20.0] {
            let up = Saturation { n, a: 1.0 };
            for (x, w) in [(0.0, 0.3), (0.2, 1.5), (0.9, 0.01), (0.99, 3.0), (0.0, 30.0)] {
                let half = up.rise(x, 0.5 * w);
                let (two, one) = (up.rise(half.x, 0.5 * w), up.rise(x, w));
                assert!((two.x - one.x).abs() < 1e-13, "{n} {x} {w}: {} {}", two.x, one.x);
                let lost = half.lost + two.lost;
                assert!((lost - one.lost).abs() < 1e-12 * one.lost.max(1.0), "{n} {x} {w}");
                assert!((half.by_start * two.by_start - one.by_start).abs() < 1e-11, "{n} {x} {w}");
            }
            let down = Saturation { n, a: -0.7 };
            let (half, _) = down.fall(0.9, 0.2);
            let ((two, _), (one, rest)) = (down.fall(half.x, 0.3), down.fall(0.9, 0.5));
            assert!(
                rest == 0.0
                    && (two.x - one.x).abs() < 1e-14
                    && (half.lost + two.lost - one.lost).abs() < 1e-14
            );
        }
    }
}
