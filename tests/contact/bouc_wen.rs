//! Items to verify: the closed forms of the exponent 1, an independent integration, energy, derivatives, and that the
//! law knows no rate.

use stickslip::contact::{BoucWen, ContactLaw, GradualLaw, Inputs, StateTangents};

use crate::common::contact::go;

const STIFFNESS: f64 = 2e6;
const FRICTION: f64 = 0.5;
const LOAD: f64 = 100.0;
const LIMIT: f64 = FRICTION * LOAD;

fn law(sharpness: f64, ratio: f64, residual: f64) -> BoucWen {
    BoucWen::new(STIFFNESS, FRICTION, sharpness, ratio, residual).unwrap()
}

fn rest(law: &dyn ContactLaw) -> Vec<f64> {
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, LOAD, 0.0, &mut state);
    state
}

/// Reversals and where they are, in yield displacements; the load as a fraction of [`LOAD`].
const HISTORY: [(f64, f64); 9] = [
    (0.4, 1.0),
    (2.5, 1.2),
    (-1.0, 0.7),
    (-3.0, 0.4),
    (0.2, 1.5),
    (0.1, -0.2),
    (0.9, 0.8),
    (4.0, 0.8),
    (3.9, 0.8),
];

fn shapes() -> impl Iterator<Item = (f64, f64)> {
    [1.0, 1.4, 2.0, 5.0, 20.0].into_iter().flat_map(|n| [1.0, 1.3, 2.0].map(|ratio| (n, ratio)))
}

#[test]
fn with_the_exponent_one_both_branches_are_exponentials() {
    let yielding = LIMIT / STIFFNESS;
    for ratio in [1.0, 1.5, 2.0] {
        let law = law(1.0, ratio, 0.0);
        let mut state = rest(&law);
        let peak = go(&law, &mut state, 1.7 * yielding, LOAD).force;
        assert!((peak - LIMIT * (1.0 - f64::exp(-1.7))).abs() < 1e-12 * LIMIT, "{peak}");
        // Down from x by w: ln(1 + c x) falls by c w; for c = 0 the line.
        let (x, c, w) = (peak / LIMIT, ratio - 1.0, 0.4);
        let expected = if c == 0.0 { x - w } else { ((1.0 + c * x) * f64::exp(-c * w) - 1.0) / c };
        let found = go(&law, &mut state, (1.7 - w) * yielding, LOAD).force / LIMIT;
        assert!((found - expected).abs() < 1e-13, "{ratio}: {found} {expected}");
    }
}

#[test]
fn one_step_equals_many_and_those_of_an_independent_integration() {
    for (n, ratio) in shapes() {
        let residual = 3e5;
        let law = law(n, ratio, residual);
        let k = STIFFNESS - residual;
        let (mut one, mut many) = (rest(&law), rest(&law));
        let (mut y, mut at) = (0.0_f64, 0.0);
        let (beta, gamma) = (0.5 * ratio, 1.0 - 0.5 * ratio);
        for end in [0.6, -0.3, 1.5, -2.0, -1.9, 2.2] {
            let end = end * LIMIT / STIFFNESS;
            let force = go(&law, &mut one, end, LOAD).force;
            let parts = 4000;
            let h = (end - at) / f64::from(parts);
            let slope = |y: f64| k * (1.0 - (y / LIMIT).abs().powf(n) * (gamma + beta * (h * y).signum()));
            for part in 1..=parts {
                // Runge and Kutta's method of fourth order.
                let k1 = slope(y);
                let k2 = slope(y + 0.5 * h * k1);
                let k3 = slope(y + 0.5 * h * k2);
                let k4 = slope(y + h * k3);
                y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                if part % 500 == 0 {
                    go(&law, &mut many, at + f64::from(part) * h, LOAD);
                }
            }
            at = end;
            assert!((force - (y + residual * end)).abs() < 1e-7 * LIMIT, "{n} {ratio} {end}: {force} {y}");
            assert!((one[0] - many[0]).abs() < 1e-11 * LIMIT, "{n} {ratio}: {} {}", one[0], many[0]);
        }
    }
}

#[test]
fn energy_is_only_lost_and_balances_the_work() {
    for (n, ratio) in shapes() {
        let law = law(n, ratio, 3e5);
        let mut state = rest(&law);
        let (mut at, mut force) = (0.0, 0.0);
        for (end, _) in HISTORY {
            let end = end * LIMIT / STIFFNESS;
            let kept = law.stored_energy(&state);
            let (parts, mut work, mut lost) = (4000, 0.0, 0.0);
            let start = at;
            for part in 1..=parts {
                let next = start + (end - start) * f64::from(part) / f64::from(parts);
                let response = go(&law, &mut state, next, LOAD);
                assert!(response.dissipated_energy >= 0.0);
                work += 0.5 * (force + response.force) * (next - at);
                lost += response.dissipated_energy;
                (at, force) = (next, response.force);
            }
            let balance = work - lost - (law.stored_energy(&state) - kept);
            assert!(
                balance.abs() < 1e-5 * LIMIT * (end - start).abs(),
                "{n} {ratio}: {balance:e} of {work:e}"
            );
        }
    }
}

#[test]
fn under_any_load_nothing_is_made_and_the_force_stays_within_the_limit() {
    for (n, ratio) in shapes() {
        let law = law(n, ratio, 0.0);
        let mut state = rest(&law);
        for (end, load) in HISTORY {
            let (end, load) = (end * LIMIT / STIFFNESS, load * LOAD);
            let response = go(&law, &mut state, end, load);
            assert!(response.dissipated_energy >= 0.0, "{n} {ratio} {end}");
            assert!(response.force.abs() <= law.limit(load) * (1.0 + 1e-14), "{n} {ratio} {end}");
        }
    }
}

#[test]
fn a_varying_load_is_met_with_the_square_of_the_step() {
    let law = law(1.6, 1.4, 2e5);
    let end = |parts: u32| {
        let mut state = rest(&law);
        let whole = 0.9 * LIMIT / STIFFNESS;
        for part in 1..=parts {
            let way = f64::from(part) / f64::from(parts);
            go(&law, &mut state, whole * way, LOAD * (0.7 + 0.6 * way));
        }
        state[0]
    };
    let exact = end(2048);
    let [coarse, fine] = [8, 16].map(|parts| (end(parts) - exact).abs());
    assert!(coarse < 1e-3 * LIMIT && fine < 0.3 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn tangents_are_differences() {
    for (n, ratio) in shapes() {
        let law = law(n, ratio, 3e5);
        let mut state = rest(&law);
        for (end, load) in HISTORY {
            let inputs =
                Inputs { displacement: end * LIMIT / STIFFNESS, velocity: 0.0, normal_load: load * LOAD };
            // At the limit the derivatives jump.
            if state[0].abs() > 0.999 * law.limit(state[2]) {
                go(&law, &mut state, inputs.displacement, inputs.normal_load);
                continue;
            }
            let sizes = [1e-6 * LIMIT, 1e-6 * LIMIT / STIFFNESS, 1e-6 * LOAD, 1e-6 * LIMIT / STIFFNESS];
            let run = |state: &[f64], inputs: Inputs| {
                let mut next = vec![0.0; 4];
                let force = law.step(state, inputs, &mut next).force;
                [force, next[0], next[1], next[2], next[3]]
            };
            let mut out = StateTangents::default();
            law.state_tangents(&state, inputs, &mut out);
            let tangents = law.step(&state, inputs, &mut [0.0; 4]).tangents;
            let scale = [LIMIT, LIMIT, LIMIT / STIFFNESS, LOAD, LIMIT / STIFFNESS];
            let check = |plus: [f64; 5], minus: [f64; 5], size: f64, found: [f64; 5], what: &str| {
                for row in 0..5 {
                    let difference = (plus[row] - minus[row]) / 2.0;
                    let error = (difference - found[row] * size).abs();
                    assert!(
                        error < 2e-9 * scale[row],
                        "{n} {ratio} {end} {what} {row}: {difference:e} {}",
                        found[row] * size
                    );
                }
            };
            for column in 0..4 {
                let moved = |sign: f64| {
                    let mut state = state.clone();
                    state[column] += sign * sizes[column];
                    run(&state, inputs)
                };
                let found = [
                    out.force_by_state[column],
                    out.next_by_state[column],
                    out.next_by_state[4 + column],
                    out.next_by_state[8 + column],
                    out.next_by_state[12 + column],
                ];
                check(moved(1.0), moved(-1.0), sizes[column], found, "state");
            }
            let by_displacement = |sign: f64| {
                run(&state, Inputs { displacement: inputs.displacement + sign * sizes[1], ..inputs })
            };
            let next = &out.next_by_displacement;
            let found = [tangents.displacement, next[0], next[1], next[2], next[3]];
            check(by_displacement(1.0), by_displacement(-1.0), sizes[1], found, "displacement");
            let by_load = |sign: f64| {
                run(&state, Inputs { normal_load: inputs.normal_load + sign * sizes[2], ..inputs })
            };
            let next = &out.next_by_normal_load;
            let found = [tangents.normal_load, next[0], next[1], next[2], next[3]];
            check(by_load(1.0), by_load(-1.0), sizes[2], found, "load");
            go(&law, &mut state, inputs.displacement, inputs.normal_load);
        }
    }
}

#[test]
fn velocity_plays_no_role() {
    let law = law(1.5, 1.2, 0.0);
    let force = |velocity| {
        let inputs = Inputs { displacement: 30e-6, velocity, normal_load: LOAD };
        law.step(&rest(&law), inputs, &mut [0.0; 4]).force
    };
    assert_eq!(force(0.0), force(3.0));
}
