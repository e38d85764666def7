//! Derivatives that slaves give: with respect to time and to inputs, against differences of repeated steps.

use stickslip::integrate::Ramp;
use stickslip::slave::{Causality, Error, Instance, Setup, VariableType};

const JENKINS: &str = include_str!("../modelDescription/JenkinsContact.toml");
const VALANIS: &str = include_str!("../modelDescription/ValanisContact.toml");
const MODAL: &str = include_str!("../modelDescription/ModalBeam.toml");
const FRICTIONAL: &str = include_str!("../modelDescription/FrictionalBeam.toml");
const OSCILLATOR: &str = include_str!("../examples/friction-vibration/model.toml");

/// A contact with every effect whose force is smooth between events.
const CHANGED: &str = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n\n[contact]\nlaw = \"jenkins\"\n\
    tangential_stiffness = 5e6\nfriction_coefficient = 0.5\nnormal_load = 150.0\n\n\
    [[effect]]\nid = \"micro_slip\"\nspread = 0.6\n\n[[effect]]\nid = \"contact_damping\"\ndamping = 400.0\n\n\
    [[effect]]\nid = \"normal_load_variation\"\nload_gain = 0.8\n";

/// Amplitude, angular frequency, phase and mean of each input.
type Waves<'a> = &'a [(&'a str, [f64; 4])];

/// A model, a step, a number of steps, the tolerance of the slave, and its inputs.
struct Case<'a> {
    name: &'a str,
    model: String,
    step: f64,
    steps: usize,
    tolerance: f64,
    /// Half the span of differences, relative to the amplitudes.
    span: f64,
    waves: Waves<'a>,
}

const OF_A_CONTACT: Waves = &[
    ("displacement", [4e-5, 300.0, 0.0, 0.0]),
    ("velocity", [4e-5 * 300.0, 300.0, 1.57, 0.0]),
    ("normal_load", [60.0, 170.0, 0.3, 140.0]),
];
const OF_A_BEAM: Waves =
    &[("excitation", [20.0, 330.0, 0.2, 0.0]), ("contact_force", [60.0, 200.0, 0.0, 10.0])];
const OF_A_FRICTIONAL_BEAM: Waves =
    &[("excitation", [30.0, 330.0, 0.2, 0.0]), ("normal_load", [40.0, 90.0, 0.0, 140.0])];
const OF_AN_OSCILLATOR: Waves = &[
    ("excitation:m1", [0.4, 0.54, 0.0, 0.0]),
    ("excitation:m2", [0.1, 1.3, 0.0, 0.0]),
    ("normal_load", [0.3, 0.2, 0.0, 1.0]),
];

fn cases() -> Vec<Case<'static>> {
    let case = |name, model: &str, (step, steps, tolerance), waves| Case {
        name,
        model: model.to_owned(),
        step,
        steps,
        tolerance,
        // Wider than the errors of a controlled step.
        span: if tolerance < 1e-9 { 1e-3 } else { 1e-5 },
        waves,
    };
    let gradual = |text: &str, stiffness: &str| {
        let law = format!("law = \"valanis\"\ntangential_stiffness = {stiffness}\nsmoothness = 0.4\n");
        text.replace("law = \"jenkins\"\n", &law).replace("tangential_stiffness = 0.2 ", "# ")
    };
    let stiff = FRICTIONAL
        .replace("law = \"valanis\"", "law = \"jenkins\"")
        .replace("smoothness = 0.3\n", "")
        .replace("residual_stiffness = 0.0 ", "# ");
    vec![
        case("Jenkins", JENKINS, (1e-3, 40, 1e-6), OF_A_CONTACT),
        case("Valanis", VALANIS, (1e-3, 40, 1e-6), OF_A_CONTACT),
        case("effects", CHANGED, (1e-3, 40, 1e-6), OF_A_CONTACT),
        case("ModalBeam", MODAL, (5e-4, 30, 1e-11), OF_A_BEAM),
        case("FrictionalBeam", FRICTIONAL, (5e-4, 30, 1e-11), OF_A_FRICTIONAL_BEAM),
        case("FrictionalBeam, Jenkins", &stiff, (5e-4, 30, 1e-11), OF_A_FRICTIONAL_BEAM),
        case("Oscillator", OSCILLATOR, (0.4, 60, 1e-6), OF_AN_OSCILLATOR),
        case("Oscillator, Valanis", &gradual(OSCILLATOR, "0.2"), (0.4, 60, 1e-6), OF_AN_OSCILLATOR),
    ]
}

/// An instance on its way.
struct Run<'a> {
    case: &'a Case<'a>,
    instance: Instance,
    inputs: Vec<u32>,
    outputs: Vec<u32>,
    /// So many inputs get their derivatives.
    sloped: usize,
}

impl<'a> Run<'a> {
    fn new(case: &'a Case<'a>) -> Self {
        let instance = Instance::new(&case.model).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        let description = instance.description();
        let inputs: Vec<u32> =
            case.waves.iter().map(|(name, _)| description.reference(name).expect(name)).collect();
        let real = |row: &u32| description.variables[*row as usize].variable_type == VariableType::Real;
        let outputs = description.references(Causality::Output).filter(real).collect();
        let sloped = inputs.len();
        let mut run = Self { case, instance, inputs, outputs, sloped };
        let setup = Setup { tolerance: Some(case.tolerance), start: 0.0, stop: None };
        run.instance.set_up(setup).unwrap();
        run.instance.enter_initialization().unwrap();
        run.set(&run.waves(0.0, 0));
        run.instance.exit_initialization().unwrap();
        run
    }

    /// Inputs at `time` (s), or their derivatives of `order`.
    fn waves(&self, time: f64, order: i32) -> Vec<f64> {
        let wave = |[amplitude, omega, phase, mean]: [f64; 4]| {
            let angle = omega * time + phase + f64::from(order) * std::f64::consts::FRAC_PI_2;
            amplitude * omega.powi(order) * angle.sin() + if order == 0 { mean } else { 0.0 }
        };
        self.case.waves.iter().map(|(_, numbers)| wave(*numbers)).collect()
    }

    fn set(&mut self, values: &[f64]) {
        self.instance.set_real(&self.inputs, values).unwrap();
    }

    fn slope(&mut self, slopes: &[f64]) {
        let inputs = &self.inputs[..self.sloped];
        self.instance.set_input_derivatives(inputs, &vec![1; self.sloped], &slopes[..self.sloped]).unwrap();
    }

    /// Leaves the normal load of a frictional beam held: under one that runs, the beam's own steps follow the path of
    /// displacement and load to a hundred-thousandth of the limit only, and differences show that.
    fn with_loads_held(mut self) -> Self {
        if self.case.name.starts_with("FrictionalBeam") {
            self.sloped = 1;
        }
        self
    }

    fn step(&mut self, k: usize) {
        self.instance.do_step(k as f64 * self.case.step, self.case.step).unwrap();
    }

    fn read(&mut self) -> Vec<f64> {
        let mut values = vec![0.0; self.outputs.len()];
        self.instance.get_real(&self.outputs, &mut values).unwrap();
        values
    }

    fn rates(&mut self) -> Vec<f64> {
        let mut rates = vec![0.0; self.outputs.len()];
        self.instance.output_derivatives(&self.outputs, &vec![1; self.outputs.len()], &mut rates).unwrap();
        rates
    }

    fn changes(&mut self, input: usize) -> Vec<f64> {
        let mut changes = vec![0.0; self.outputs.len()];
        let known = [self.inputs[input]];
        self.instance.directional_derivative(&self.outputs, &known, &[1.0], &mut changes).unwrap();
        changes
    }

    fn name(&self, output: usize) -> &str {
        &self.instance.description().variables[self.outputs[output] as usize].name
    }
}

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
    for case in &cases()[4..6] {
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
                let (known, ends) = ([run.inputs[input]], [Ramp { start: 0.0, end: 1.0 }]);
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
        let energy = (0..run.outputs.len()).find(|output| run.name(*output) == "dissipated_energy");
        for k in 0..case.steps {
            let before = run.instance.snapshot();
            let energy_before = energy.map(|output| run.read()[output]);
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
            if let (Some(row), Some(before)) = (energy, energy_before) {
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

/// Largest error of the contact's displacement over a time, inputs held or with their derivatives.
fn error_of_the_beam(steps: usize, sloped: bool, reference: &[f64]) -> f64 {
    let total = 0.02;
    let mut cases = cases();
    let case = &mut cases[3];
    assert_eq!(case.name, "ModalBeam");
    case.step = total / steps as f64;
    case.tolerance = 1e-12;
    let mut run = Run::new(case);
    let row = (0..run.outputs.len()).find(|row| run.name(*row) == "displacement:x=0.55").unwrap();
    let every = steps / (reference.len().max(20));
    let mut worst = 0.0_f64;
    for k in 0..steps {
        let time = k as f64 * case.step;
        run.set(&run.waves(time, 0));
        if sloped {
            run.slope(&run.waves(time, 1));
        }
        run.step(k);
        if (k + 1) % every == 0 && !reference.is_empty() {
            worst = worst.max((run.read()[row] - reference[(k + 1) / every - 1]).abs());
        }
    }
    worst
}

/// The same run in so small steps that it is exact in comparison.
fn reference_of_the_beam() -> Vec<f64> {
    let (steps, total) = (8_000, 0.02);
    let mut cases = cases();
    let case = &mut cases[3];
    case.step = total / steps as f64;
    case.tolerance = 1e-12;
    let mut run = Run::new(case);
    let row = (0..run.outputs.len()).find(|row| run.name(*row) == "displacement:x=0.55").unwrap();
    let mut reference = Vec::new();
    for k in 0..steps {
        let time = k as f64 * case.step;
        run.set(&run.waves(time, 0));
        run.slope(&run.waves(time, 1));
        run.step(k);
        if (k + 1) % 400 == 0 {
            reference.push(run.read()[row]);
        }
    }
    reference
}

#[test]
fn input_derivatives_raise_the_order_of_a_beam_from_one_to_two() {
    let reference = reference_of_the_beam();
    for (sloped, expected) in [(false, 1.0), (true, 2.0)] {
        let errors = [80, 160, 320].map(|steps| error_of_the_beam(steps, sloped, &reference));
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - expected).abs() < 0.15, "order {order} ({errors:?})");
        }
    }
}

#[test]
fn a_loop_driven_by_derivatives_alone_dissipates_the_closed_form() {
    let cases = cases();
    let mut run = Run::new(&cases[0]);
    run.instance.reset();
    run.instance.enter_initialization().unwrap();
    run.instance.exit_initialization().unwrap();
    let read = |run: &mut Run, name: &str| {
        let mut value = [0.0];
        let reference = run.instance.description().reference(name).unwrap();
        run.instance.get_real(&[reference], &mut value).unwrap();
        value[0]
    };
    let (amplitude, steps) = (60e-6, 16);
    let mut time = 0.0;
    let mut go = |run: &mut Run, distance: f64| {
        for _ in 0..steps {
            let rate = distance / (steps as f64 * 1e-3);
            run.instance.set_input_derivatives(&[run.inputs[0]], &[1], &[rate]).unwrap();
            run.instance.do_step(time, 1e-3).unwrap();
            time += 1e-3;
        }
        read(run, "dissipated_energy")
    };
    go(&mut run, amplitude);
    let before = go(&mut run, -2.0 * amplitude);
    go(&mut run, 2.0 * amplitude);
    let after = go(&mut run, -2.0 * amplitude);
    let limit = 0.6 * 147.15;
    let expected = 4.0 * limit * (amplitude - limit / 7.9e6);
    assert!((after - before - expected).abs() < 1e-10 * expected, "{} {expected}", after - before);
    assert!((read(&mut run, "displacement") + amplitude).abs() < 1e-15);
}

#[test]
fn a_contact_with_a_derivative_moves_at_once_to_the_value_and_runs_on_from_there() {
    let cases = cases();
    for case in &cases[..3] {
        let (mut one, mut two) = (Run::new(case), Run::new(case));
        // Back across the loop, and further on: the corner between counts.
        for (k, (at_once, end, load)) in
            [(3e-5, 4e-5, 150.0), (-2e-5, 3e-5, 120.0), (3.5e-5, 1e-5, 160.0)].into_iter().enumerate()
        {
            let slopes = [(end - at_once) / case.step, 0.0, (load - 140.0) / case.step];
            one.set(&[at_once, 1e-3, 140.0]);
            one.slope(&slopes);
            one.step(k);
            two.set(&[at_once, 1e-3, 140.0]);
            two.instance.do_step(2.0 * k as f64, 1.0).unwrap();
            let end = [at_once + slopes[0] * case.step, 1e-3, 140.0 + slopes[2] * case.step];
            two.set(&end);
            two.instance.do_step((2 * k + 1) as f64, 1.0).unwrap();
            assert_eq!(one.read(), two.read(), "{} {k}", case.name);
        }
    }
}

#[test]
fn a_derivative_holds_for_one_step_and_the_input_stays_where_it_led() {
    for case in cases() {
        let (mut one, mut two) = (Run::new(&case), Run::new(&case));
        let (values, slopes) = (one.waves(0.0, 0), one.waves(0.0, 1));
        for run in [&mut one, &mut two] {
            run.set(&values);
            run.slope(&slopes);
            run.step(0);
        }
        let mut reached = vec![0.0; values.len()];
        one.instance.get_real(&one.inputs, &mut reached).unwrap();
        for ((reached, value), slope) in reached.iter().zip(&values).zip(&slopes) {
            assert_eq!(*reached, value + slope * case.step, "{}", case.name);
        }
        two.set(&reached);
        two.slope(&vec![0.0; reached.len()]);
        one.step(1);
        two.step(1);
        assert_eq!(one.read(), two.read(), "{}", case.name);
        // In either order.
        for (run, first) in [(&mut one, true), (&mut two, false)] {
            if first {
                run.slope(&slopes);
            }
            run.set(&values);
            if !first {
                run.slope(&slopes);
            }
            run.step(2);
        }
        assert_eq!(one.read(), two.read(), "{}", case.name);
    }
}

#[test]
fn saved_states_keep_pending_derivatives_and_those_of_the_last_step() {
    for case in cases() {
        let mut run = Run::new(&case);
        for k in 0..10 {
            let time = k as f64 * case.step;
            run.set(&run.waves(time, 0));
            run.slope(&run.waves(time, 1));
            run.step(k);
        }
        run.slope(&run.waves(10.0 * case.step, 1));
        let saved = run.instance.snapshot();
        let bytes = saved.to_bytes();
        let all = |run: &mut Run| {
            let mut all = run.rates();
            (0..run.inputs.len()).for_each(|input| all.extend(run.changes(input)));
            run.step(10);
            all.extend(run.read());
            all.extend(run.rates());
            (0..run.inputs.len()).for_each(|input| all.extend(run.changes(input)));
            all.into_iter().map(f64::to_bits).collect::<Vec<_>>()
        };
        let expected = all(&mut run);
        run.step(11);
        run.instance.restore(&saved).unwrap();
        assert_eq!(all(&mut run), expected, "{}", case.name);
        let mut other = Run::new(&case);
        other.instance.restore(&stickslip::slave::Snapshot::from_bytes(&bytes).unwrap()).unwrap();
        assert_eq!(all(&mut other), expected, "{}", case.name);
        // Asking for derivatives leaves no trace.
        run.instance.restore(&saved).unwrap();
        run.rates();
        run.changes(0);
        assert_eq!(run.instance.snapshot(), saved, "{}", case.name);
    }
}

#[test]
fn refused_derivatives_name_the_variable_and_change_nothing() {
    let cases = cases();
    let mut run = Run::new(&cases[0]);
    run.step(0);
    let before = run.instance.snapshot();
    let rows = &run.instance.description().variables;
    let row = |name: &str| rows.iter().position(|variable| variable.name == name).unwrap() as u32;
    let [displacement, force, slip, stiffness] =
        ["displacement", "force", "slip_state", "tangential_stiffness"].map(row);
    let instance = &mut run.instance;
    for (reference, order, value, word) in [
        (displacement, 0, 1.0, "displacement"),
        (displacement, 2, 1.0, "order 2"),
        (displacement, -1, 1.0, "order -1"),
        (displacement, 1, f64::NAN, "displacement"),
        (displacement, 1, f64::INFINITY, "displacement"),
        (displacement, 1, 1e31, "displacement"),
        (force, 1, 1.0, "force"),
        (slip, 1, 1.0, "slip_state"),
        (stiffness, 1, 1.0, "tangential_stiffness"),
        (99, 1, 1.0, "99"),
    ] {
        let error = instance.set_input_derivatives(&[displacement, reference], &[1, order], &[0.1, value]);
        let message = error.expect_err(word).to_string();
        assert!(message.contains(word), "{message}");
        assert_eq!(instance.snapshot(), before, "{word}");
    }
    let mut out = [0.0];
    for (reference, order, word) in [
        (force, 0, "force"),
        (force, 2, "order 2"),
        (displacement, 1, "displacement"),
        (slip, 1, "slip_state"),
    ] {
        let message =
            instance.output_derivatives(&[reference], &[order], &mut out).expect_err(word).to_string();
        assert!(message.contains(word), "{message}");
    }
    for (unknown, known, value, word) in [
        (displacement, displacement, 1.0, "displacement"),
        (force, force, 1.0, "force"),
        (force, stiffness, 1.0, "tangential_stiffness"),
        (slip, displacement, 1.0, "slip_state"),
        (force, displacement, f64::NAN, "displacement"),
        (force, 99, 1.0, "99"),
    ] {
        let found = instance.directional_derivative(&[unknown], &[known], &[value], &mut out);
        let message = found.expect_err(word).to_string();
        assert!(message.contains(word), "{message}");
    }
    assert!(matches!(
        instance.set_input_derivatives(&[displacement], &[1, 1], &[0.1]),
        Err(Error::Lengths { .. })
    ));
    assert_eq!(instance.snapshot(), before);
    // The end of the step counts too.
    instance.set_input_derivatives(&[displacement], &[1], &[9e29]).unwrap();
    let pending = instance.snapshot();
    let message = instance.do_step(1e-3, 2.0).expect_err("beyond").to_string();
    assert!(message.contains("displacement"), "{message}");
    assert_eq!(instance.snapshot(), pending);
    // Before there is anything to differentiate.
    instance.reset();
    assert!(matches!(instance.output_derivatives(&[force], &[1], &mut out), Err(Error::Stage(_))));
    let early = instance.directional_derivative(&[force], &[displacement], &[1.0], &mut out);
    assert!(matches!(early, Err(Error::Stage(_))));
}
