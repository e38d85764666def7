//! What must hold for any history: energy is only lost, forces stay within the limit, and mirrored
//! histories give mirrored forces.

use proptest::prelude::*;
use stickslip::contact::{ContactLaw, Jenkins, Valanis};

use crate::common::contact::go;

/// A history: displacements (µm) and loads (N), with separations.
fn history() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let load = prop_oneof![4 => 0.0..400.0, 1 => -200.0..0.0, 1 => Just(0.0), 2 => Just(147.0)];
    let displacement = prop_oneof![8 => -80.0..80.0, 4 => -1.0..1.0, 1 => -1e4..1e4, 1 => Just(3.0)];
    prop::collection::vec((displacement, load), 1..30)
}

fn jenkins() -> impl Strategy<Value = Jenkins> {
    (4.0..8.0, 0.01..2.0).prop_map(|(exponent, mu)| Jenkins::new(10f64.powf(exponent), mu).unwrap())
}

fn valanis() -> impl Strategy<Value = Valanis> {
    valanis_with(prop_oneof![Just(0.0), 0.0..0.95, Just(0.999_999)])
}

fn valanis_with(kappa: impl Strategy<Value = f64>) -> impl Strategy<Value = Valanis> {
    let fraction = prop_oneof![Just(0.0), 0.0..0.9];
    (4.0..8.0, 0.01..2.0, kappa, fraction).prop_map(|(exponent, mu, kappa, fraction)| {
        let e0 = 10f64.powf(exponent);
        Valanis::new(e0, mu, kappa, fraction * e0).unwrap()
    })
}

/// Integral of the force over one step by Simpson's rule on `parts` even parts of it.
fn work(
    law: &dyn ContactLaw,
    state: &[f64],
    from: (f64, f64),
    to: (f64, f64),
    first: f64,
    parts: usize,
) -> f64 {
    let mut state = state.to_vec();
    let mut sum = first;
    for i in 1..=parts {
        let s = i as f64 / parts as f64;
        let load = if i == parts { to.1 } else { from.1 + s * (to.1 - from.1) };
        let force = go(law, &mut state, from.0 + s * (to.0 - from.0), load).force;
        sum += force
            * if i == parts {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
    }
    sum * (to.0 - from.0) / (3.0 * parts as f64)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn dissipation_is_never_negative_and_force_within_the_limit(
        jenkins in jenkins(), valanis in valanis(), history in history(),
    ) {
        let laws: [&dyn ContactLaw; 2] = [&jenkins, &valanis];
        for law in laws {
            let mut state = vec![0.0; law.state_len()];
            law.set_state(0.0, history[0].1, 0.0, &mut state);
            for (displacement, load) in &history {
                let response = go(law, &mut state, 1e-6 * displacement, *load);
                prop_assert!(response.dissipated_energy >= 0.0, "{:?}", response);
                let hysteretic = if law.state_len() == 3 { response.force } else { state[0] };
                prop_assert!(hysteretic.abs() <= law.limit(*load));
                prop_assert!(*load > 0.0 || response.force == 0.0);
                prop_assert!(response.tangents.displacement >= 0.0 && response.tangents.normal_load.is_finite());
            }
        }
    }

    #[test]
    fn mirrored_history_gives_mirrored_force(
        jenkins in jenkins(), valanis in valanis(), history in history(),
    ) {
        let laws: [&dyn ContactLaw; 2] = [&jenkins, &valanis];
        for law in laws {
            let mut state = vec![0.0; law.state_len()];
            law.set_state(0.0, history[0].1, 0.0, &mut state);
            let mut mirror = state.clone();
            for (displacement, load) in &history {
                let response = go(law, &mut state, 1e-6 * displacement, *load);
                let other = go(law, &mut mirror, -1e-6 * displacement, *load);
                prop_assert_eq!(response.force, -other.force);
                prop_assert_eq!(response.dissipated_energy, other.dissipated_energy);
                prop_assert_eq!(response.tangents.displacement, other.tangents.displacement);
            }
        }
    }

    /// Work into the element = energy kept + dissipated, in every single step.
    #[test]
    fn jenkins_balances_energy(law in jenkins(), history in history()) {
        let mut state = [0.0; 3];
        law.set_state(0.0, 147.0, 0.0, &mut state);
        let (mut from, mut force) = ((0.0, 147.0), 0.0);
        let kept = |force: f64| 0.5 * force * force / law.tangential_stiffness();
        for (displacement, load) in history.into_iter().take(6) {
            let to = (1e-6 * displacement, load);
            let parts = 2000;
            let done = work(&law, &state, from, to, force, parts);
            let before = force;
            let response = go(&law, &mut state, to.0, load);
            force = response.force;
            // Simpson's rule is exact but for the parts in which the force has a kink, one or two, where
            // it is off by no more than the part's length times the change of the force; and round-off of u enters the force.
            let path = (to.0 - from.0).abs();
            let stretch = law.tangential_stiffness() * path;
            let largest = law.limit(from.1).max(law.limit(load)).min(force.abs().max(before.abs()) + stretch);
            let tolerance = 4.0 / parts as f64 * path * largest + 1e-14 * largest * (to.0.abs() + from.0.abs());
            let balance = kept(force) - kept(before) + response.dissipated_energy - done;
            prop_assert!(balance.abs() <= tolerance, "off by {:e} of {:e}, tolerance {:e}", balance, done, tolerance);
            from = to;
        }
    }

    /// The same for Valanis' law along the path that it takes under a varying load: two motions, each
    /// under one load, or force and limit in proportion since the contact closed.
    #[test]
    fn valanis_balances_energy(law in valanis_with(0.0..0.95), history in history()) {
        let mut state = [0.0; 4];
        law.set_state(0.0, 147.0, 0.0, &mut state);
        for (displacement, load) in history.into_iter().take(6) {
            let kept_before = law.stored_energy(&state);
            let start = state;
            let response = go(&law, &mut state, 1e-6 * displacement, load);
            let Some(done) = valanis_work(&law, &start, &state, response.force) else { continue };
            let kept = law.stored_energy(&state);
            let balance = kept - kept_before + response.dissipated_energy - done;
            let size = kept + kept_before + response.dissipated_energy + done.abs();
            prop_assert!(balance.abs() <= 1e-6 * size, "off by {:e} of {:e}", balance, size);
        }
    }
}

/// Work done on the contact in one step. `None` where a limit behind the motion falls below the force
/// within the step and the motion leads away from it: no step under one load starts from there.
fn valanis_work(law: &Valanis, start: &[f64; 4], end: &[f64; 4], force: f64) -> Option<f64> {
    let travel = end[1] - start[1];
    if start[2] <= 0.0 {
        return Some(if end[2] <= 0.0 { 0.0 } else { 0.5 * force * (end[1] - end[3]) });
    }
    let in_contact = if end[2] > 0.0 { travel } else { travel * (start[2] / (start[2] - end[2])) };
    let e_t = law.residual_stiffness();
    if travel != 0.0 && end[2] > 0.0 && end[0] == -travel.signum() * law.limit(end[2]) {
        // Taken along by a limit behind: the force runs linearly.
        let springs = e_t * (start[1] + end[1] - 2.0 * start[3]);
        return Some(0.5 * (start[0] + end[0] + springs) * travel);
    }
    let legs = [(0.75 * in_contact, (2.0 * start[2] + end[2].max(0.0)) / 3.0), (0.25 * in_contact, end[2])];
    let (mut done, mut moving) = (0.0, *start);
    for (path, load) in legs {
        let to = moving[1] + path;
        if load <= 0.0 {
            done += e_t * (0.5 * (moving[1] + to) - moving[3]) * path;
            continue;
        }
        let limit = law.limit(load);
        moving[2] = load;
        if path.signum() * moving[0] < -limit && path != 0.0 {
            return None;
        }
        moving[0] = moving[0].clamp(-limit, limit);
        done += work_under_one_load(law, &mut moving, to);
    }
    Some(done)
}

/// Moves `moving` to the displacement `end` under its load. The force changes on the scale of
/// limit/stiffness: graded steps over the path.
fn work_under_one_load(law: &Valanis, moving: &mut [f64; 4], end: f64) -> f64 {
    let load = moving[2];
    let mut size = 0.2 * law.limit(load) / law.tangential_stiffness();
    let mut force = moving[0] + law.residual_stiffness() * (moving[1] - moving[3]);
    let mut done = 0.0;
    loop {
        let (from, left) = (moving[1], end - moving[1]);
        let last = left.abs() <= size;
        let to = if last { end } else { from + size * left.signum() };
        done += work(law, moving, (from, load), (to, load), force, 40);
        force = go(law, moving, to, load).force;
        if last {
            return done;
        }
        size *= 1.5;
    }
}
