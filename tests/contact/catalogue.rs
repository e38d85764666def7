//! What must hold for every law of the catalogue, whatever its numbers: a new law is tested by being there.

use stickslip::contact::{ContactLaw, Inputs, LAWS, Law, LawKind};
use stickslip::vocabulary::Scale;

use crate::common::contact::go;

const STIFFNESS: f64 = 7.9e6;
const FRICTION: f64 = 0.6;

/// The law with its own parameters at a part of their ranges.
fn at(kind: &'static LawKind, part: f64) -> Box<dyn ContactLaw> {
    let value = |range: fn(f64) -> (f64, f64, Scale)| match range(STIFFNESS) {
        (low, high, Scale::Linear) => low + part * (high - low),
        (low, high, Scale::Logarithmic) => low * (high / low).powf(part),
    };
    let own: Vec<f64> = kind.parameters.iter().map(|one| value(one.range)).collect();
    Law::new(kind, &own).unwrap().base(STIFFNESS, FRICTION).unwrap().into_law()
}

/// Every law at three places in its ranges, and a random history of displacement (m) and load (N), with separations.
fn for_every_law(mut test: impl FnMut(&'static LawKind, &dyn ContactLaw, &[(f64, f64)])) {
    for kind in LAWS {
        for (seed, part) in [0.2, 0.5, 0.9].into_iter().enumerate() {
            let mut random = fastrand::Rng::with_seed(seed as u64);
            let mut history = |_| {
                let load = if random.f64() < 0.15 { -50.0 } else { 20.0 + 300.0 * random.f64() };
                (60e-6 * (random.f64() - 0.5), load)
            };
            let history: Vec<(f64, f64)> = (0..400).map(&mut history).collect();
            test(kind, at(kind, part).as_ref(), &history);
        }
    }
}

fn rested(law: &dyn ContactLaw, load: f64) -> Vec<f64> {
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, load, 0.0, &mut state);
    state
}

#[test]
fn energy_is_only_lost_and_a_separated_contact_has_no_force() {
    for_every_law(|kind, law, history| {
        let mut state = rested(law, 100.0);
        for (displacement, load) in history {
            let response = go(law, &mut state, *displacement, *load);
            assert!(response.dissipated_energy >= 0.0, "{kind:?} {response:?}");
            assert!(*load > 0.0 || response.force == 0.0, "{kind:?} {response:?}");
        }
    });
}

#[test]
fn the_step_for_the_force_alone_is_the_step() {
    for_every_law(|kind, law, history| {
        let mut whole = rested(law, 100.0);
        let mut alone = whole.clone();
        // Three steps under each load: the first changes it, the last does not move.
        let steps = history.iter().flat_map(|(u, load)| [(*u, *load), (0.4 * u, *load), (0.4 * u, *load)]);
        for (displacement, load) in
            steps.chain([(1e-6, 5e-324), (2e-6, 5e-324), (3e-6, 1e300), (4e-6, 1e300)])
        {
            let inputs = Inputs { displacement, velocity: 0.0, normal_load: load };
            let expected = go(law, &mut whole, displacement, load).force;
            let force = law.advance(&mut alone, inputs);
            let limit = law.limit(load).max(1.0);
            assert!((force - expected).abs() < 1e-11 * limit, "{kind:?} {inputs:?}: {force} {expected}");
            for (alone, whole) in alone.iter().zip(&whole) {
                assert!((alone - whole).abs() < 1e-11 * whole.abs().max(1e-4), "{kind:?} {inputs:?}");
            }
        }
    });
}

#[test]
fn the_work_of_closed_loops_is_what_is_dissipated() {
    for_every_law(|kind, law, _| {
        let mut state = rested(law, 100.0);
        let (steps, amplitude) = (4000, 15e-6);
        let at = |k: usize| amplitude * (std::f64::consts::TAU * k as f64 / steps as f64).sin();
        let (mut work, mut lost) = (0.0, 0.0);
        for k in 1..=6 * steps {
            let before = go(law, &mut state.clone(), at(k - 1), 100.0).force;
            let response = go(law, &mut state, at(k), 100.0);
            if k > 5 * steps {
                work += 0.5 * (before + response.force) * (at(k) - at(k - 1));
                lost += response.dissipated_energy;
            }
        }
        assert!((work / lost - 1.0).abs() < 1e-3 && lost > 0.0, "{kind:?} {work:e} {lost:e}");
    });
}

#[test]
fn tangents_are_the_differences_of_the_force() {
    for_every_law(|kind, law, history| {
        let mut state = rested(law, 100.0);
        let mut next = state.clone();
        let mut compared = 0;
        for (displacement, load) in history {
            let mut force = |du: f64, dn: f64| {
                let inputs =
                    Inputs { displacement: displacement + du, velocity: 0.0, normal_load: load + dn };
                law.step(&state, inputs, &mut next)
            };
            let (here, du, dn) = (force(0.0, 0.0), 1e-11, 1e-4);
            let sides =
                |up: f64, down: f64, step: f64| [(up - here.force) / step, (here.force - down) / step];
            let by_displacement = sides(force(du, 0.0).force, force(-du, 0.0).force, du);
            let by_load = sides(force(0.0, dn).force, force(0.0, -dn).force, dn);
            let expected =
                [(by_displacement, here.tangents.displacement), (by_load, here.tangents.normal_load)];
            for ([above, below], tangent) in expected {
                // At a kink there is no derivative.
                let scale = above.abs().max(below.abs()).max(1e-2);
                if (above - below).abs() < 1e-3 * scale {
                    assert!((tangent - above).abs() < 2e-3 * scale, "{kind:?} {tangent} {above} {below}");
                    compared += 1;
                }
            }
            go(law, &mut state, *displacement, *load);
        }
        assert!(compared > 700, "{kind:?} {compared}");
    });
}

#[test]
fn a_copy_of_the_state_repeats_the_history_bit_by_bit() {
    for_every_law(|kind, law, history| {
        let mut state = rested(law, 100.0);
        let (first, rest) = history.split_at(100);
        for (displacement, load) in first {
            go(law, &mut state, *displacement, *load);
        }
        let mut copy = state.clone();
        let forces = |state: &mut Vec<f64>| -> Vec<u64> {
            rest.iter().map(|(u, load)| go(law, state, *u, *load).force.to_bits()).collect()
        };
        assert_eq!(forces(&mut state), forces(&mut copy), "{kind:?}");
    });
}
