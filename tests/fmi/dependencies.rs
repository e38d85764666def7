//! What outputs are declared to depend on is what they depend on at a communication point: what a derivative by an
//! input keeps as the step becomes short.

use std::collections::BTreeSet;

use stickslip::fmi::{Causality, DependencyKind, Variability, VariableType};

use crate::common::fmi::{Case, OF_A_PIN_RIG, PIN_RIG, Run, cases};

/// Steps, as parts of the communication step, that are short beside every motion.
const SHORT: [f64; 2] = [1e-6, 1e-7];

/// Inputs under which the contact of a beam slips, which it hardly does under those of the other tests.
const SLIPPING: [(&str, [f64; 4]); 3] = [
    ("excitation", [120.0, 330.0, 0.2, 0.0]),
    ("normal_load", [40.0, 300.0, 0.0, 60.0]),
    ("contact_force:x=0.2", [8.0, 260.0, 0.9, -3.0]),
];

const OF_A_PINNED_BEAM: [(&str, [f64; 4]); 3] = [
    ("excitation", [6.0, 900.0, 0.3, 0.0]),
    ("contact_force", [10.0, 800.0, 0.7, 0.0]),
    ("opening_force", [8.0, 1100.0, 0.1, 0.0]),
];

type Pairs = BTreeSet<(String, String)>;

/// Every model whose table is made in a way of its own.
fn all() -> Vec<Case<'static>> {
    let mut all = cases();
    for case in all.iter_mut().filter(|case| case.name.starts_with("FrictionalBeam")) {
        case.waves = if case.waves.len() == 2 { &SLIPPING[..2] } else { &SLIPPING };
    }
    all.push(Case {
        name: "SlipSlapBeam",
        model: PIN_RIG.to_owned(),
        step: 1e-4,
        steps: 40,
        tolerance: 1e-6,
        span: 1e-5,
        waves: OF_A_PIN_RIG,
    });
    all.push(Case {
        name: "PinnedBeam",
        model: include_str!("../../modelDescription/PinnedBeam.toml").to_owned(),
        step: 1e-5,
        steps: 40,
        tolerance: 1e-6,
        span: 1e-5,
        waves: &OF_A_PINNED_BEAM,
    });
    all
}

/// The pairs of output and input in the table, without continuous states.
fn declared(run: &Run) -> Pairs {
    let variables = &run.instance.description().variables;
    let rows = variables.iter().filter(|row| row.causality == Causality::Output);
    let pair = |row: &stickslip::fmi::Variable, on: u32| {
        (row.name.to_string(), variables[on as usize].name.to_string())
    };
    let of_inputs = |on: u32| variables[on as usize].causality == Causality::Input;
    rows.flat_map(|row| {
        let all = row.dependencies.iter().map(|dependency| dependency.on).filter(|on| of_inputs(*on));
        all.map(|on| pair(row, on)).collect::<Vec<_>>()
    })
    .collect()
}

/// Derivatives of the continuous outputs by every input, of a step of `part` of the communication step from here, in which
/// the inputs jump by `jump` times their amplitudes.
fn of_a_step(run: &mut Run, k: usize, part: f64, jump: f64) -> Vec<Vec<f64>> {
    let before = run.instance.snapshot();
    let (time, step) = (k as f64 * run.case.step, part * run.case.step);
    let mut values = run.waves(time + step, 0);
    for (input, value) in values.iter_mut().enumerate() {
        *value = (*value + jump * run.case.waves[input].1[0]).max(run.lowest(input));
    }
    run.set(&values);
    run.instance.do_step(time, step).unwrap();
    let found = (0..run.inputs.len()).map(|input| run.changes(input)).collect();
    run.instance.restore(&before).unwrap();
    found
}

/// The discrete outputs after a short step in which an input has jumped by `jump` times its amplitude.
fn states(run: &mut Run, k: usize, jump: Option<(usize, f64)>) -> Vec<f64> {
    let discrete = discrete(run);
    let before = run.instance.snapshot();
    let (time, step) = (k as f64 * run.case.step, SHORT[0] * run.case.step);
    let mut values = run.waves(time + step, 0);
    if let Some((input, by)) = jump {
        values[input] = (values[input] + by * run.case.waves[input].1[0]).max(run.lowest(input));
    }
    run.set(&values);
    run.instance.do_step(time, step).unwrap();
    let read = |row: &u32| {
        let integer =
            run.instance.description().variables[*row as usize].variable_type == VariableType::Integer;
        let (mut whole, mut real) = ([0], [0.0]);
        if integer {
            run.instance.get_integer(&[*row], &mut whole)
        } else {
            run.instance.get_real(&[*row], &mut real)
        }
        .unwrap();
        f64::from(whole[0]) + real[0]
    };
    let found = discrete.iter().map(read).collect();
    run.instance.restore(&before).unwrap();
    found
}

fn discrete(run: &Run) -> Vec<u32> {
    let description = run.instance.description();
    let of = |row: &u32| description.variables[*row as usize].variability() == Variability::Discrete;
    description.references(Causality::Output).filter(of).collect()
}

/// The pairs of output and input that are seen to be one on a run.
fn seen(run: &mut Run) -> Pairs {
    let mut pairs = Pairs::new();
    for k in 0..run.case.steps {
        for jump in [0.0, -0.5, 0.5] {
            let whole = of_a_step(run, k, 1.0, jump);
            let [short, shorter] = SHORT.map(|part| of_a_step(run, k, part, jump));
            for (input, wave) in run.case.waves.iter().enumerate() {
                for output in 0..run.outputs.len() {
                    let kept = shorter[input][output].abs();
                    if kept > 1e-9 * whole[input][output].abs() && kept > 0.5 * short[input][output].abs() {
                        pairs.insert((run.name(output).to_owned(), wave.0.to_owned()));
                    }
                }
            }
        }
        let still = states(run, k, None);
        for (input, wave) in run.case.waves.iter().enumerate() {
            for jump in [-3.0, 3.0] {
                let moved = states(run, k, Some((input, jump)));
                for (row, (moved, still)) in discrete(run).into_iter().zip(moved.iter().zip(&still)) {
                    // A slip fraction is a smooth function of a force that the motion of the short step changes.
                    if (moved - still).abs() > 1e-4 {
                        let output = &run.instance.description().variables[row as usize].name;
                        pairs.insert((output.to_string(), wave.0.to_owned()));
                    }
                }
            }
        }
        run.set(&run.waves((k + 1) as f64 * run.case.step, 0));
        run.step(k);
    }
    pairs
}

/// The pairs of a continuous output and an input by which its derivative is not zero somewhere on a run.
fn differentiable(run: &mut Run) -> Pairs {
    let mut pairs = Pairs::new();
    for k in 0..run.case.steps {
        let found = of_a_step(run, k, 1.0, 0.0);
        for (input, wave) in run.case.waves.iter().enumerate() {
            let moved = (0..run.outputs.len()).filter(|output| found[input][*output] != 0.0);
            pairs.extend(moved.map(|output| (run.name(output).to_owned(), wave.0.to_owned())));
        }
        run.set(&run.waves((k + 1) as f64 * run.case.step, 0));
        run.step(k);
    }
    pairs
}

/// Structures whose inputs run to their values within a step: there all outputs are declared that a step of any length
/// moves, since a master that couples them strongly has to repeat the step for these.
fn moves_within_the_step(case: &Case) -> bool {
    case.name.starts_with("Oscillator") || ["PinnedBeam", "SlipSlapBeam"].contains(&case.name)
}

#[test]
fn declared_dependencies_are_what_a_short_step_keeps_of_the_derivatives() {
    let mut wrong = Vec::new();
    for case in all() {
        let declared = declared(&Run::new(&case));
        let seen = seen(&mut Run::new(&case));
        let mut tell = |pairs: Vec<&(String, String)>, what: &str| {
            wrong.extend(
                pairs.iter().map(|(output, input)| format!("{}: {output} by {input} {what}", case.name)),
            );
        };
        tell(seen.difference(&declared).collect(), "is not declared");
        let run = Run::new(&case);
        let all = if moves_within_the_step(&case) { differentiable(&mut Run::new(&case)) } else { seen };
        // That a discrete output has not changed on a run says little.
        let continuous =
            |pair: &&(String, String)| (0..run.outputs.len()).any(|output| run.name(output) == pair.0);
        tell(declared.difference(&all).filter(continuous).collect(), "is declared and never seen");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_dependency_declared_as_fixed_has_the_same_derivative_at_every_point() {
    for case in all() {
        let mut run = Run::new(&case);
        let mut first: Option<Vec<Vec<f64>>> = None;
        for k in 0..case.steps {
            let found = of_a_step(&mut run, k, SHORT[0], 0.0);
            let first = first.get_or_insert_with(|| found.clone());
            for (output, reference) in run.outputs.iter().enumerate() {
                let row = &run.instance.description().variables[*reference as usize];
                let fixed = row.dependencies.iter().filter(|on| on.kind == DependencyKind::Fixed);
                for input in fixed.filter_map(|on| run.inputs.iter().position(|input| *input == on.on)) {
                    let (then, now) = (first[input][output], found[input][output]);
                    let name = case.waves[input].0;
                    assert!(
                        (now - then).abs() <= 1e-6 * then.abs(),
                        "{}: {} by {name}: {then}, then {now}",
                        case.name,
                        row.name
                    );
                }
            }
            run.set(&run.waves((k + 1) as f64 * case.step, 0));
            run.step(k);
        }
    }
}

#[test]
fn initial_outputs_depend_on_nothing_that_is_not_declared() {
    for case in all() {
        let variables = Run::new(&case).instance.description().variables.clone();
        let known = |row: &stickslip::fmi::Variable| row.causality != Causality::Output;
        let start = |change: Option<(u32, f64)>| {
            let mut run = Run::at_initialization(&case);
            if let Some((row, value)) = change {
                run.instance.set_real(&[row], &[value]).ok()?;
            }
            let mut values = vec![0.0; run.outputs.len()];
            run.instance.get_real(&run.outputs, &mut values).ok()?;
            Some((run.outputs, values))
        };
        let (outputs, usual) = start(None).unwrap();
        for (number, row) in variables.iter().enumerate().filter(|(_, row)| known(row)) {
            let value = if row.causality == Causality::Input {
                let wave = case.waves.iter().find(|wave| wave.0 == row.name).unwrap().1;
                wave[3] + wave[0] * wave[2].sin() + 0.1 * wave[0]
            } else {
                row.start * 1.01 + f64::from(row.start == 0.0) * 1e-3 * row.quantity.nominal
            };
            let Some((_, other)) = start(Some((number as u32, value))) else { continue };
            for ((output, usual), other) in outputs.iter().zip(&usual).zip(&other) {
                let of = &variables[*output as usize];
                let declared = of.initial_dependencies.iter().any(|on| on.on as usize == number);
                assert!(
                    declared || usual == other,
                    "{}: the initial {} depends on {}",
                    case.name,
                    of.name,
                    row.name
                );
            }
        }
    }
}
