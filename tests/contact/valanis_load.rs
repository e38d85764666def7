//! Valanis' contact under a normal load that varies within the step: against the rate law as printed,
//! integrated independently with the load of each instant.

use stickslip::contact::{ContactLaw, Valanis};

use crate::common::contact::go;

const STIFFNESS: f64 = 7.9e6;

/// A history over the time 0 to 1: displacement (m) and normal load (N).
struct History {
    name: &'static str,
    /// Force at the start, relative to the limit.
    fraction: f64,
    displacement: fn(f64) -> f64,
    load: fn(f64) -> f64,
}

const HISTORIES: [History; 9] = [
    History {
        name: "rising, below the limit",
        fraction: 0.3,
        displacement: |t| 12e-6 * t,
        load: |t| 75.0 + 225.0 * t,
    },
    History {
        name: "rising, towards saturation",
        fraction: 0.5,
        displacement: |t| 90e-6 * t,
        load: |t| 75.0 + 225.0 * t,
    },
    History {
        name: "falling, caught by the limit",
        fraction: 0.0,
        displacement: |t| 8e-6 * t,
        load: |t| 150.0 - 100.0 * t,
    },
    History {
        name: "falling, back from the limit faster than it falls",
        fraction: -1.0,
        displacement: |t| 9e-6 * t,
        load: |t| 150.0 - 60.0 * t,
    },
    History {
        name: "falling, back from the limit slower than it falls",
        fraction: 1.0,
        displacement: |t| -1e-6 * t,
        load: |t| 150.0 - 90.0 * t,
    },
    History {
        name: "curved",
        fraction: -0.6,
        displacement: |t| 30e-6 * (t + 0.5 * t * t),
        load: |t| 120.0 + 70.0 * (5.0 * t).sin(),
    },
    History { name: "lift-off", fraction: -0.8, displacement: |t| 30e-6 * t, load: |t| 150.0 - 187.0 * t },
    History { name: "re-contact", fraction: 0.0, displacement: |t| -90e-6 * t, load: |t| 150.0 * t - 50.0 },
    History {
        name: "lift-off and re-contact",
        fraction: 0.9,
        displacement: |t| 120e-6 * t,
        load: |t| 20.0 + 110.0 * (6.0 * t).cos(),
    },
];

const LAWS: [(f64, f64); 4] = [(0.0, 0.0), (0.3, 0.0), (0.67, 5.3e5), (0.9, 0.0)];

fn law(kappa: f64, e_t: f64) -> Valanis {
    Valanis::new(STIFFNESS, 0.6, kappa, e_t).unwrap()
}

/// Slope of the hysteretic force over the displacement by the rate law as printed.
fn rate(law: &Valanis, y: f64, sign: f64, load: f64) -> f64 {
    let (e0, e_t, kappa) = (law.tangential_stiffness(), law.residual_stiffness(), law.smoothness());
    let x = -law.lambda(load) / e0 * sign * y;
    e0 * (1.0 + x) / (1.0 + kappa * x) - e_t
}

/// Hysteretic force and its work over a linear piece of the path, load above zero at its end, by
/// Runge–Kutta's fourth order; the limit of each instant cuts.
fn piece(law: &Valanis, (y, work): (f64, f64), from: (f64, f64), to: (f64, f64)) -> (f64, f64) {
    let (du, dn) = (to.0 - from.0, to.1 - from.1);
    let sign = du.signum();
    let bounded = |y: f64, load: f64| y.clamp(-law.limit(load), law.limit(load));
    let slope = |y: f64, s: f64| {
        let load = from.1 + s * dn;
        du * rate(law, bounded(y, load), sign, load)
    };
    let k1 = slope(y, 0.0);
    let k2 = slope(y + 0.5 * k1, 0.5);
    let k3 = slope(y + 0.5 * k2, 0.5);
    let k4 = slope(y + k3, 1.0);
    let end = bounded(y + (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0, to.1);
    let middle = bounded(y + 0.25 * (k1 + k2), from.1 + 0.5 * dn);
    (end, work + du * (y + 4.0 * middle + end) / 6.0)
}

/// Hysteretic force at `samples` even times, and what is dissipated until the end.
fn reference(law: &Valanis, history: &History, samples: usize) -> (Vec<f64>, f64) {
    const PIECES: usize = 1000;
    let at = |i: usize| i as f64 / (samples * PIECES) as f64;
    let mut y = history.fraction * law.limit((history.load)(0.0));
    let mut work = 0.0;
    let p = law.tangential_stiffness() - law.residual_stiffness();
    let kept = y * y / (2.0 * p);
    let (mut forces, mut origin) = (Vec::new(), (history.displacement)(0.0));
    for i in 0..samples * PIECES {
        let (t0, t1) = (at(i), at(i + 1));
        let from = ((history.displacement)(t0), (history.load)(t0));
        let to = ((history.displacement)(t1), (history.load)(t1));
        let along = |s: f64| (from.0 + s * (to.0 - from.0), from.1 + s * (to.1 - from.1));
        if to.1 <= 0.0 {
            if from.1 > 0.0 {
                // Down to zero the limit takes the force along: the mean counts.
                let travel = from.1 / (from.1 - to.1) * (to.0 - from.0);
                let stretch = from.0 + travel - origin;
                // With the energy of the residual spring, which enters nowhere else.
                work += 0.5 * (y * travel + law.residual_stiffness() * stretch * stretch);
            }
            y = 0.0;
        } else if from.1 <= 0.0 {
            // From the instant N = 0 in even ratios of the load.
            let closing = -from.1 / (to.1 - from.1);
            origin = along(closing).0;
            let mut s = 1e-9;
            while s < 1.0 {
                let next = f64::min(1.05 * s, 1.0);
                let (a, b) = (along(closing + s * (1.0 - closing)), along(closing + next * (1.0 - closing)));
                (y, work) = piece(law, (y, work), a, b);
                s = next;
            }
        } else {
            (y, work) = piece(law, (y, work), from, to);
        }
        if (i + 1) % PIECES == 0 {
            forces.push(y);
        }
    }
    (forces, work + kept - y * y / (2.0 * p))
}

/// Largest error of the hysteretic force at `samples` times, with `steps` steps, and the dissipated energy.
fn error(law: &Valanis, history: &History, steps: usize, forces: &[f64]) -> (f64, f64) {
    let mut state = [0.0; 4];
    let load = (history.load)(0.0);
    law.set_state((history.displacement)(0.0), load, history.fraction * law.limit(load), &mut state);
    let (mut largest, mut dissipated) = (0.0_f64, 0.0);
    let every = steps / forces.len();
    for i in 1..=steps {
        let t = i as f64 / steps as f64;
        dissipated += go(law, &mut state, (history.displacement)(t), (history.load)(t)).dissipated_energy;
        if i % every == 0 {
            largest = largest.max((state[0] - forces[i / every - 1]).abs());
        }
    }
    (largest, dissipated)
}

#[test]
fn a_varying_load_is_followed_to_second_order_in_the_step() {
    for (kappa, e_t) in LAWS {
        let law = law(kappa, e_t);
        for history in &HISTORIES {
            let (forces, dissipated) = reference(&law, history, 4);
            let [coarse, fine] = [128, 1024].map(|steps| error(&law, history, steps, &forces));
            let size = forces.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
            // Eight times as many steps, 64 times smaller; after re-contact a law close to Jenkins', whose
            // corner the steps must first resolve, comes to it last.
            let least = if kappa < 0.9 { 8_f64.powf(1.8) } else { 8_f64.powf(1.6) };
            let context = format!("κ {kappa} {}: {coarse:?} {fine:?}", history.name);
            assert!(fine.0 <= coarse.0 / least && fine.0 < 4e-5 * size, "{context}");
            let [coarse, fine] = [coarse, fine].map(|found| (found.1 / dissipated - 1.0).abs());
            assert!(fine <= (coarse / 8_f64.powf(1.6)).max(1e-12) && fine < 5e-5, "D, {context}");
        }
    }
}

#[test]
fn a_saturated_contact_follows_its_limit_whatever_the_step() {
    for (kappa, e_t) in LAWS {
        let law = law(kappa, e_t);
        let (mut state, mut from) = ([0.0; 4], 150.0);
        law.set_state(0.0, from, law.limit(from), &mut state);
        for (i, load) in [400.0, 90.0, 20.0, 21.0, 1000.0, 3.0].into_iter().enumerate() {
            let before = law.stored_energy(&state);
            let spring = e_t * (i as f64 + 0.5 - state[3]);
            let response = go(&law, &mut state, (i + 1) as f64, load);
            assert!((state[0] / law.limit(load) - 1.0).abs() < 1e-9, "{state:?}");
            let work = 0.5 * (law.limit(from) + law.limit(load)) + spring;
            let lost = work - (law.stored_energy(&state) - before);
            assert!(
                (response.dissipated_energy / lost - 1.0).abs() < 3e-4,
                "{} {lost}",
                response.dissipated_energy
            );
            from = load;
        }
    }
}

#[test]
fn a_load_that_grows_from_zero_is_followed_exactly() {
    for (kappa, e_t) in LAWS {
        let law = law(kappa, e_t);
        for travel in [1e-10, 1e-7, 5e-6, -14e-6, 80e-6] {
            let mut state = [0.0; 4];
            law.set_state(0.0, 0.0, 0.0, &mut state);
            let response = go(&law, &mut state, travel, 150.0);
            // Force in proportion to the load: the same slope over the whole path.
            let slope = rate(&law, state[0], travel.signum(), 150.0);
            assert!((state[0] / (slope * travel) - 1.0).abs() < 1e-9, "κ {kappa} travel {travel}");
            let lost = 0.5 * response.force * travel - law.stored_energy(&state);
            let size = (0.5 * response.force * travel).abs();
            assert!((response.dissipated_energy - lost).abs() < 1e-12 * size, "κ {kappa} travel {travel}");
        }
    }
}

#[test]
fn a_step_is_continuous_where_the_load_stops_varying() {
    for (kappa, e_t) in LAWS {
        let law = law(kappa, e_t);
        for (fraction, travel) in [(-1.0, 20e-6), (0.3, 20e-6), (0.97, 3e-6), (1.0, -50e-6), (0.0, 1e-12)] {
            let step = |load: f64| {
                let mut state = [0.0; 4];
                law.set_state(0.0, 150.0, fraction * law.limit(150.0), &mut state);
                (go(&law, &mut state, travel, load), state[0])
            };
            let [below, held, above] = [150.0 * (1.0 - 1e-13), 150.0, 150.0 * (1.0 + 1e-13)].map(step);
            for (near, y) in [below, above] {
                assert!((y - held.1).abs() < 1e-10);
                let (a, b) = (near.dissipated_energy, held.0.dissipated_energy);
                assert!((a - b).abs() < 1e-12 * b + 1e-16, "{a:e} {b:e}");
                if fraction.abs() < 1.0 {
                    let (a, b) = (near.tangents, held.0.tangents);
                    assert!((a.normal_load - b.normal_load).abs() < 1e-9, "{a:?} {b:?}");
                    assert!((a.displacement - b.displacement).abs() < 1e-9 * STIFFNESS, "{a:?} {b:?}");
                }
            }
        }
    }
}
