//! Exact response of damped modes to polynomial forcing over one step.
//!
//! For one mode `q̈ + 2ζω q̇ + ω² q = p(t)` let `R_m(τ)` be the response from rest to `sᵐ/m!`, and
//! `R₋₁ = k` the impulse response. Then `R_m' = R_{m−1}` and the equation of motion itself is the
//! recurrence `R_{m−2} + 2ζω R_{m−1} + ω² R_m = τᵐ/m!`. Upwards it divides by ω² and loses digits
//! for small `ωτ`; downwards it does not, and starts from two Taylor series.

/// Nodes of a step, as fractions of it.
pub(crate) const NODES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Those of the quadratic through the forcing, besides the start.
pub(crate) const MIDDLE: usize = 2;
pub(crate) const END: usize = 4;

/// Quadratic Lagrange polynomials on {0, ½, 1}: coefficients of σ⁰, σ¹, σ².
const QUADRATIC_BASIS: [[f64; 3]; 3] = [[1.0, -3.0, 2.0], [0.0, 4.0, -4.0], [0.0, -1.0, 2.0]];

/// Quartic Lagrange polynomials on {0, ¼, ½, ¾, 1}: coefficients of σ⁰ … σ⁴.
const QUARTIC_BASIS: [[f64; 5]; 5] = [
    [1.0, -25.0 / 3.0, 70.0 / 3.0, -80.0 / 3.0, 32.0 / 3.0],
    [0.0, 16.0, -208.0 / 3.0, 96.0, -128.0 / 3.0],
    [0.0, -12.0, 76.0, -128.0, 64.0],
    [0.0, 16.0 / 3.0, -112.0 / 3.0, 224.0 / 3.0, -128.0 / 3.0],
    [0.0, -1.0, 22.0 / 3.0, -16.0, 32.0 / 3.0],
];

/// Factors of five numbers in `q` and `v` of a mode at a node behind the start.
pub(crate) type Row = [[f64; 2]; 5];

/// The coefficients of all modes for one step size.
#[derive(Debug, Clone)]
pub(crate) struct Propagator {
    step: f64,
    nodes: [Vec<Row>; 4],
    /// Factors of the forcing at the five nodes in `q` and `v` at the end.
    pub quartic: Vec<Row>,
}

impl Propagator {
    /// Room for `modes` modes; valid for no step size yet.
    pub fn new(modes: usize) -> Self {
        let rows = || vec![[[0.0; 2]; 5]; modes];
        Self { step: f64::NAN, nodes: std::array::from_fn(|_| rows()), quartic: rows() }
    }

    /// Whether the coefficients are those of `step` (s).
    pub fn is_for(&self, step: f64) -> bool {
        self.step == step
    }

    /// Computes the coefficients for `step` (s), with `angular_frequency` (rad/s) and `damping_ratio`.
    pub fn fill(&mut self, angular_frequency: &[f64], damping_ratio: &[f64], step: f64) {
        for (mode, (&omega, &zeta)) in angular_frequency.iter().zip(damping_ratio).enumerate() {
            self.fill_mode(mode, omega, zeta, step);
        }
        self.step = step;
    }

    /// Factors, at node 1 … 4, of `q₀`, `v₀`, `p₀` and the forcing at the middle and at the end, mode by mode.
    pub fn node(&self, node: usize) -> &[Row] {
        &self.nodes[node - 1]
    }

    fn fill_mode(&mut self, mode: usize, omega: f64, zeta: f64, step: f64) {
        let mut impulse = [impulse_response(omega, zeta, 0.25 * step); 4];
        // Semigroup property: one exponential and one sine serve all four nodes.
        impulse[1] = compose(omega, zeta, impulse[0], impulse[0]);
        impulse[2] = compose(omega, zeta, impulse[1], impulse[0]);
        impulse[3] = compose(omega, zeta, impulse[1], impulse[1]);
        for (node, &at_node) in impulse.iter().enumerate() {
            let responses = Responses::new(omega, zeta, NODES[node + 1] * step, at_node);
            let moments = responses.moments(step);
            let k = responses.of(-1);
            let [start, middle, end] = QUADRATIC_BASIS.map(|basis| combine(&basis, &moments));
            self.nodes[node][mode] = [
                [responses.of(-2) + 2.0 * zeta * omega * k, -omega * omega * k],
                [k, responses.of(-2)],
                start,
                middle,
                end,
            ];
            if node == 3 {
                self.quartic[mode] = QUARTIC_BASIS.map(|basis| combine(&basis, &moments));
            }
        }
    }
}

/// `q` and `v` by these `numbers`, of which `row` has the factors.
#[inline(always)]
pub(crate) fn weighed(row: &[[f64; 2]], numbers: &[f64]) -> [f64; 2] {
    let mut sums = [-0.0; 2];
    for (factors, by) in row.iter().zip(numbers) {
        sums = [sums[0] + factors[0] * by, sums[1] + factors[1] * by];
    }
    sums
}

/// Displacement and velocity due to the polynomial with these coefficients.
fn combine(coefficients: &[f64], moments: &[(f64, f64); 5]) -> [f64; 2] {
    coefficients.iter().zip(moments).fold([0.0; 2], |[q, v], (c, m)| [q + c * m.0, v + c * m.1])
}

/// Impulse response `k` and its derivative after `a` then `b`.
fn compose(omega: f64, zeta: f64, a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let (ka, da) = a;
    let (kb, db) = b;
    ((da + 2.0 * zeta * omega * ka) * kb + ka * db, da * db - omega * omega * ka * kb)
}

/// Impulse response `k(τ)` and `k'(τ)`, for any damping.
fn impulse_response(omega: f64, zeta: f64, tau: f64) -> (f64, f64) {
    let decay = zeta * omega;
    if zeta < 1.0 {
        let y = omega * (1.0 - zeta * zeta).sqrt() * tau;
        let (sine, cosine) = y.sin_cos();
        let sinc = if y < 1e-4 { 1.0 - y * y / 6.0 } else { sine / y };
        let envelope = (-decay * tau).exp();
        (envelope * tau * sinc, envelope * (cosine - decay * tau * sinc))
    } else {
        let split = omega * (zeta * zeta - 1.0).sqrt();
        let y = split * tau;
        if y < 1.0 {
            let sinhc = if y < 1e-4 { 1.0 + y * y / 6.0 } else { y.sinh() / y };
            let envelope = (-decay * tau).exp();
            (envelope * tau * sinhc, envelope * (y.cosh() - decay * tau * sinhc))
        } else {
            let fast = decay + split;
            let slow = omega * omega / fast;
            let (e_slow, e_fast) = ((-slow * tau).exp(), (-fast * tau).exp());
            ((e_slow - e_fast) / (2.0 * split), (fast * e_fast - slow * e_slow) / (2.0 * split))
        }
    }
}

/// `R₋₂ … R₄` at one time.
struct Responses([f64; 7]);

impl Responses {
    fn new(omega: f64, zeta: f64, tau: f64, (k, k_derivative): (f64, f64)) -> Self {
        let damping = 2.0 * zeta * omega;
        let square = omega * omega;
        // τᵐ/m!
        let mut power = [1.0; 5];
        for m in 1..5 {
            power[m] = power[m - 1] * tau / m as f64;
        }
        let mut r = [0.0; 7];
        if omega * tau * (2.0 * zeta).max(1.0) <= 1.0 {
            (r[5], r[6]) = taylor(omega * tau, zeta, power[4], tau);
            for m in (0..5).rev() {
                r[m] = power[m] - damping * r[m + 1] - square * r[m + 2];
            }
        } else {
            r[0] = k_derivative;
            r[1] = k;
            for m in 0..5 {
                r[m + 2] = (power[m] - damping * r[m + 1] - r[m]) / square;
            }
        }
        Self(r)
    }

    fn of(&self, order: i32) -> f64 {
        self.0[(order + 2) as usize]
    }

    /// Displacement and velocity due to the forcing `(s/h)ᵐ`, m = 0 … 4.
    fn moments(&self, step: f64) -> [(f64, f64); 5] {
        let mut factor = 1.0;
        std::array::from_fn(|m| {
            if m > 0 {
                factor *= m as f64 / step;
            }
            (factor * self.0[m + 2], factor * self.0[m + 1])
        })
    }
}

/// `R₃` and `R₄` by Taylor series in `τ`; `x = ωτ ≤ 1`, `power4 = τ⁴/4!`.
fn taylor(x: f64, zeta: f64, power4: f64, tau: f64) -> (f64, f64) {
    // βₙ = bₙ τⁿ with b₀ = 1, bₙ = −2ζω bₙ₋₁ − ω² bₙ₋₂; R₃ = Σ βₙ τ⁵/(n+5)!, R₄ = Σ βₙ τ⁶/(n+6)!.
    let power5 = power4 * tau / 5.0;
    let (mut previous, mut beta) = (0.0, 1.0);
    let mut weight = 1.0; // 5!/(n+5)!
    let (mut sum3, mut sum4) = (0.0, 0.0);
    for n in 0..40 {
        sum3 += beta * weight;
        sum4 += beta * weight / (n + 6) as f64;
        (previous, beta) = (beta, -2.0 * zeta * x * beta - x * x * previous);
        weight /= (n + 6) as f64;
        if (beta.abs() + previous.abs()) * weight < 1e-19 {
            break;
        }
    }
    (power5 * sum3, power5 * tau * sum4)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Composite Simpson of the convolution: an independent, slow oracle.
    fn convolve(omega: f64, zeta: f64, tau: f64, forcing: impl Fn(f64) -> f64) -> (f64, f64) {
        let n = 4000;
        let ds = tau / n as f64;
        (0..=n).fold((0.0, 0.0), |(q, v), i| {
            let s = i as f64 * ds;
            let weight = if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 } * ds / 3.0;
            let (k, d) = impulse_response(omega, zeta, tau - s);
            (q + weight * k * forcing(s), v + weight * d * forcing(s))
        })
    }

    #[test]
    fn forced_response_equals_the_convolution_with_the_impulse_response() {
        let step = 1e-3;
        for (omega, zeta) in
            [(3.0, 0.01), (900.0, 0.0), (1100.0, 0.3), (5e3, 0.003), (800.0, 1.0), (700.0, 1.4), (2e3, 3.0)]
        {
            let mut propagator = Propagator::new(1);
            propagator.fill(&[omega], &[zeta], step);
            let forcing = |s: f64| {
                let sigma = s / step;
                2.0 - 3.0 * sigma + 5.0 * sigma * sigma
            };
            for (node, &at) in NODES.iter().enumerate().skip(1) {
                let p = [forcing(0.0), forcing(0.5 * step), forcing(step)];
                let [q, v] = weighed(&propagator.node(node)[0][2..], &p);
                let (q_exact, v_exact) = convolve(omega, zeta, at * step, forcing);
                assert!((q - q_exact).abs() < 1e-10 * step * step, "{omega} {zeta} {node}: {q} {q_exact}");
                assert!((v - v_exact).abs() < 1e-10 * step, "{omega} {zeta} {node}: {v} {v_exact}");
            }
            let quartic = |s: f64| {
                let sigma = s / step;
                1.0 + sigma - 2.0 * sigma.powi(3) + 4.0 * sigma.powi(4)
            };
            let [q, v] = weighed(&propagator.quartic[0], &NODES.map(|node| quartic(node * step)));
            let (q_exact, v_exact) = convolve(omega, zeta, step, quartic);
            assert!((q - q_exact).abs() < 1e-10 * step * step);
            assert!((v - v_exact).abs() < 1e-10 * step);
        }
    }

    #[test]
    fn series_and_closed_form_meet_at_the_switch() {
        for zeta in [0.0, 0.003, 0.2, 0.49] {
            let just = |x: f64| {
                let impulse = impulse_response(x, zeta, 1.0);
                Responses::new(x, zeta, 1.0, impulse)
            };
            let (below, above) = (just(1.0 - 1e-13), just(1.0 + 1e-13));
            for order in -2..=4 {
                let (a, b) = (below.of(order), above.of(order));
                assert!((a - b).abs() < 2e-12 * a.abs().max(1e-2), "{zeta} {order}: {a} {b}");
            }
        }
    }

    #[test]
    fn a_free_rigid_mode_moves_by_newtons_law() {
        let mut propagator = Propagator::new(1);
        propagator.fill(&[0.0], &[0.0], 0.1);
        let end = propagator.node(END)[0];
        assert_eq!(end[0][0], 1.0);
        assert!((end[1][0] - 0.1).abs() < 1e-16);
        let [q, _] = weighed(&end[2..], &[1.0; 3]);
        assert!((q - 0.005).abs() < 1e-17);
    }
}
