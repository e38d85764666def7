//! Tangents of the contact laws against dual numbers run through the printed equations, and against
//! finite differences.

use num_dual::{Dual64, DualNum};
use stickslip::contact::{BoucWen, ContactLaw, GradualLaw, Inputs, Jenkins, StateTangents, Valanis};

/// Result of an oracle: force and next state.
type Outcome = (Dual64, Vec<Dual64>);

/// Jenkins' element by a walk through the events of the step: contact, slip. Written for numbers that
/// carry a derivative, from the law's definition `T = k (u − z)`, `|T| ≤ μ N`.
fn jenkins(law: &Jenkins, state: &[Dual64], u1: Dual64, n1: Dual64) -> Outcome {
    let (k, mu) = (law.tangential_stiffness(), law.friction_coefficient());
    let (mut z, u0, n0) = (state[0], state[1], state[2]);
    if n1.re <= 0.0 {
        return (Dual64::from(0.0), vec![u1, u1, n1]);
    }
    if n0.re <= 0.0 {
        z = u0 - n0 / (n1 - n0) * (u1 - u0);
    }
    let stuck = (u1 - z) * k;
    let limit = n1 * mu;
    let force = if stuck.re > limit.re {
        limit
    } else if stuck.re < -limit.re {
        -limit
    } else {
        stuck
    };
    (force, vec![u1 - force / k, u1, n1])
}

/// Valanis' hysteretic force after a motion under one limit, from the printed implicit equation
/// `a s (u − u0) = (κ/r)(ζ0 − ζ) − c2 ln(ζ/ζ0)`: bisection for the value, then Newton in dual numbers,
/// which carries the derivative.
fn valanis_motion(law: &Valanis, y: Dual64, s: f64, distance: Dual64, limit: Dual64) -> Dual64 {
    let (e0, e_t, kappa) = (law.tangential_stiffness(), law.residual_stiffness(), law.smoothness());
    let (p, r) = (e0 - e_t, e0 - kappa * e_t);
    let c2 = e0 * (1.0 - kappa) / (r * r);
    // The limit ahead cuts, and one behind at twice its amount.
    let y = match s * y.re / limit.re {
        // The printed form is singular in saturation.
        ratio if ratio >= 1.0 => return limit * s,
        ratio if ratio < -2.0 => -limit * (2.0 * s),
        _ => y,
    };
    let a = limit.recip() * (p / r);
    let zeta0 = -(a * y * s) + p / r;
    let path = a * distance;
    // In w = ln ζ, since ζ itself underflows.
    let residual = |w: Dual64| (zeta0 - w.exp()) * (kappa / r) - (w - zeta0.ln()) * c2 - path;
    let (mut low, mut high) = (zeta0.re.ln() - path.re / c2, zeta0.re.ln());
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if residual(Dual64::from(middle)).re > 0.0 { low = middle } else { high = middle }
    }
    let mut w = Dual64::from(0.5 * (low + high));
    for _ in 0..2 {
        w += residual(w) / (kappa / r * w.re.exp() + c2);
    }
    (-w.exp() + p / r) / a * s
}

/// Valanis' law over one step: two motions, three quarters under the load a third into the step and the
/// rest under the load at its end; or, where the contact closes, force and limit in proportion.
fn valanis(law: &Valanis, state: &[Dual64], u1: Dual64, n1: Dual64) -> Outcome {
    let (e0, e_t, kappa) = (law.tangential_stiffness(), law.residual_stiffness(), law.smoothness());
    let (mut y, mut u0, n0, mut origin) = (state[0], state[1], state[2], state[3]);
    if n1.re <= 0.0 {
        return (Dual64::from(0.0), vec![Dual64::from(0.0), u1, n1, u1]);
    }
    let s = (u1.re - u0.re).signum();
    let limit = n1 * law.friction_coefficient();
    if n0.re <= 0.0 {
        u0 -= n0 / (n1 - n0) * (u1 - u0);
        origin = u0;
        // Rate law with y = ratio × limit: p r/(1 − κ)/e0 g/(1 + b g) = limit × ratio/distance.
        let (p, r) = (e0 - e_t, e0 - kappa * e_t);
        let b = kappa * p / (e0 * (1.0 - kappa));
        let rho = (u1 - u0) * s / limit * (p * r / (e0 * (1.0 - kappa)));
        let defect = |g: Dual64| (-g + 1.0) * (g * b + 1.0) - rho * g;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if defect(Dual64::from(middle)).re > 0.0 { low = middle } else { high = middle }
        }
        let mut g = Dual64::from(0.5 * (low + high));
        for _ in 0..2 {
            g += defect(g) / (1.0 - b + 2.0 * b * g.re + rho.re);
        }
        y = limit * s * (-g + 1.0);
    } else {
        let path = (u1 - u0) * s;
        let early = (n0 * 2.0 + n1) / 3.0 * law.friction_coefficient();
        y = valanis_motion(law, y, s, path * 0.75, early);
        y = valanis_motion(law, y, s, path * 0.25, limit);
        if s * y.re < -limit.re {
            y = -limit * s;
        }
    }
    (y + (u1 - origin) * e_t, vec![y, u1, n1, origin])
}

/// Parameters of Bouc and Wen's law that it does not tell: μ, n, r.
type Shape = (f64, f64, f64);

/// `∫ dt/(1 − a tⁿ)` from `from` to `to`, both in `[0, 1]`, by Simpson's rule over a coordinate in which the integrand is
/// smooth at zero, and up to saturation: `t = q²` away from it, `t = 1 − exp(−q²)` towards it (a = 1).
fn bouc_wen_way(n: f64, a: f64, from: Dual64, to: Dual64) -> Dual64 {
    let rises = a == 1.0;
    let coordinate = |t: Dual64| match (t.re, rises) {
        (0.0, _) => Dual64::from(0.0),
        (_, true) => (-(-t + 1.0).ln()).sqrt(),
        (_, false) => t.sqrt(),
    };
    let (start, span) = (coordinate(from), coordinate(to) - coordinate(from));
    let at = |share: f64| {
        let q = start + span * share;
        let left = if rises { (-q * q).exp() } else { Dual64::from(1.0) };
        let t = if rises { -left + 1.0 } else { q * q };
        let power = if t.re == 0.0 { Dual64::from(0.0) } else { t.powf(n) };
        q * 2.0 * left / (-power * a + 1.0)
    };
    let parts = 500;
    let weight = |index: u32| if index % 2 == 1 { 4.0 } else { 2.0 };
    let inner: Dual64 = (1..parts).map(|i| at(f64::from(i) / f64::from(parts)) * weight(i)).sum();
    let way = (at(0.0) + inner + at(1.0)) * span / (3.0 * f64::from(parts));
    // At zero the coordinate has no derivative, and the integrand is one.
    if from.re == 0.0 { way - from } else { way }
}

/// Where a way along `dx/dw = 1 − a xⁿ` ends, in `direction`: bisection, then Newton's steps, the last of which carries
/// the derivative.
fn bouc_wen_follow(n: f64, a: f64, from: Dual64, way: Dual64, direction: f64) -> Dual64 {
    let gone = |to: f64| bouc_wen_way(n, a, from, Dual64::from(to)) * direction;
    let (mut near, mut far) = if direction > 0.0 { (from.re, 1.0 - 1e-12) } else { (from.re, 0.0) };
    if direction > 0.0 && gone(far).re < way.re {
        return Dual64::from(1.0);
    }
    for _ in 0..10 {
        // Towards saturation halves of the gap's logarithm.
        let middle =
            if direction > 0.0 { 1.0 - ((1.0 - near) * (1.0 - far)).sqrt() } else { 0.5 * (near + far) };
        if gone(middle).re < way.re { near = middle } else { far = middle }
    }
    // From beyond the root the steps do not pass it.
    let mut x = Dual64::from(far);
    for _ in 0..6 {
        x = (way - gone(x.re)) * direction * (1.0 - a * x.re.powf(n)) + x.re;
    }
    x
}

/// Bouc and Wen's hysteretic force after a motion under one limit.
fn bouc_wen_motion((mu, n, r): Shape, k: f64, y: Dual64, travel: Dual64, load: Dual64) -> Dual64 {
    let limit = load * mu;
    let y = if y.re.abs() > limit.re { limit * y.re.signum() } else { y };
    let s = travel.re.signum();
    let (x, way) = (y * s / limit, travel * s * k / limit);
    // In saturation the gap falls exponentially.
    if x.re >= 1.0 - 1e-9 {
        return limit * s * (-(-x + 1.0) * (way * -n).exp() + 1.0);
    }
    let mut x = x;
    let mut way = way;
    if x.re < 0.0 {
        let back = bouc_wen_way(n, 1.0 - r, Dual64::from(0.0), -x);
        if back.re > way.re {
            return limit * s * -bouc_wen_follow(n, 1.0 - r, -x, way, -1.0);
        }
        (x, way) = (Dual64::from(0.0), way - back);
    }
    x = bouc_wen_follow(n, 1.0, x, way, 1.0);
    limit * s * x
}

/// Bouc and Wen's law over one step, split as Valanis' is.
fn bouc_wen(law: &BoucWen, shape: Shape, state: &[Dual64], u1: Dual64, n1: Dual64) -> Outcome {
    let numbers = law.gradual();
    let (mut y, u0, mut n0, mut origin) = (state[0], state[1], state[2], state[3]);
    if n1.re <= 0.0 {
        return (Dual64::from(0.0), vec![Dual64::from(0.0), u1, n1, u1]);
    }
    let mut travel = u1 - u0;
    if n0.re <= 0.0 {
        travel = travel * n1 / (n1 - n0);
        origin = u1 - travel;
        (y, n0) = (Dual64::from(0.0), Dual64::from(0.0));
    }
    for (share, load) in [(0.75, (n0 * 2.0 + n1) / 3.0), (0.25, n1)] {
        y = bouc_wen_motion(shape, numbers.hysteretic_stiffness, y, travel * share, load);
    }
    (y + (u1 - origin) * numbers.residual_stiffness, vec![y, u1, n1, origin])
}

/// Scales in which errors are judged: force 1 N, displacement 1 µm.
fn unit(index: usize, len: usize) -> f64 {
    let displacement = if len == 3 { index < 2 } else { index == 1 || index == 3 };
    if displacement { 1e-6 } else { 1.0 }
}

fn same(found: f64, expected: f64, unit: f64, what: &str) {
    let tolerance = 1e-8 * (unit + expected.abs());
    assert!((found - expected).abs() <= tolerance, "{what}: {found:e} instead of {expected:e}");
}

/// Compares every derivative of one step with the oracle's, and with central differences.
fn check(
    law: &dyn ContactLaw,
    oracle: &dyn Fn(&[Dual64], Dual64, Dual64) -> Outcome,
    state: &[f64],
    u: f64,
    load: f64,
) {
    let n = state.len();
    let context = format!("{law:?} from {state:?} to u {u:e}, N {load:e}");
    let step = |state: &[f64], displacement: f64, normal_load: f64| {
        let mut next = vec![0.0; n];
        let response = law.step(state, Inputs { displacement, velocity: 0.0, normal_load }, &mut next);
        (response, next)
    };
    let (response, next) = step(state, u, load);
    let mut tangents = StateTangents::default();
    law.state_tangents(state, Inputs { displacement: u, velocity: 0.0, normal_load: load }, &mut tangents);
    assert_eq!(response.tangents.velocity, 0.0);
    assert!(tangents.next_by_velocity.iter().all(|value| *value == 0.0));
    // Columns: the state's components, then displacement, then normal load.
    for column in 0..n + 2 {
        let seed = |index: usize, value: f64| {
            if index == column { Dual64::from(value).derivative() } else { Dual64::from(value) }
        };
        let dual_state: Vec<_> = state.iter().enumerate().map(|(i, value)| seed(i, *value)).collect();
        let (force, dual_next) = oracle(&dual_state, seed(n, u), seed(n + 1, load));
        let h_unit = match column {
            c if c < n => unit(c, n),
            c if c == n => 1e-6,
            _ => 1.0,
        };
        same(response.force, force.re, 1.0, &format!("force, {context}"));
        let by = match column {
            c if c < n => tangents.force_by_state[c],
            c if c == n => response.tangents.displacement,
            _ => response.tangents.normal_load,
        };
        same(by, force.eps, 1.0 / h_unit, &format!("∂force, column {column}, {context}"));
        // Central difference as a check of the oracle itself.
        let h = 1e-5 * h_unit;
        let moved = |sign: f64| {
            let mut state = state.to_vec();
            let (mut u, mut load) = (u, load);
            match column {
                c if c < n => state[c] += sign * h,
                c if c == n => u += sign * h,
                _ => load += sign * h,
            }
            step(&state, u, load).0.force
        };
        let difference = (moved(1.0) - moved(-1.0)) / (2.0 * h);
        assert!((difference - by).abs() * h_unit < 1e-3, "difference {difference:e} for {by:e}, {context}");
        for row in 0..n {
            let found = match column {
                c if c < n => tangents.next_by_state[row * n + c],
                c if c == n => tangents.next_by_displacement[row],
                _ => tangents.next_by_normal_load[row],
            };
            same(next[row], dual_next[row].re, unit(row, n), &format!("next {row}, {context}"));
            let what = format!("∂next {row}, column {column}, {context}");
            same(found, dual_next[row].eps, unit(row, n) / h_unit, &what);
        }
    }
}

/// Start and end loads: in contact, falling below the force, separation, re-contact, apart.
const LOADS: [(f64, f64); 8] = [
    (150.0, 150.0),
    (150.0, 400.0),
    (150.0, 40.0),
    (150.0, 3.0),
    (150.0, -20.0),
    (-50.0, 150.0),
    (-50.0, 20.0),
    (-50.0, -20.0),
];

// Chosen off the kinks between stick and slip, where no derivative exists.
const TRAVELS: [f64; 7] = [-110e-6, -21e-6, -3.1e-6, -0.11e-6, 0.13e-6, 4.3e-6, 57e-6];

#[test]
fn jenkins_tangents_equal_dual_derivatives() {
    let law = Jenkins::new(2e6, 0.37).unwrap();
    for (start_load, end_load) in LOADS {
        for fraction in [-0.93, -0.31, 0.0, 0.57, 0.97] {
            for travel in TRAVELS {
                let mut state = [0.0; 3];
                law.set_state(2e-6, start_load, fraction * law.limit(start_load), &mut state);
                let oracle = |state: &[Dual64], u, n| jenkins(&law, state, u, n);
                check(&law, &oracle, &state, 2e-6 + travel, end_load);
            }
        }
    }
}

#[test]
fn valanis_tangents_equal_dual_derivatives() {
    for (kappa, e_t) in [(0.0, 0.0), (0.3, 0.0), (0.67, 5.3e5), (0.0, 1e6), (0.95, 3e6)] {
        let law = Valanis::new(7.9e6, 0.6, kappa, e_t).unwrap();
        for (start_load, end_load) in LOADS {
            for fraction in [-0.93, -0.31, 0.0, 0.57, 0.97] {
                for travel in TRAVELS {
                    let mut state = [0.0; 4];
                    law.set_state(2e-6, start_load, fraction * law.limit(start_load), &mut state);
                    if start_load > 0.0 {
                        state[3] = -7e-6;
                    }
                    let oracle = |state: &[Dual64], u, n| valanis(&law, state, u, n);
                    check(&law, &oracle, &state, 2e-6 + travel, end_load);
                }
            }
        }
    }
}

#[test]
fn bouc_wen_tangents_equal_dual_derivatives() {
    for (n, r, e_t) in [(1.0, 1.0, 0.0), (1.4, 1.3, 3e5), (2.0, 2.0, 0.0), (5.0, 1.6, 1e6)] {
        let law = BoucWen::new(7.9e6, 0.6, n, r, e_t).unwrap();
        for (start_load, end_load) in LOADS {
            for share in [-0.93, -0.31, 0.0, 0.57, 0.97] {
                for travel in TRAVELS {
                    let mut state = [0.0; 4];
                    law.set_state(2e-6, start_load, share * law.limit(start_load), &mut state);
                    if start_load > 0.0 {
                        state[3] = -7e-6;
                    }
                    let oracle = |state: &[Dual64], u, load| bouc_wen(&law, (0.6, n, r), state, u, load);
                    check(&law, &oracle, &state, 2e-6 + travel, end_load);
                }
            }
        }
    }
}

#[test]
fn a_step_without_motion_has_finite_tangents() {
    let valanis = Valanis::new(7.9e6, 0.6, 0.3, 1e5).unwrap();
    let jenkins = Jenkins::new(2e6, 0.37).unwrap();
    let laws: [&dyn ContactLaw; 2] = [&valanis, &jenkins];
    for law in laws {
        for fraction in [-1.0, 0.0, 0.4, 1.0] {
            let n = law.state_len();
            let (mut state, mut next) = (vec![0.0; n], vec![0.0; n]);
            law.set_state(1e-6, 100.0, fraction * law.limit(100.0), &mut state);
            let inputs = Inputs { displacement: 1e-6, velocity: 0.0, normal_load: 100.0 };
            let response = law.step(&state, inputs, &mut next);
            assert!((response.force - fraction * law.limit(100.0)).abs() < 1e-9);
            assert!(response.dissipated_energy.abs() < 1e-18);
            assert!(response.tangents.displacement.is_finite() && response.tangents.displacement >= 0.0);
        }
    }
}
