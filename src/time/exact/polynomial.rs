//! Polynomials on the unit interval, as Taylor series of a motion over a step: values, and every change of
//! sign in order.

/// Degree of every series. Over a step of two radians of the fastest motion the remainder is
/// 2²⁵/25! = 2e-18 of it.
pub(crate) const DEGREE: usize = 24;

/// Coefficients by ascending power of the fraction of the step.
pub(crate) type Series = [f64; DEGREE + 1];

/// Two roots closer than this fraction of a step count as one: a touch, not a crossing.
const TOUCH: f64 = 1e-13;

/// Value at `x`.
pub(crate) fn value(c: &Series, x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Value and slope at `x`.
fn value_and_slope(c: &Series, x: f64) -> (f64, f64) {
    c.iter().rev().fold((0.0, 0.0), |(value, slope), c| (value * x + c, slope * x + value))
}

/// The derivative.
pub(crate) fn derivative(c: &Series) -> Series {
    let mut out = [0.0; DEGREE + 1];
    for (j, out) in out.iter_mut().take(DEGREE).enumerate() {
        *out = (j + 1) as f64 * c[j + 1];
    }
    out
}

/// First crossing from below zero to above within (0, 1], or 0 where the series rises from zero or above
/// at once. A series that starts above zero by rounding but falls is taken to start at zero.
pub(crate) fn first_rise(c: &mut Series) -> Option<f64> {
    if c[0] + c[1..].iter().map(|c| c.max(0.0)).sum::<f64>() < 0.0 {
        return None;
    }
    if c[0] > 0.0 {
        let direction = c[1..].iter().copied().find(|c| *c != 0.0).unwrap_or(1.0);
        if direction > 0.0 {
            return Some(0.0);
        }
        c[0] = 0.0;
    }
    if c.iter().copied().find(|c| *c != 0.0).is_some_and(|c| c > 0.0) {
        return Some(0.0);
    }
    let mut found = None;
    sign_changes(c, &mut |root, sign| {
        found = (sign > 0.0).then_some(root);
        found.is_none()
    });
    found
}

/// Calls `visit(root, sign after it)` at every change of sign in (0, 1], in ascending order, until it
/// returns false. None is missed: intervals are split until Bernstein's coefficients, whose changes of
/// sign bound the number of roots from above, leave none or one.
pub(crate) fn sign_changes(c: &Series, visit: &mut dyn FnMut(f64, f64) -> bool) {
    let Some(first) = c.iter().copied().find(|c| *c != 0.0) else { return };
    if !c.iter().sum::<f64>().is_finite() {
        return;
    }
    let mut bernstein = *c;
    let mut binomial = 1.0;
    for (j, b) in bernstein.iter_mut().enumerate() {
        *b /= binomial;
        binomial *= (DEGREE - j) as f64 / (j + 1) as f64;
    }
    for k in 1..=DEGREE {
        for i in (k..=DEGREE).rev() {
            bernstein[i] += bernstein[i - 1];
        }
    }
    let mut sign = first.signum();
    isolate(&bernstein, 0.0, 1.0, c, &mut sign, visit);
}

/// The part of [`sign_changes`] on `[low, high]`, where `b` are Bernstein's coefficients; `sign` is the
/// sign before it and becomes that after it. False once `visit` wants no more.
fn isolate(
    b: &Series,
    low: f64,
    high: f64,
    c: &Series,
    sign: &mut f64,
    visit: &mut dyn FnMut(f64, f64) -> bool,
) -> bool {
    let (mut first, mut last, mut changes) = (0.0, 0.0, 0);
    for b in b.iter().filter(|b| **b != 0.0) {
        if first == 0.0 {
            first = b.signum();
        } else if b.signum() != last {
            changes += 1;
        }
        last = b.signum();
    }
    if first == 0.0 {
        return true;
    }
    if first != *sign {
        *sign = first;
        if !visit(low, first) {
            return false;
        }
    }
    if changes == 0 {
        return true;
    }
    if changes == 1 || high - low < TOUCH {
        if last == first {
            return true;
        }
        *sign = last;
        let root = if changes == 1 { bracketed(c, low, high, first) } else { high };
        return visit(root, last);
    }
    let (mut left, mut right) = (*b, *b);
    for (k, left) in left.iter_mut().enumerate().skip(1) {
        for i in 0..=DEGREE - k {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
        *left = right[0];
    }
    let middle = 0.5 * (low + high);
    isolate(&left, low, middle, c, sign, visit) && isolate(&right, middle, high, c, sign, visit)
}

/// The root in `[low, high]` of a series that has the sign `sign` before it: Newton's method, bisecting
/// where it leaves the bracket.
fn bracketed(c: &Series, mut low: f64, mut high: f64, sign: f64) -> f64 {
    let mut x = 0.5 * (low + high);
    for _ in 0..80 {
        let (value, slope) = value_and_slope(c, x);
        if value == 0.0 {
            return x;
        }
        if value * sign > 0.0 {
            low = x;
        } else {
            high = x;
        }
        let mut next = x - value / slope;
        if !(low < next && next < high) {
            next = 0.5 * (low + high);
        }
        if (next - x).abs() <= 1e-17 || next == low || next == high {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roots(c: &Series) -> Vec<f64> {
        let mut out = vec![];
        sign_changes(c, &mut |root, _| {
            out.push(root);
            true
        });
        out
    }

    #[test]
    fn every_crossing_is_found_in_order() {
        let cases: [(&[f64], &[f64]); 5] = [
            (&[0.3, 0.7, 1.5], &[0.3, 0.7]),
            (&[0.5, 0.500_001], &[0.5, 0.500_001]),
            (&[0.5], &[0.5]),
            (&[-0.1, 0.5, 1.0], &[0.5, 1.0]),
            (&[0.1, 0.2, 0.3, 0.4, 0.6], &[0.1, 0.2, 0.3, 0.4, 0.6]),
        ];
        for (all, expected) in cases {
            let mut c = [0.0; DEGREE + 1];
            c[0] = 1.0;
            for root in all {
                for j in (1..=DEGREE).rev() {
                    c[j] = c[j - 1] - root * c[j];
                }
                c[0] *= -root;
            }
            let mut found = roots(&c);
            // A root at the very end is a change of sign only if rounding puts it inside.
            found.retain(|x| *x < 0.999_999);
            let expected: Vec<f64> = expected.iter().copied().filter(|x| *x < 0.999_999).collect();
            assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    #[test]
    fn the_first_rise_skips_falls_and_double_crossings_within_a_step_are_seen() {
        // sin(2.6x − 1) − 0.999999: above zero for a thousandth of the interval only.
        let mut c = [0.0; DEGREE + 1];
        let (mut factor, derivatives) = (1.0, [-1f64.sin(), 1f64.cos(), 1f64.sin(), -1f64.cos()]);
        for (j, c) in c.iter_mut().enumerate() {
            *c = factor * derivatives[j % 4];
            factor *= 2.6 / (j + 1) as f64;
        }
        c[0] -= 0.999_999;
        let root = first_rise(&mut c).unwrap();
        assert!((root - ((0.999_999f64).asin() + 1.0) / 2.6).abs() < 1e-10, "{root}");
        c[0] -= 2e-6;
        assert_eq!(first_rise(&mut c), None);
    }
}
