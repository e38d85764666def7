//! How the errors of every output of every FMU fall with the step, under inputs that a master holds or lets run.

use crate::common::fmi::{Case, Run, cases};

/// How a master gives the inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Given {
    /// The values at the beginning of a step, which a beam holds. (A contact or an oscillator runs to the values it is
    /// given: those at the end.)
    Held,
    /// With their first derivatives.
    Sloped,
    /// With their first three.
    Curved,
}

/// Instants at which signals are compared.
const POINTS: usize = 40;

/// All Real outputs at [`POINTS`] instants, with so many steps between two.
fn signals(case: &mut Case, span: f64, steps: usize, given: Given) -> Vec<Vec<f64>> {
    case.step = span / (POINTS * steps) as f64;
    let mut run = Run::new(case);
    let runs = !run.case.name.contains("eam") && run.case.name != "two contacts";
    let mut rows = Vec::new();
    for k in 0..POINTS * steps {
        let time = (k + usize::from(runs && given == Given::Held)) as f64 * run.case.step;
        run.set(&run.waves(time, 0));
        for order in 1..=match given {
            Given::Held => 0,
            Given::Sloped => 1,
            Given::Curved => 3,
        } {
            let (count, slopes) = (run.inputs.len(), run.waves(time, order));
            run.instance.set_input_derivatives(&run.inputs, &vec![order; count], &slopes).unwrap();
        }
        run.step(k);
        if (k + 1) % steps == 0 {
            rows.push(run.read());
        }
    }
    rows
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// The least order of an output, by far enough from the next.
fn least_order(case: &Case, output: &str, given: Given) -> f64 {
    let beam = case.model.contains("kind = \"beam\"");
    match given {
        Given::Held if beam => 0.9,
        // The force from outside bends the beam's end at once, by its rate: that of the line it was given.
        Given::Sloped if beam && output == "velocity" && !case.model.contains("[contact]") => 0.9,
        Given::Curved if beam && output.starts_with("displacement") => 2.75,
        // At each step the contact is taken to the value it begins at, there and back.
        Given::Sloped if case.name == "Valanis" => 0.9,
        Given::Sloped if case.name == "slip and slap, Valanis" || output == "impact_energy" => 0.9,
        Given::Sloped if case.name == "effects" => 1.3,
        // Where a corner falls in a step changes with the step.
        Given::Held if !beam => 1.3,
        Given::Curved if case.name.starts_with("slip and slap") => 1.3,
        _ => 1.75,
    }
}

#[test]
fn every_output_of_every_fmu_converges() {
    for mut case in cases() {
        case.tolerance = 1e-12;
        let span = case.step * case.steps as f64;
        let names: Vec<String> = {
            let run = Run::new(&case);
            (0..run.outputs.len()).map(|row| run.name(row).to_owned()).collect()
        };
        let contact = case.model.contains("kind = \"contact\"");
        let exact = signals(&mut case, span, 512, if contact { Given::Held } else { Given::Curved });
        for given in [Given::Held, Given::Sloped, Given::Curved] {
            let found = [8, 32].map(|steps| signals(&mut case, span, steps, given));
            for (row, name) in names.iter().enumerate() {
                let error = |found: &[Vec<f64>]| rms(found.iter().zip(&exact).map(|(a, b)| a[row] - b[row]));
                let scale = rms(exact.iter().map(|exact| exact[row]));
                let [coarse, fine] = [&found[0], &found[1]].map(|found| error(found));
                let order = 0.5 * (coarse / fine).log2();
                assert!(
                    coarse <= 3e-6 * scale || order > least_order(&case, name, given),
                    "{}, {given:?}: {name} is of order {order:.2}, off by {:.1e} and {:.1e}",
                    case.name,
                    coarse / scale,
                    fine / scale
                );
            }
        }
    }
}

#[test]
fn the_velocity_at_a_contact_becomes_the_rate_of_its_displacement_also_under_a_held_force() {
    let cases = cases();
    let force = |time: f64| 20.0 * (std::f64::consts::TAU * 200.0 * time).sin();
    let mut last = f64::INFINITY;
    for step in [1e-4, 1e-5, 1e-6] {
        let case = Case { step, model: cases[3].model.clone(), ..cases[3] };
        let mut run = Run::new(&case);
        run.instance.reset();
        run.instance.enter_initialization().unwrap();
        run.instance.exit_initialization().unwrap();
        let row = |name: &str| run.instance.description().reference(name).unwrap();
        let (input, outputs) = (row("contact_force"), [row("displacement"), row("velocity")]);
        let mut rows = Vec::new();
        for k in 0..(0.01 / step).round() as usize {
            run.instance.set_real(&[input], &[force(k as f64 * step)]).unwrap();
            run.step(k);
            let mut values = [0.0; 2];
            run.instance.get_real(&outputs, &mut values).unwrap();
            rows.push(values);
        }
        let rate = |three: &[[f64; 2]]| (three[2][0] - three[0][0]) / (2.0 * step);
        let off = rms(rows.windows(3).map(|three| three[1][1] - rate(three)));
        let relative = off / rms(rows.iter().map(|values| values[1]));
        assert!(relative < 0.15 * last, "{relative:e} at {step:e} s after {last:e}");
        last = relative;
    }
    assert!(last < 2e-3, "{last:e}");
}
