//! Runs that would be wrong end with an error that names what is wrong.

use std::ops::ControlFlow;

use stickslip::cosim::{Algorithm, Cause, Failure, Master, Settings, Source, Strong, System};

use crate::common::cosim::*;
use crate::common::linear_slave::Linear;

/// What was recorded before the run ended, and why it ended.
fn ended(system: System, settings: Settings) -> (Rows, Failure) {
    let mut rows = Rows::new();
    let failure = Master::new(system, settings).unwrap().run(|point| {
        rows.push((point.time, point.values.to_vec()));
        ControlFlow::Continue(())
    });
    (rows, failure.expect_err("the run should not come to its end"))
}

/// A source that is no number from 2.5 ms on.
fn broken() -> Source {
    Source::new("broken", "force", "N", |time| if time > 2.5e-3 { f64::NAN } else { 1.0 })
}

#[test]
fn a_value_that_is_no_number_ends_the_run_with_its_name_and_the_results_so_far() {
    for connected in [true, false] {
        for algorithm in [JACOBI, GAUSS_SEIDEL, Algorithm::Strong(Strong::default())] {
            let mut system = System::new();
            system.add(native("beam", BEAM)).unwrap();
            system.add(Box::new(broken())).unwrap();
            if connected {
                system.connect(("broken", "force"), ("beam", "excitation"), 1.0, 0.0).unwrap();
            }
            let (rows, failure) = ended(system, Settings::new(algorithm, 1e-3, 0.01));
            let message = failure.to_string();
            assert!(message.contains("broken") && message.contains("`force`"), "{message}");
            assert!(matches!(failure.error.cause, Cause::Slave(_)), "{message}");
            assert_eq!((rows.len(), failure.report.steps), (3, 2), "{message}");
            assert!(rows.iter().all(|(_, values)| values.iter().all(|value| value.is_finite())));
        }
    }
}

#[test]
fn an_infinite_value_ends_the_run_only_where_it_feeds_another_slave() {
    let timer = || Source::new("timer", "until", "N", |time| if time > 2.5e-3 { f64::INFINITY } else { 1.0 });
    for connected in [true, false] {
        let mut system = System::new();
        system.add(native("beam", BEAM)).unwrap();
        system.add(Box::new(timer())).unwrap();
        if connected {
            system.connect(("timer", "until"), ("beam", "excitation"), 1.0, 0.0).unwrap();
            let (rows, failure) = ended(system, Settings::new(JACOBI, 1e-3, 0.01));
            assert!(failure.to_string().contains("`until`") && rows.len() == 3, "{failure}");
        } else {
            assert_eq!(record(system, Settings::new(JACOBI, 1e-3, 0.01)).unwrap().0.len(), 11);
        }
    }
}

#[test]
fn a_coupling_that_explodes_ends_the_run_with_its_name_and_one_that_does_not_goes_on() {
    for contact in [VALANIS, JENKINS] {
        for amplitude in [0.1, 6.0] {
            let shaker = Shaker { amplitude, omega: 324.0, growth: 0.02 };
            let run = |algorithm: Algorithm, step: f64| {
                let mut rows = 0;
                let master =
                    Master::new(beam_with(contact, shaker), Settings::new(algorithm, step, 0.2)).unwrap();
                let ended = master.run(|_| {
                    rows += 1;
                    ControlFlow::Continue(())
                });
                (ended, rows)
            };
            let extrapolated = Algorithm::Jacobi { extrapolation: 1 };
            for step in [1e-3, 5e-4] {
                let (ended, rows) = run(extrapolated.clone(), step);
                let failure = ended.expect_err("it explodes");
                let message = failure.to_string();
                assert!(matches!(failure.error.cause, Cause::Unstable { .. }), "{message}");
                for word in ["beam.contact_force", "contact.displacement", "shorter step", "%"] {
                    assert!(message.contains(word), "{word}: {message}");
                }
                // The step that showed it is the last one.
                let energy = &failure.report.energy[0];
                assert!(energy.sum > 0.5 * energy.exchanged && failure.report.steps == rows, "{message}");
            }
            assert!(run(extrapolated.clone(), 1e-4).0.is_ok());
            for step in [5e-4, 2e-4] {
                assert!(run(JACOBI, step).0.is_ok() && run(GAUSS_SEIDEL, step).0.is_ok(), "{step}");
                assert!(run(Algorithm::Strong(Strong::default()), step).0.is_ok(), "{step}");
            }
        }
    }
}

#[test]
fn truths_are_mapped_to_truths_and_nothing_else_is() {
    let system = || {
        let mut system = System::new();
        let one = Linear::new("one", &[], &[("y", "1")], [&[0.0], &[], &[1.0], &[]], &[1.0]);
        let other = Linear::new("other", &[("u", "1")], &[("y", "1")], [&[], &[], &[], &[1.0]], &[]);
        system.add(one.of_truths().boxed()).unwrap();
        system.add(other.of_truths().boxed()).unwrap();
        system
    };
    for (factor, offset, expected) in [(1.0, 0.0, 1.0), (-1.0, 1.0, 0.0), (0.0, 1.0, 1.0), (0.0, 0.0, 0.0)] {
        let mut system = system();
        system.connect(("one", "y"), ("other", "u"), factor, offset).unwrap();
        let (rows, _) = record(system, Settings::new(JACOBI, 0.1, 0.2)).unwrap();
        assert_eq!(rows[2].1, [1.0, expected], "{factor} {offset}");
    }
    assert!(system().connect(("one", "y"), ("other", "u"), 2.0, 0.0).is_err());
}

/// A mass of 1 kg on a spring of 1 N/m that a stiffer spring holds, as slaves that exchange force and displacement.
fn sprung(units: [&str; 2], stiffness: f64) -> System {
    let [m, n] = units;
    let matrices: [&[f64]; 4] = [&[0.0, 1.0, -1.0, -0.1], &[0.0, 1.0], &[1.0, 0.0], &[0.0]];
    let mass = Linear::new("mass", &[("f", n)], &[("x", m)], matrices, &[1.0, 0.0]);
    let spring = Linear::new("spring", &[("x", m)], &[("f", n)], [&[], &[], &[], &[-stiffness]], &[]);
    let mut system = System::new();
    system.add(mass.boxed()).unwrap();
    system.add(spring.boxed()).unwrap();
    system.connect(("mass", "x"), ("spring", "x"), 1.0, 0.0).unwrap();
    system.connect(("spring", "f"), ("mass", "f"), 1.0, 0.0).unwrap();
    system
}

#[test]
fn a_coupling_without_units_is_told_and_so_is_that_its_steps_are_too_long() {
    let run = |units, algorithm: Algorithm, step: f64| {
        let settings = Settings::new(algorithm, step, 60.0 * step);
        record(sprung(units, 3.0), settings).unwrap().1
    };
    let strong = || Algorithm::Strong(Strong::default());
    let extrapolated = || Algorithm::Jacobi { extrapolation: 1 };
    for units in [["", ""], ["V", "A"]] {
        for (algorithm, step, unresolved) in [
            // Oscillations of 3 s that grow, and those of 60 steps a period.
            (JACOBI, 1.0, true),
            (extrapolated(), 1.0, true),
            (GAUSS_SEIDEL, 1.5, true),
            (JACOBI, 0.05, false),
            (extrapolated(), 0.05, false),
            (strong(), 1.0, false),
        ] {
            let report = run(units, algorithm.clone(), step);
            let [coupling] = &report.unwatched[..] else { panic!("{report:?}") };
            assert_eq!(
                (&coupling.slaves, coupling.units),
                (&["mass", "spring"].map(str::to_owned), !units[0].is_empty())
            );
            assert_eq!(coupling.is_unresolved(), unresolved, "{algorithm:?} {step}: {coupling:?}");
            assert!(!unresolved || ["mass.f", "spring.x"].contains(&&*coupling.input), "{coupling:?}");
        }
    }
    // Units tell of the energy, and so does a declaration.
    assert!(run(["m", "N"], JACOBI, 0.05).unwatched.is_empty());
    let mut declared = sprung(["", ""], 3.0);
    declared.declare_power(("mass", "f"), ("spring", "x")).unwrap();
    assert!(record(declared, Settings::new(JACOBI, 0.05, 1.0)).unwrap().1.unwatched.is_empty());
}

#[test]
fn what_only_feeds_another_is_no_coupling() {
    let mut system = System::new();
    system.add(native("beam", BEAM)).unwrap();
    system.add(Box::new(Source::new("shaker", "force", "", |time| (40.0 * time).sin()))).unwrap();
    system.connect(("shaker", "force"), ("beam", "excitation"), 1.0, 0.0).unwrap();
    assert!(record(system, Settings::new(JACOBI, 1e-2, 1.0)).unwrap().1.unwatched.is_empty());
}
