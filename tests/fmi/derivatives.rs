//! Derivatives that slaves give: with respect to time and to inputs, against differences of repeated steps.

use stickslip::fmi::Instance;
use stickslip::time::Ramp;

use crate::common::fmi::{Run, cases};

/// Compares derivatives with differences ahead and behind, relative to the largest of each output by each input. On a
/// corner those two differ, and either or anything between is right; corners of some size must be rare.
#[derive(Default)]
struct Comparison {
    entries: Vec<(usize, usize, f64, f64, f64)>,
}

impl Comparison {
    fn add(&mut self, input: usize, found: &[f64], ahead: &[f64], behind: &[f64]) {
        for (output, found) in found.iter().enumerate() {
            self.entries.push((input, output, *found, ahead[output], behind[output]));
        }
    }

    fn check(&self, run: &Run, tolerance: f64) {
        let (mut corners, mut worst) = (0, (0.0, String::new()));
        for (input, output, found, ahead, behind) in &self.entries {
            let same = self.entries.iter().filter(|entry| entry.0 == *input && entry.1 == *output);
            let scale = same.fold(0.0_f64, |most, entry| most.max(entry.3.abs()).max(entry.4.abs()));
            if (ahead - behind).abs() > 1e-2 * scale {
                corners += 1;
                continue;
            }
            let (input, output) =
                (run.case.waves.get(*input).map_or("time", |wave| wave.0), run.name(*output));
            let (low, high) = (ahead.min(*behind), ahead.max(*behind));
            let error = (low - found).max(found - high).max(0.0) / scale.max(f64::MIN_POSITIVE);
            if error > worst.0 {
                let text = format!("{output} by {input}: {found:e}, not {low:e} ... {high:e} ({scale:e})");
                worst = (error, text);
            }
        }
        let name = run.case.name;
        assert!(worst.0 <= tolerance, "{name}: {}, off by {:e}", worst.1, worst.0);
        assert!(corners * 10 <= self.entries.len(), "{name}: {corners} corners");
    }
}

/// Differences of the outputs when input `input` of step `k` changes by a small part of its amplitude.
fn differences(run: &mut Run, k: usize, input: usize, sloped: bool) -> [Vec<f64>; 2] {
    let before = run.instance.snapshot();
    let span = run.case.span * run.case.waves[input].1[0];
    let mut outputs = Vec::new();
    for by in [0.0, span, -span] {
        let mut values = run.waves(if sloped { k as f64 } else { (k + 1) as f64 } * run.case.step, 0);
        values[input] += by;
        run.instance.restore(&before).unwrap();
        run.set(&values);
        if sloped {
            run.slope(&run.waves(k as f64 * run.case.step, 1));
        }
        run.step(k);
        outputs.push(run.read());
    }
    run.instance.restore(&before).unwrap();
    let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) / span).collect();
    [difference(&outputs[1], &outputs[0]), difference(&outputs[0], &outputs[2])]
}

fn check_directional_derivatives(mut run: Run, sloped: bool, tolerance: f64) {
    let case = run.case;
    let mut comparison = Comparison::default();
    for k in 0..case.steps {
        let differences = |input| differences(&mut run, k, input, sloped);
        let all: Vec<_> = (0..case.waves.len()).map(differences).collect();
        let time = if sloped { k as f64 } else { (k + 1) as f64 } * case.step;
        run.set(&run.waves(time, 0));
        if sloped {
            run.slope(&run.waves(time, 1));
        }
        run.step(k);
        for (input, [ahead, behind]) in all.iter().enumerate() {
            let found = run.changes(input);
            comparison.add(input, &found, ahead, behind);
        }
    }
    comparison.check(&run, tolerance);
}

#[test]
fn directional_derivatives_are_those_of_the_step() {
    for case in cases() {
        check_directional_derivatives(Run::new(&case), false, 2e-4);
    }
}

#[test]
fn directional_derivatives_of_a_step_with_input_derivatives_too() {
    for case in cases() {
        check_directional_derivatives(Run::new(&case).with_loads_held(), true, 2e-4);
    }
}

#[test]
fn directional_derivatives_under_a_load_that_runs_as_far_as_the_beam_follows_it() {
    for case in cases().iter().filter(|case| case.name.starts_with("FrictionalBeam")) {
        check_directional_derivatives(Run::new(case), true, 0.1);
    }
}

#[test]
fn line_derivatives_are_those_of_a_step_to_other_ends() {
    for case in cases() {
        let mut run = Run::new(&case).with_loads_held();
        let mut comparison = Comparison::default();
        for k in 0..case.steps {
            let before = run.instance.snapshot();
            let time = k as f64 * case.step;
            let (values, slopes) = (run.waves(time, 0), run.waves(time, 1));
            for input in 0..run.sloped {
                let span = case.span * case.waves[input].1[0];
                let mut outputs = Vec::new();
                for by in [span, -span, 0.0] {
                    let mut slopes = slopes.clone();
                    slopes[input] += by / case.step;
                    run.instance.restore(&before).unwrap();
                    run.set(&values);
                    run.slope(&slopes);
                    run.step(k);
                    outputs.push(run.read());
                }
                let mut found = vec![0.0; run.outputs.len()];
                let (known, ends) = ([run.inputs[input]], [Ramp::line(0.0, 1.0)]);
                run.instance.line_derivative(&run.outputs, &known, &ends, &mut found).unwrap();
                let difference = |a: &[f64], b: &[f64]| -> Vec<f64> {
                    a.iter().zip(b).map(|(a, b)| (a - b) / span).collect()
                };
                let (ahead, behind) =
                    (difference(&outputs[0], &outputs[2]), difference(&outputs[2], &outputs[1]));
                comparison.add(input, &found, &ahead, &behind);
            }
        }
        comparison.check(&run, 2e-4);
    }
}

#[test]
fn output_derivatives_are_slopes_at_the_end_of_the_step() {
    for case in cases() {
        let mut run = Run::new(&case);
        let mut comparison = Comparison::default();
        let energies = ["dissipated_energy", "impact_energy"];
        let energies: Vec<usize> =
            (0..run.outputs.len()).filter(|output| energies.contains(&run.name(*output))).collect();
        for k in 0..case.steps {
            let before = run.instance.snapshot();
            let energies_before = run.read();
            let time = k as f64 * case.step;
            let (values, slopes) = (run.waves(time, 0), run.waves(time, 1));
            let less = case.step / 500.0;
            let mut outputs = Vec::new();
            for missing in [2.0 * less, less, 0.0] {
                run.instance.restore(&before).unwrap();
                run.set(&values);
                run.slope(&slopes);
                run.instance.do_step(time, case.step - missing).unwrap();
                outputs.push(run.read());
            }
            let mut found = run.rates();
            for (row, before) in energies.iter().map(|row| (*row, energies_before[*row])) {
                // A mean over the step; a contact moves at once to where the step begins, which is no part of it.
                let mean = (outputs[2][row] - before) / case.step;
                if !case.model.contains("kind = \"contact\"") {
                    assert!((found[row] - mean).abs() <= 1e-9 * mean.abs() + 1e-15, "{}", case.name);
                }
                assert!(found[row] >= 0.0 && found[row] <= mean * (1.0 + 1e-9) + 1e-15, "{}", case.name);
                found[row] = 0.0;
                outputs.iter_mut().for_each(|outputs| outputs[row] = 0.0);
            }
            let slope = |later: usize, row: usize| (outputs[later][row] - outputs[later - 1][row]) / less;
            let rows = 0..found.len();
            let at_end = |row: usize| 1.5 * slope(2, row) - 0.5 * slope(1, row);
            let bend = |row: usize| 0.5 * (slope(2, row) - slope(1, row));
            let ahead: Vec<f64> = rows.clone().map(|row| at_end(row) + bend(row)).collect();
            let behind: Vec<f64> = rows.map(|row| at_end(row) - bend(row)).collect();
            comparison.add(usize::MAX, &found, &ahead, &behind);
        }
        // The oscillator's steps are of fixed length, their error not much below that.
        comparison.check(&run, if case.name.starts_with("Oscillator") { 5e-3 } else { 1e-3 });
    }
}

#[test]
fn derivatives_at_the_start_are_those_of_the_initial_outputs() {
    for case in cases() {
        for input in 0..case.waves.len() {
            let mut run = Run::new(&case);
            run.instance.reset();
            run.instance.enter_initialization().unwrap();
            let span = 1e-6 * case.waves[input].1[0];
            let mut at = |by: f64| {
                let mut values = run.waves(0.11, 0);
                values[input] += by;
                run.set(&values);
                run.read()
            };
            let (ahead, behind) = (at(span), at(-span));
            at(0.0);
            let found = run.changes(input);
            run.instance.exit_initialization().unwrap();
            assert_eq!(run.changes(input), found, "{}", case.name);
            for (output, found) in found.iter().enumerate() {
                let expected = (ahead[output] - behind[output]) / (2.0 * span);
                let rounding = 1e-15 * ahead[output].abs() / span;
                assert!(
                    (found - expected).abs() <= 1e-5 * expected.abs() + rounding,
                    "{}: {} by {}: {found:e}, not {expected:e}",
                    case.name,
                    run.name(output),
                    case.waves[input].0
                );
            }
            assert!(run.rates().iter().all(|rate| rate.is_finite()));
        }
    }
}

/// What a new instance has not written yet must not be needed: a state may be restored into one, in another process too.
#[test]
fn an_instance_into_which_a_state_was_restored_gives_the_derivatives_of_the_one_that_was_saved() {
    for case in &cases() {
        let (mut run, mut other) = (Run::new(case), Run::at_initialization(case));
        let inputs = run.waves(case.step, 0);
        run.set(&inputs);
        run.step(0);
        other.instance = Instance::new(&case.model).unwrap();
        other.instance.restore(&run.instance.snapshot()).unwrap();
        for input in 0..case.waves.len() {
            assert_eq!(other.changes(input), run.changes(input), "{} by {}", case.name, case.waves[input].0);
        }
        assert_eq!(other.rates(), run.rates(), "{}", case.name);
    }
}
