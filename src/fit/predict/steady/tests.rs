//! Predictions of beams and their derivatives.

use super::balance::{At, SteadyRecord};
use crate::data::{Channel, Record, Regime};
use crate::fit::predict::observed::ObservedSimulation;
use crate::fit::predict::observed_system::{observed_assembly, observed_system};
use crate::fit::predict::regimes;
use crate::fit::predict::simulation::{Direction, Seed, Simulation};
use crate::model::Model;
use crate::system::Core;

const SAMPLES: usize = 96;
const PERIODS: usize = 2;

pub(in crate::fit::predict) fn model(effects: &str) -> Model {
    let text = format!(
        r#"
        schema = "stickslip.model/1"
        kind = "beam"
        support = {{ offset = 0.006 }}
        excitation = {{ position = 0.55 }}
        contact = {{ law = "jenkins", tangential_stiffness = 7e6, friction_coefficient = 0.4, normal_load = 150.0 }}
        {effects}
        [beam]
        length = 0.6
        width = 0.04
        thickness = 0.005
        density = 7850.0
        youngs_modulus = 1.94e11
        modes = 3
        damping_ratio = 0.004
        point_mass = [{{ position = 0.55, mass = 0.025 }}]
        "#
    );
    Model::parse(&text).expect("a legal model")
}

fn channel(name: &str, values: Vec<f64>) -> Channel {
    Channel { name: name.to_owned(), unit: "1", values, noise: None }
}

/// A steady record under a cosine of `amplitude` (N) at `frequency` (Hz).
fn record(amplitude: f64, frequency: f64) -> Record {
    let count = SAMPLES * PERIODS;
    let time: Vec<f64> = (0..count).map(|k| k as f64 / (SAMPLES as f64 * frequency)).collect();
    let force = time.iter().map(|t| amplitude * (std::f64::consts::TAU * frequency * t).cos()).collect();
    Record {
        name: "steady".to_owned(),
        regime: Regime::Steady,
        use_for: None,
        channels: vec![
            channel("time", time),
            channel("excitation", force),
            channel("acceleration:x=0.55", vec![0.0; count]),
            channel("acceleration:x=0.1", vec![0.0; count]),
        ],
    }
}

fn simulation<'r>(model: &Model, record: &'r Record) -> Box<dyn Simulation + 'r> {
    regimes::simulation(model, record, None).expect("a steady response")
}

/// `record` with the channels measuring what `model` predicts.
fn showing(model: &Model, nuisances: &[f64], mut record: Record) -> Record {
    let mut motion = Vec::new();
    simulation(model, &record).predict(model, nuisances, &mut motion).expect("a steady response");
    for (channel, values) in record.channels[2..].iter_mut().zip(motion.chunks_exact(SAMPLES * PERIODS)) {
        channel.values.copy_from_slice(values);
    }
    record
}

fn moved(model: &Model, path: &str, share: f64) -> Model {
    let mut moved = model.clone();
    let value = model.get(path).unwrap_or_else(|| panic!("{path}"));
    moved.set(path, value * (1.0 + share)).expect("a legal value");
    moved
}

/// Largest difference of the derivatives along `paths` from central differences of converged solves, as a fraction.
fn derivative_error(model: &Model, record: &Record, paths: &[&str]) -> f64 {
    let mut simulation = simulation(model, record);
    let step = 1e-6;
    let directions: Vec<Direction> = paths
        .iter()
        .map(|path| Direction { model: moved(model, path, step), nuisances: Vec::new(), step })
        .collect();
    let (mut predictions, mut derivatives) = (Vec::new(), Vec::new());
    simulation.linearise(model, &[], &directions, &mut predictions, &mut derivatives).expect("a solution");
    let wide = 1e-4;
    let mut worst = 0.0_f64;
    for (path, derivative) in paths.iter().zip(&derivatives) {
        let mut at = |share: f64| {
            let mut out = Vec::new();
            simulation.predict(&moved(model, path, share), &[], &mut out).expect("a solution");
            out
        };
        let (ahead, behind) = (at(wide), at(-wide));
        let (mut error, mut size) = (0.0, 0.0);
        for ((ahead, behind), derivative) in ahead.iter().zip(&behind).zip(derivative) {
            let central = (ahead - behind) / (2.0 * wide);
            error += (central - derivative).powi(2);
            size += central * central;
        }
        println!("{path}: {:.1e} of {:.3e}", (error / size).sqrt(), size.sqrt());
        assert!(size > 0.0, "{path}");
        worst = worst.max((error / size).sqrt());
    }
    worst
}

const BASE: [&str; 4] = [
    "contact.tangential_stiffness",
    "contact.friction_coefficient",
    "beam.youngs_modulus",
    "beam.damping_ratio",
];

#[test]
fn derivatives_are_those_of_converged_solves() {
    let error = derivative_error(&model(""), &record(12.0, 51.0), &BASE);
    assert!(error < 5e-3, "{error:e}");
}

#[test]
fn derivatives_by_effects_are_those_of_converged_solves() {
    for (effect, paths) in [
        (r#"{ id = "added_mass", at = "x=0.3", mass = 0.01 }"#, &["effect.1.mass"][..]),
        (r#"{ id = "support_compliance", clamp_stiffness = 2e3 }"#, &["effect.1.clamp_stiffness"]),
        (
            r#"{ id = "hanging_mass", mass = 5.0, hanging_frequency = 40.0 }"#,
            &["effect.1.mass", "effect.1.hanging_frequency"],
        ),
        (r#"{ id = "geometric_stiffening", cubic_stiffness = 2e9 }"#, &["effect.1.cubic_stiffness"]),
        (r#"{ id = "quadratic_damping", quadratic_damping = 3.0 }"#, &["effect.1.quadratic_damping"]),
        (r#"{ id = "residual_stiffness", residual_stiffness = 5e5 }"#, &["effect.1.residual_stiffness"]),
    ] {
        let model = model(&format!("effect = [{effect}]"));
        let paths: Vec<&str> = paths.iter().copied().chain([BASE[2]]).collect();
        let error = derivative_error(&model, &record(12.0, 51.0), &paths);
        assert!(error < 5e-3, "{effect}: {error:e}");
    }
}

#[test]
fn the_same_sequence_gives_the_same_bits_and_predictions_do_not_disturb_each_other() {
    let (model, record) = (model(""), record(12.0, 51.0));
    let run = |between: bool| {
        let mut simulation = simulation(&model, &record);
        let (mut out, mut derivatives) = (Vec::new(), Vec::new());
        simulation.linearise(&model, &[], &[], &mut out, &mut derivatives).unwrap();
        if between {
            simulation.predict(&moved(&model, BASE[1], 0.1), &[], &mut out).unwrap();
        }
        simulation.predict(&moved(&model, BASE[0], 0.02), &[], &mut out).unwrap();
        out
    };
    assert_eq!(run(false), run(false));
    assert_eq!(run(false), run(true));
}

/// What a simulation keeps of a prediction for the derivatives there, and the room it goes on working in, change
/// nothing, also where a neighbour needs unknowns that the model itself does not have.
#[test]
fn derivatives_after_predictions_are_those_without() {
    for (effect, path) in [
        ("", BASE[1]),
        (r#"effect = [{ id = "geometric_stiffening", cubic_stiffness = 2e9 }]"#, "effect.1.cubic_stiffness"),
        (r#"effect = [{ id = "quadratic_damping", quadratic_damping = 0.0 }]"#, "effect.1.quadratic_damping"),
    ] {
        let model = model(effect);
        let measured = showing(&model, &[], record(12.0, 51.0));
        let there = moved(&model, BASE[0], 0.01);
        let mut neighbour = there.clone();
        neighbour.set(path, 1e-3 + 1.001 * there.get(path).unwrap()).unwrap();
        let directions = [Direction { model: neighbour, nuisances: vec![0.0], step: 1e-3 }];
        for seed in [None, Some(&Seed::LinearisedAtMeasurement)] {
            let linearised = |before: &[f64]| {
                let mut simulation = regimes::simulation(&model, &measured, seed).unwrap();
                let (mut out, mut derivatives) = (Vec::new(), Vec::new());
                for share in before {
                    simulation.predict(&moved(&model, BASE[0], *share), &[0.0], &mut out).unwrap();
                }
                simulation.linearise(&there, &[0.0], &directions, &mut out, &mut derivatives).unwrap();
                [out, derivatives.remove(0)]
            };
            let alone = linearised(&[]);
            for before in [&[0.01][..], &[0.01, 0.03], &[0.03, 0.01]] {
                for (alone, after) in alone.iter().zip(&linearised(before)) {
                    let size = alone.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                    let apart = alone.iter().zip(after).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                    assert!(apart <= 1e-6 * size, "{effect} {before:?}: {apart:e} of {size:e}");
                }
            }
        }
    }
}

#[test]
fn a_warm_start_changes_the_path_and_not_the_answer() {
    let (model, record) = (model(""), record(12.0, 51.0));
    let near = moved(&model, BASE[1], 0.03);
    let (mut warm, mut cold) = (Vec::new(), Vec::new());
    simulation(&model, &record).predict(&near, &[], &mut warm).unwrap();
    simulation(&near, &record).predict(&near, &[], &mut cold).unwrap();
    let size = cold.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    for (warm, cold) in warm.iter().zip(&cold) {
        assert!((warm - cold).abs() < 1e-5 * size, "{warm} {cold} of {size}");
    }
}

/// Harmonics beyond those of a fit bring predictions nearer to what very many show, and are gone again when they are not
/// asked for.
#[test]
fn refined_predictions_are_nearer_to_those_of_very_many_harmonics() {
    for effect in [
        "",
        r#"effect = [{ id = "backlash", half_gap = 3e-6 }]"#,
        r#"effect = [{ id = "asymmetry", asymmetry = 0.2 }]"#,
        r#"effect = [{ id = "geometric_stiffening", cubic_stiffness = 2e9 }]"#,
    ] {
        let (model, record) = (model(effect), record(12.0, 51.0));
        let channels: Vec<&Channel> = record.channels[2..].iter().collect();
        let mut simulation = simulation(&model, &record);
        let system = observed_system(&model, &[0.55, 0.1]).unwrap();
        let Core::Modal { angular_frequency, .. } = &system.core else { panic!("a beam has modes") };
        let highest = angular_frequency.iter().copied().fold(0.0, f64::max);
        let mut many = SteadyRecord::new(&record, &channels, highest, 8).unwrap();
        many.start_from_fewer(simulation.solution().unwrap());
        let assembly = observed_assembly(system, &model, None, 0.0);
        let mut reference = Vec::new();
        many.predict(&At { model: &model, nuisances: &[0.0], assembly: &assembly }, &mut reference).unwrap();
        let mut shown = |finer: usize| {
            let mut out = Vec::new();
            simulation.refine(finer);
            simulation.predict(&model, &[0.0], &mut out).unwrap();
            out
        };
        let [coarse, fine, again] = [1, 8, 1].map(&mut shown);
        let apart = |a: &[f64]| a.iter().zip(&reference).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        assert!(3.0 * apart(&fine) < apart(&coarse), "{effect}: {:e} {:e}", apart(&fine), apart(&coarse));
        assert_eq!(coarse, again);
    }
}

/// About a motion that the model itself makes the first-order prediction is that motion, and of another model what it
/// has become, to a small part of the change. (Accelerations do not show the mean displacement, which the tangents
/// depend on a little.)
#[test]
fn about_the_measured_motion_predictions_are_right_to_first_order() {
    let model = model("");
    let measured = showing(&model, &[], record(12.0, 51.0));
    let mut motion = Vec::new();
    simulation(&model, &measured).predict(&model, &[], &mut motion).unwrap();
    let mut about = regimes::simulation(&model, &measured, Some(&Seed::LinearisedAtMeasurement)).unwrap();
    let size = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart = |a: &[f64], b: &[f64]| size(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>());
    // The error of the prediction, and what there is to be predicted.
    let mut at = |share: f64| {
        let other = moved(&model, BASE[1], share);
        let (mut solved, mut predicted) = (Vec::new(), Vec::new());
        simulation(&model, &measured).predict(&other, &[], &mut solved).unwrap();
        about.predict(&other, &[], &mut predicted).unwrap();
        [apart(&predicted, &solved) / size(&motion), apart(&motion, &solved) / size(&motion)]
    };
    let [[none, _], [small, change], [large, twice]] = [0.0, 0.01, 0.02].map(&mut at);
    println!("{none:.1e} {small:.1e} of {change:.1e} {large:.1e}");
    assert!(none < 1e-3 && small < 0.1 * change && large < 0.1 * twice);
}

/// A contact that sticks all through a steady state keeps the force it was left with, which the sensors show; one that
/// slips keeps nothing.
#[test]
fn where_a_sticking_contact_was_left_is_found_and_a_slipping_one_forgets_it() {
    const OFFSET: f64 = 4e-6; // m; the contact slips 8.6e-6 m from it
    let model = model("");
    let predicted = |record: &Record, offset: f64| {
        let mut out = Vec::new();
        simulation(&model, record).predict(&model, &[offset], &mut out).unwrap();
        out
    };
    let change = |record: &Record| {
        let (none, some) = (predicted(record, 0.0), predicted(record, OFFSET));
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
        square(&mut none.iter().zip(&some).map(|(a, b)| a - b)) / square(&mut none.iter().copied())
    };
    let slipping = record(12.0, 51.0);
    assert!(change(&slipping) < 1e-6, "{:e}", change(&slipping));
    let sticking = record(0.3, 40.0);
    assert!(change(&sticking) > 1e-3, "{:e}", change(&sticking));
    let sticking = showing(&model, &[OFFSET], sticking);
    let found = ObservedSimulation::new(&model, &sticking).unwrap().settle(&model).unwrap();
    assert!((found[0] - OFFSET).abs() < 1e-3 * OFFSET, "{found:?}");
}

/// A contact that slips until it sticks remembers a narrow range of offsets alone, and beyond it no derivative leads back:
/// wherever it was left, that is found.
#[test]
fn wherever_a_contact_was_left_the_response_is_found() {
    let size = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart = |a: &[f64], b: &[f64]| size(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>());
    let (mut narrow, mut wide) = (0, 0);
    for asymmetry in [-0.3, 0.02, 0.3] {
        let model = model(&format!(r#"effect = [{{ id = "asymmetry", asymmetry = {asymmetry} }}]"#));
        for force in [1.0, 4.0, 8.0, 8.5, 9.0] {
            let shown = |offset: f64| showing(&model, &[offset], record(force, 45.0));
            let samples = |record: &Record| -> Vec<f64> {
                record.channels[2..].iter().flat_map(|channel| channel.values.clone()).collect()
            };
            let plateaus = [-1.7e-5, 1.7e-5].map(|offset| samples(&shown(offset)));
            let change = apart(&plateaus[0], &plateaus[1]);
            for offset in [-1.4e-5, -6e-6, -2e-6, -5e-7, 5e-7, 2e-6, 6e-6, 1.4e-5] {
                let record = shown(offset);
                let measured = samples(&record);
                let mut found = Vec::new();
                let mut simulation = ObservedSimulation::new(&model, &record).unwrap();
                let nuisances = simulation.settle(&model).unwrap();
                simulation.predict(&model, &nuisances, &mut found).unwrap();
                let missed = apart(&found, &measured);
                assert!(missed < 1e-2 * change, "{asymmetry} {force} N {offset}: {missed:e} of {change:e}");
                let between = plateaus.iter().all(|plateau| apart(plateau, &measured) > 1e-3 * change);
                narrow += usize::from(between && change < 0.01 * size(&measured));
                wide += usize::from(between);
            }
        }
    }
    assert!(narrow > 4 && wide > 20, "{narrow} {wide}");
}

/// What stands where it was linearised last serves for other directions there, and nowhere else.
#[test]
fn derivatives_asked_for_again_are_those_of_a_new_simulation() {
    let (here, record) = (model(""), record(12.0, 51.0));
    let there = moved(&here, "contact.friction_coefficient", 0.02);
    let along = |from: &Model, path: &str, offset: f64| Direction {
        model: moved(from, path, 1e-6),
        nuisances: vec![offset],
        step: 1e-6,
    };
    let derivatives = |simulation: &mut dyn Simulation, model: &Model, offset: f64, path: &str| {
        let (mut at, mut by) = (Vec::new(), Vec::new());
        let direction = along(model, path, offset);
        simulation.linearise(model, &[offset], &[direction], &mut at, &mut by).expect("a solution");
        (at, by.swap_remove(0))
    };
    let size = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart =
        |a: &[f64], b: &[f64]| size(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>()) / size(b);
    let mut warm = simulation(&here, &record);
    for (model, offset) in [(&here, 0.0), (&there, 0.0), (&there, 1e-7)] {
        for path in ["beam.youngs_modulus", "contact.tangential_stiffness"] {
            let (at, by) = derivatives(warm.as_mut(), model, offset, path);
            let (new_at, new_by) = derivatives(simulation(model, &record).as_mut(), model, offset, path);
            let errors = [apart(&at, &new_at), apart(&by, &new_by)];
            assert!(errors[0] < 1e-6 && errors[1] < 1e-5, "{path} {offset}: {errors:?}");
        }
    }
}

/// A beam that stretches has two steady states above its resonance; the one that was measured is predicted.
#[test]
fn of_several_responses_the_measured_one_is_predicted() {
    let mut model = model("effect = [{ id = \"geometric_stiffening\", cubic_stiffness = 3e10 }]");
    // A contact that slips would take the motion that bends the resonance.
    model.set("contact.friction_coefficient", 40.0).unwrap();
    let silent = |step: i32| record(10.0, 50.0 + 0.25 * f64::from(step));
    let predicted = |record: &Record, seed: Option<&Seed>| {
        let mut simulation = regimes::simulation(&model, record, seed).expect("a record");
        let mut out = Vec::new();
        simulation.predict(&model, &[], &mut out).ok()?;
        Some((out, Seed::Near(simulation.solution()?.clone())))
    };
    // Along one branch from frequency to frequency, as far as it goes.
    let follow = |steps: Vec<i32>| {
        let (mut branch, mut seed) = (Vec::new(), None);
        for step in steps {
            let Some((found, next)) = predicted(&silent(step), seed.as_ref()) else { break };
            branch.push((step, found));
            seed = Some(next);
        }
        branch
    };
    let apart = |a: &[f64], b: &[f64]| {
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
        square(&mut a.iter().zip(b).map(|(a, b)| a - b)) / square(&mut b.iter().copied())
    };
    let (up, down) = (follow((0..120).collect()), follow((0..120).rev().collect()));
    let two = up.iter().find_map(|(step, large)| {
        let (_, small) = down.iter().find(|(other, _)| other == step)?;
        (apart(small, large) > 0.5).then_some((*step, [large, small]))
    });
    let (step, branches) = two.expect("a frequency with two responses");
    for branch in branches {
        let mut measured = silent(step);
        for (channel, values) in measured.channels[2..].iter_mut().zip(branch.chunks_exact(SAMPLES * PERIODS))
        {
            channel.values.copy_from_slice(values);
        }
        let (near, _) = predicted(&measured, None).expect("a response");
        assert!(apart(&near, branch) < 1e-4, "{step}: {}", apart(&near, branch));
    }
}

/// Up to the fold where a beam that stretches jumps from its large motion, that motion is predicted where it was measured,
/// with its noise, and not the small one that there is as well.
#[test]
fn beside_a_fold_the_measured_response_is_predicted() {
    let mut model = model("effect = [{ id = \"geometric_stiffening\", cubic_stiffness = 3e10 }]");
    model.set("contact.friction_coefficient", 40.0).unwrap();
    let predicted = |record: &Record, seed: Option<&Seed>| {
        let mut simulation = regimes::simulation(&model, record, seed).expect("a record");
        let mut out = Vec::new();
        simulation.predict(&model, &[0.0], &mut out).ok()?;
        Some((out, Seed::Near(simulation.solution()?.clone())))
    };
    let size = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart =
        |a: &[f64], b: &[f64]| size(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>()) / size(b);
    // Up the branch in ever smaller steps, back from those that lead off it.
    let (mut frequency, mut step) = (50.0, 0.25);
    let (mut motion, mut seed) = predicted(&record(10.0, frequency), None).expect("a response");
    while step > 1e-3 {
        match predicted(&record(10.0, frequency + step), Some(&seed)) {
            Some((next, at)) if apart(&next, &motion) < 0.3 => {
                (motion, seed) = (next, at);
                frequency += step;
            }
            _ => step *= 0.5,
        }
    }
    let mut measured = record(10.0, frequency);
    let mut uniform = uniform(1);
    for (channel, values) in measured.channels[2..].iter_mut().zip(motion.chunks_exact(SAMPLES * PERIODS)) {
        let deviation = size(values) / (values.len() as f64).sqrt();
        channel.values = values.iter().map(|x| x + 0.03 * deviation * 12_f64.sqrt() * uniform()).collect();
    }
    let (found, _) = predicted(&measured, None).expect("the measured response");
    assert!(apart(&found, &motion) < 1e-3, "{frequency} Hz: {}", apart(&found, &motion));
}

/// Even numbers between −½ and ½.
fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut numbers = fastrand::Rng::with_seed(seed);
    move || numbers.f64() - 0.5
}
