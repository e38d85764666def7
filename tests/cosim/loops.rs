//! Algebraic loops: solved, or refused with the reason.

use stickslip::cosim::{
    Abilities, Algorithm, Cause, Method, Settings, Slave, SlaveError, Source, Stepped, System, Variable,
};

use crate::common::cosim::*;
use crate::common::linear_slave::*;
use crate::watched::Watched;

/// `y = gain · u` and nothing else.
fn gain(name: &str, gains: &[f64]) -> Linear {
    let inputs: Vec<String> = (1..=gains.len()).map(|n| format!("u{n}")).collect();
    let inputs: Vec<(&str, &str)> = inputs.iter().map(|name| (&**name, "1")).collect();
    Linear::new(name, &inputs, &[("y", "1")], [&[], &[], &[], gains], &[])
}

/// y₁ = 2 s + g y₂, y₂ = −3 y₁, s from outside.
fn pure_loop(gain_back: f64, abilities: Abilities) -> System {
    let mut system = System::new();
    system.add(Box::new(Source::new("s", "y", "1", |time| 1.0 + time))).unwrap();
    system.add(gain("first", &[2.0, gain_back]).with(abilities).boxed()).unwrap();
    system.add(gain("second", &[-3.0]).with(abilities).boxed()).unwrap();
    system.connect(("s", "y"), ("first", "u1"), 1.0, 0.0).unwrap();
    system.connect(("second", "y"), ("first", "u2"), 1.0, 0.0).unwrap();
    system.connect(("first", "y"), ("second", "u1"), 1.0, 0.0).unwrap();
    system
}

#[test]
fn an_algebraic_loop_is_solved_from_the_start_on() {
    let repeating = Abilities { saves_state: true, variable_step: true, ..Abilities::default() };
    for (method, abilities) in [
        (Method::Anderson { depth: 3 }, repeating),
        (Method::Newton, repeating),
        (Method::Newton, EVERYTHING),
        (Method::Aitken, EVERYTHING),
    ] {
        // The gain around the loop is −6: assuming what was given leads away.
        let settings = Settings::new(strong(method), 0.1, 1.0);
        let (rows, report) = record(pure_loop(2.0, abilities), settings).unwrap();
        assert_eq!((rows.len(), report.unconverged), (11, 0), "{method:?}");
        for (time, values) in rows {
            let expected = 2.0 * (1.0 + time) / 7.0;
            assert!((values[1] - expected).abs() < 1e-7, "{method:?} at {time}: {values:?}");
            assert!((values[2] + 3.0 * expected).abs() < 1e-7, "{method:?} at {time}: {values:?}");
        }
    }
}

#[test]
fn a_loop_without_a_solution_is_named_at_the_start() {
    // y₁ = 2 s + y₁ has none.
    let failure = record(pure_loop(-1.0 / 3.0, EVERYTHING), Settings::new(JACOBI, 0.1, 1.0)).unwrap_err();
    let Cause::InitialLoop { variables, residual } = &failure.error.cause else { panic!("{failure}") };
    assert!(variables.iter().any(|name| name == "first.u2") && *residual > 1e-6, "{failure}");
}

#[test]
fn what_does_not_converge_is_reported_with_time_and_residual() {
    // A gain of −0.9 around the loop: slow, and too slow for five repetitions. The start is at zero.
    let run = |iterations| {
        let coupling = stickslip::cosim::Strong { method: Method::FixedPoint, tolerance: 1e-9, iterations };
        let mut system = System::new();
        system.add(Box::new(Source::new("s", "y", "1", f64::sin))).unwrap();
        system.add(gain("first", &[2.0, 0.3]).boxed()).unwrap();
        system.add(gain("second", &[-3.0]).boxed()).unwrap();
        system.connect(("s", "y"), ("first", "u1"), 1.0, 0.0).unwrap();
        system.connect(("second", "y"), ("first", "u2"), 1.0, 0.0).unwrap();
        system.connect(("first", "y"), ("second", "u1"), 1.0, 0.0).unwrap();
        record(system, Settings::new(Algorithm::Strong(coupling), 0.1, 1.0)).unwrap().1
    };
    assert_eq!(run(400).unconverged, 0);
    let report = run(5);
    assert_eq!((report.unconverged, report.steps), (10, 10));
    let example = &report.examples[1];
    assert!((example.time - 0.1).abs() < 1e-12 && example.residual > 1e-9, "{example:?}");
    assert_eq!(example.slave, "first");
}

/// `y = u²`, refused beyond 100.
#[derive(Debug)]
struct Square(Watched, f64);

impl Slave for Square {
    fn name(&self) -> &str {
        "square"
    }
    fn variables(&self) -> &[Variable] {
        self.0.variables()
    }
    fn abilities(&self) -> Abilities {
        Abilities { saves_state: true, variable_step: true, ..Abilities::default() }
    }
    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        if values.iter().any(|value| value.abs() > 100.0) {
            self.0.note("refused");
            let message = "u1 is refused".to_owned();
            let severity = stickslip::cosim::Severity::Call;
            return Err(SlaveError { slave: "square".to_owned(), message, severity });
        }
        self.1 = values[0];
        self.0.set(variables, values)
    }
    fn get(&mut self, variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        self.0.get(variables, values)?;
        values.fill(self.1 * self.1);
        Ok(())
    }
    fn do_step(&mut self, _: f64, _: f64) -> Result<Stepped, SlaveError> {
        Ok(Stepped::Done)
    }
    fn save(&mut self, _: usize) -> Result<(), SlaveError> {
        Ok(())
    }
    fn restore(&mut self, _: usize) -> Result<(), SlaveError> {
        Ok(())
    }
}

#[test]
fn values_that_a_slave_refuses_on_the_way_to_a_solution_are_taken_back() {
    // y = s − 3 y², s from 0 to 30: the fixed point is at first, and then assumed values run away.
    let calls: std::sync::Arc<std::sync::Mutex<Vec<_>>> = std::sync::Arc::default();
    let mut system = System::new();
    system.add(Box::new(Source::new("s", "y", "1", |time| 30.0 * time))).unwrap();
    system.add(gain("first", &[1.0, -3.0]).boxed()).unwrap();
    let slave = gain("square", &[1.0]);
    system.add(Box::new(Square(Watched { slave, calls: std::sync::Arc::clone(&calls) }, 0.0))).unwrap();
    system.connect(("s", "y"), ("first", "u1"), 1.0, 0.0).unwrap();
    system.connect(("square", "y"), ("first", "u2"), 1.0, 0.0).unwrap();
    system.connect(("first", "y"), ("square", "u1"), 1.0, 0.0).unwrap();
    let (rows, report) =
        record(system, Settings::new(strong(Method::Anderson { depth: 3 }), 0.5, 1.0)).unwrap();
    assert!(calls.lock().unwrap().contains(&"refused"));
    assert_eq!(report.unconverged, 0);
    let exact = (-1.0 + (1.0 + 12.0 * 30.0_f64).sqrt()) / 6.0;
    assert!((rows[2].1[1] - exact).abs() < 1e-6, "{rows:?} {exact}");
}
