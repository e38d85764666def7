//! Runs: rejected steps, slaves that cannot go back, failures, interruptions, threads.

use std::ops::ControlFlow;

use stickslip::cosim::{
    Abilities, Adaptive, Algorithm, Control, Master, Method, Parallel, Settings, Source, System,
};

use crate::common::cosim::*;
use crate::common::linear_slave::*;
use crate::watched::Watched;

fn adaptive(control: Control, tolerance: f64) -> Adaptive {
    Adaptive { tolerance, smallest: 1e-6, largest: 0.2, control }
}

#[test]
fn a_smaller_tolerance_takes_more_steps_and_gives_less_error() {
    let exact = TWO_MASSES.exact(2.0);
    for algorithm in
        [Algorithm::GaussSeidel { extrapolation: 1, order: None }, strong(Method::Anderson { depth: 3 })]
    {
        for control in [Control::Error, Control::Energy, Control::Both] {
            let run = |tolerance| {
                let settings = Settings {
                    adaptive: Some(adaptive(control, tolerance)),
                    ..Settings::new(algorithm.clone(), 0.2, 2.0)
                };
                let (rows, report) = record(joined(TWO_MASSES.slaves()), settings).unwrap();
                let (time, end) = rows.last().unwrap();
                assert_eq!(*time, 2.0);
                assert_eq!(rows.len() as u64, report.steps + 1);
                ((end[0] - exact[0]).abs() + (end[2] - exact[2]).abs(), report)
            };
            let ((coarse, few), (fine, many)) = (run(3e-2), run(3e-4));
            assert!(many.steps > few.steps && fine < 0.2 * coarse, "{control:?} {coarse:e} {fine:e}");
            assert!(many.rejected > 0, "the first step is too long: {control:?}");
        }
    }
}

#[test]
fn what_nothing_is_connected_to_does_not_shorten_the_step() {
    let run = |jump: bool| {
        let mut system = joined(TWO_MASSES.slaves());
        if jump {
            let jump = Source::new("jump", "value", "1", |time| f64::from(u8::from(time > 0.7)));
            system.add(Box::new(jump)).unwrap();
        }
        let settings = Settings {
            adaptive: Some(adaptive(Control::Error, 3e-4)),
            ..Settings::new(strong(Method::Anderson { depth: 3 }), 0.2, 2.0)
        };
        record(system, settings).unwrap().1
    };
    let (with, without) = (run(true), run(false));
    assert_eq!((with.steps, with.forced), (without.steps, 0));
    assert!(with.rejected > 0 && with.limits == without.limits, "{:?}", with.limits);
    assert_eq!(with.limits.iter().map(|(_, steps)| steps).sum::<u64>(), with.rejected);
}

#[test]
fn a_step_that_a_slave_gives_up_is_repeated_shorter() {
    let system = || {
        let mut slaves = TWO_MASSES.slaves();
        // It follows the other's motion in ten parts of a step.
        slaves[1].longest = 0.003;
        joined(slaves)
    };
    let settings = Settings {
        adaptive: Some(adaptive(Control::Discards, 1.0)),
        ..Settings::new(strong(Method::Anderson { depth: 3 }), 0.1, 1.0)
    };
    let (rows, report) = record(system(), settings.clone()).unwrap();
    assert!(report.rejected > 0 && rows.windows(2).all(|pair| pair[1].0 - pair[0].0 < 0.0301));
    let exact = TWO_MASSES.exact(1.0);
    assert!((rows.last().unwrap().1[0] - exact[0]).abs() < 1e-2);
    let failure = record(system(), Settings { adaptive: None, ..settings }).unwrap_err();
    let message = failure.to_string();
    assert!(message.starts_with("at 0 s: second gave up on the step at 0.005 s"), "{message}");
}

#[test]
fn a_slave_that_cannot_go_back_is_coupled_explicitly_and_the_report_says_so() {
    let unable = Abilities { saves_state: false, ..EVERYTHING };
    let exact = TWO_MASSES.exact(2.0);
    let run = |step, unable_one: bool| {
        let [first, second] = TWO_MASSES.slaves();
        let slaves = if unable_one { [first.with(unable), second] } else { [first, second] };
        let (rows, report) =
            record(joined(slaves), Settings::new(strong(Method::Anderson { depth: 3 }), step, 2.0)).unwrap();
        ((rows.last().unwrap().1[0] - exact[0]).abs(), report)
    };
    let (error, report) = run(0.01, true);
    assert!(error < 1e-2 && run(0.005, true).0 < error);
    assert!(report.notes.iter().any(|note| note.starts_with("first cannot save its state")), "{report:?}");
    assert!(run(0.01, false).1.notes.is_empty());
}

#[test]
fn what_was_reached_before_a_failure_is_kept() {
    let mut slaves = TWO_MASSES.slaves();
    slaves[0].fails_at = 0.55;
    let mut rows = Vec::new();
    let master = Master::new(joined(slaves), Settings::new(JACOBI, 0.1, 1.0)).unwrap();
    let failure = master
        .run(|point| {
            rows.push(point.time);
            ControlFlow::Continue(())
        })
        .unwrap_err();
    assert_eq!((rows.len(), failure.report.steps), (6, 5));
    assert_eq!(failure.to_string(), "at 0.5 s: first: velocity is beyond all bounds");
}

fn watched(fails_at: f64, algorithm: Algorithm) -> (Vec<&'static str>, Vec<&'static str>) {
    let mut system = System::new();
    let logs = [(); 2].map(|()| std::sync::Arc::default());
    let mut slaves = TWO_MASSES.slaves();
    slaves[0].fails_at = fails_at;
    for (slave, calls) in slaves.into_iter().zip(&logs) {
        system.add(Box::new(Watched { slave, calls: std::sync::Arc::clone(calls) })).unwrap();
    }
    system.connect(("first", "displacement"), ("second", "displacement"), 1.0, 0.0).unwrap();
    system.connect(("second", "force"), ("first", "force"), 1.0, 0.0).unwrap();
    let _ = record(system, Settings::new(algorithm, 0.1, 0.2));
    let [first, second] = logs.map(|calls| calls.lock().unwrap().clone());
    (first, second)
}

#[test]
fn calls_come_in_the_order_that_the_standard_asks_for() {
    let (first, _) = watched(f64::INFINITY, GAUSS_SEIDEL);
    let begin = first.iter().position(|call| *call == "exit").unwrap();
    assert_eq!(first[..2], ["set up", "enter"]);
    // No value is read between setting one and the step.
    assert_eq!(first[begin..], ["exit", "get", "set", "step", "get", "set", "step", "get", "terminate"]);
    let (first, second) = watched(0.15, JACOBI);
    assert_eq!((first.last(), second.last()), (Some(&"step"), Some(&"terminate")));
}

#[test]
fn an_observer_that_breaks_off_ends_the_run() {
    let master = Master::new(joined(TWO_MASSES.slaves()), Settings::new(GAUSS_SEIDEL, 0.1, 1.0)).unwrap();
    assert_eq!(master.observed()[2].variable, "position");
    let mut last = f64::NAN;
    let report = master.run(|point| {
        last = point.time;
        if point.time > 0.25 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let report = report.unwrap();
    assert!(report.interrupted && report.steps == 3 && (last - 0.3).abs() < 1e-12);
}

#[test]
fn the_last_step_is_as_long_as_what_is_left() {
    let exact = TWO_MASSES.exact(1.0);
    let settings = Settings::new(strong(Method::Newton), 0.03, 1.0);
    let (rows, _) = record(joined(TWO_MASSES.slaves()), settings.clone()).unwrap();
    assert_eq!((rows.len(), rows.last().unwrap().0), (35, 1.0));
    assert!((rows[34].1[0] - exact[0]).abs() < 1e-3);
    let settings_of_one = Settings::new(strong(Method::Newton), 1e7, 1.0);
    let (rows, _) = record(joined(TWO_MASSES.slaves()), settings_of_one).unwrap();
    assert_eq!((rows.len(), rows.last().unwrap().0), (2, 1.0), "a step longer than the run is cut to it");
    let fixed = Abilities { variable_step: false, ..EVERYTHING };
    let (rows, report) =
        record(joined(TWO_MASSES.slaves().map(|slave| slave.with(fixed))), settings).unwrap();
    assert!(
        (rows.last().unwrap().0 - 0.99).abs() < 1e-12
            && report.notes.iter().any(|note| note.contains("whole step"))
    );
}

/// Contacts on one beam's end, all the same.
fn several(count: usize, reversed: bool) -> System {
    let shaker = Shaker { amplitude: 20.0, omega: 330.0, growth: 0.02 };
    let mut slaves = vec![
        (Box::new(Source::new("shaker", "force", "N", move |time| shaker.force(time)))
            as Box<dyn stickslip::cosim::Slave>),
        native("beam", BEAM),
    ];
    slaves.extend(
        (0..count)
            .map(|index| native(&format!("contact{index}"), if index % 2 == 0 { VALANIS } else { JENKINS })),
    );
    if reversed {
        slaves.reverse();
    }
    let mut system = System::new();
    for slave in slaves {
        system.add(slave).unwrap();
    }
    system.connect(("shaker", "force"), ("beam", "excitation"), 1.0, 0.0).unwrap();
    for index in 0..count {
        system
            .connect(("beam", "displacement"), (&format!("contact{index}"), "displacement"), 1.0, 0.0)
            .unwrap();
    }
    system.connect(("contact0", "force"), ("beam", "contact_force"), 1.0, 0.0).unwrap();
    for index in 0..count {
        system.observe(&format!("contact{index}"), "force").unwrap();
    }
    system.observe("beam", "displacement").unwrap();
    system
}

fn bits(system: System, settings: Settings) -> Vec<u64> {
    let (rows, _) = record(system, settings).unwrap();
    rows.iter().flat_map(|(_, values)| values.iter().map(|value| value.to_bits())).collect()
}

#[test]
fn stepped_at_the_same_time_the_numbers_are_the_same() {
    for algorithm in [JACOBI, GAUSS_SEIDEL, strong(Method::Anderson { depth: 5 }), strong(Method::Newton)] {
        let run = |parallel| {
            bits(several(9, false), Settings { parallel, ..Settings::new(algorithm.clone(), 1e-4, 0.02) })
        };
        let serial = run(Parallel::Never);
        assert!(serial == run(Parallel::Always), "{algorithm:?}");
        assert!(serial == run(Parallel::Auto), "{algorithm:?}");
    }
}

#[test]
fn the_order_in_which_slaves_are_added_does_not_matter() {
    for algorithm in [JACOBI, GAUSS_SEIDEL, strong(Method::Anderson { depth: 5 })] {
        let run = |reversed| bits(several(5, reversed), Settings::new(algorithm.clone(), 1e-4, 0.02));
        assert!(run(false) == run(true), "{algorithm:?}");
    }
}

#[test]
fn factors_and_offsets_are_units_resolved() {
    // Displacement in mm and a force of the other sign between: the same motion.
    let settings = Settings::new(strong(Method::Newton), 0.01, 1.0);
    let (plain, report) = record(joined(TWO_MASSES.slaves()), settings.clone()).unwrap();
    let [m1, k1, c1] = [TWO_MASSES.mass[0], TWO_MASSES.stiffness[0], TWO_MASSES.damping[0]];
    let millimetres = Linear::new(
        "first",
        &[("force", "N")],
        &[("displacement", "m"), ("velocity", "m/s")],
        [&[0.0, 1.0, -k1 / m1, -c1 / m1], &[0.0, 1.0 / m1], &[1e3, 0.0, 0.0, 1e3], &[0.0; 2]],
        &TWO_MASSES.start[..2],
    );
    let mut system = System::new();
    system.add(millimetres.boxed()).unwrap();
    let [_, second] = TWO_MASSES.slaves();
    system.add(second.boxed()).unwrap();
    system.connect(("first", "displacement"), ("second", "displacement"), 1e-3, 0.0).unwrap();
    system.connect(("first", "velocity"), ("second", "velocity"), 1e-3, 0.0).unwrap();
    system.connect(("second", "force"), ("first", "force"), -1.0, 0.0).unwrap();
    system.observe("second", "position").unwrap();
    let (scaled, other) = record(system, settings).unwrap();
    for ((_, a), (_, b)) in plain.iter().zip(&scaled) {
        assert!((a[2] - b[0]).abs() < 1e-9, "{a:?} {b:?}");
    }
    // N mm for J, of the other sign.
    let (joule, other) = (report.energy[0].sum, other.energy[0].sum);
    assert!((joule + 1e-3 * other).abs() < 1e-6 * joule.abs(), "{joule:e} {other:e}");
}
