//! Inputs that run over a step: what derivatives of inputs do.

use stickslip::fmi::Error;

use crate::common::fmi::{Run, cases};

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
        other.instance.restore(&stickslip::fmi::Snapshot::from_bytes(&bytes).unwrap()).unwrap();
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
        (displacement, 4, 1.0, "order 4"),
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
