//! What makes a system: wrong connections are named, orders and loops are found.

use stickslip::cosim::{
    Abilities, Adaptive, Algorithm, Causality, Control, Kind, Master, Settings, Slave, SlaveError, Stepped,
    System, SystemError, Variable,
};

use crate::common::cosim::*;
use crate::common::linear_slave::*;

fn refused(connect: impl Fn(&mut System) -> Result<(), SystemError>) -> SystemError {
    let mut system = joined(TWO_MASSES.slaves());
    connect(&mut system).unwrap_err()
}

#[test]
fn what_cannot_be_connected_is_named() {
    let messages = [
        (
            refused(|system| system.connect(("third", "force"), ("first", "force"), 1.0, 0.0)),
            "the system has no slave third",
        ),
        (
            refused(|system| system.connect(("first", "farce"), ("first", "force"), 1.0, 0.0)),
            "first has no variable farce",
        ),
        (
            refused(|system| system.connect(("second", "displacement"), ("first", "force"), 1.0, 0.0)),
            "second.displacement is not an output: nothing can be fed from it",
        ),
        (
            refused(|system| system.connect(("second", "force"), ("first", "velocity"), 1.0, 0.0)),
            "first.velocity is not an input: nothing can be connected to it",
        ),
        (
            refused(|system| system.connect(("second", "position"), ("first", "force"), 1.0, 0.0)),
            "first.force is fed from both second.force and second.position",
        ),
        (
            refused(|system| system.connect(("second", "position"), ("first", "force"), f64::NAN, 0.0)),
            "first.force: factor = NaN is not a finite number",
        ),
        (
            refused(|system| system.start("first", "velocity", 1.0)),
            "first.velocity cannot be given a start value: the slave computes it",
        ),
        (
            refused(|system| {
                system.add(TWO_MASSES.slaves().map(Linear::boxed).into_iter().next().unwrap()).map(drop)
            }),
            "two slaves are called first",
        ),
        (
            refused(|system| system.declare_power(("first", "force"), ("first", "force"))),
            "force first.force and motion first.force are no power connection: they do not join the same two slaves",
        ),
    ];
    for (error, message) in messages {
        assert_eq!(error.to_string(), message);
    }
}

/// One whole number in, one truth out, one real in.
#[derive(Debug)]
struct Switch([Variable; 3]);

impl Switch {
    fn new() -> Self {
        let row = |name: &str, kind, causality| Variable {
            name: name.into(),
            reference: 0,
            kind,
            causality,
            unit: None,
            start: None,
            depends_on: None,
        };
        Self([
            row("count", Kind::Integer, Causality::Input),
            row("on", Kind::Boolean, Causality::Output),
            row("level", Kind::Real, Causality::Input),
        ])
    }
}

impl Slave for Switch {
    fn name(&self) -> &str {
        "switch"
    }
    fn variables(&self) -> &[Variable] {
        &self.0
    }
    fn abilities(&self) -> Abilities {
        Abilities::default()
    }
    fn set(&mut self, _: &[usize], _: &[f64]) -> Result<(), SlaveError> {
        Ok(())
    }
    fn get(&mut self, _: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        values.fill(1.0);
        Ok(())
    }
    fn do_step(&mut self, _: f64, _: f64) -> Result<Stepped, SlaveError> {
        Ok(Stepped::Done)
    }
}

#[test]
fn kinds_of_numbers_are_widened_and_never_narrowed() {
    let mut system = joined(TWO_MASSES.slaves());
    system.add(Box::new(Switch::new())).unwrap();
    let narrowed = system.connect(("first", "velocity"), ("switch", "count"), 1.0, 0.0).unwrap_err();
    assert_eq!(
        narrowed.to_string(),
        "first.velocity is Real and switch.count is Integer: they cannot be connected"
    );
    let scaled = system.connect(("switch", "on"), ("switch", "count"), 2.0, 0.0).unwrap_err();
    assert!(matches!(scaled, SystemError::TransformedWholeNumber { .. }), "{scaled}");
    system.connect(("switch", "on"), ("switch", "count"), 1.0, 0.0).unwrap();
    system.connect(("switch", "on"), ("switch", "level"), 2.0, 1.0).unwrap();
}

#[test]
fn settings_out_of_range_are_refused() {
    let check = |change: fn(&mut Settings)| {
        let mut settings = Settings::new(JACOBI, 0.1, 1.0);
        change(&mut settings);
        Master::new(joined(TWO_MASSES.slaves()), settings).unwrap_err().to_string()
    };
    assert_eq!(check(|settings| settings.step = 0.0), "step = 0.0 is refused; it must be finite, above 0");
    // No step meets what rounding errors alone exceed.
    let refused = check(|settings| {
        let (smallest, largest, control) = (1e-6, 0.2, Control::Both);
        settings.adaptive = Some(Adaptive { tolerance: 1e-30, smallest, largest, control });
    });
    assert!(refused.contains("1e-30") && refused.contains("from 1e-10 to 1"), "{refused}");
    assert!(check(|settings| settings.stop = -1.0).starts_with("stop = -1"));
    let order = |names: &[&str]| {
        let order = Some(names.iter().map(|name| (*name).to_owned()).collect());
        let settings = Settings::new(Algorithm::GaussSeidel { extrapolation: 0, order }, 0.1, 1.0);
        Master::new(joined(TWO_MASSES.slaves()), settings).unwrap_err()
    };
    assert!(matches!(order(&["first", "third"]), SystemError::UnknownSlave { .. }));
    let twice = order(&["first", "first", "second"]).to_string();
    assert_eq!(twice, "the order of slaves must name each slave once; first is named 2 times");
}

#[test]
fn power_passes_where_force_and_motion_join_the_same_two() {
    let system = beam_with(JENKINS, Shaker { amplitude: 1.0, omega: 1.0, growth: 1.0 });
    let power = system.power_connections();
    assert_eq!(power.len(), 1, "not the shaker: {power:?}");
    assert_eq!(system.full_name(power[0].force), "beam.contact_force");
    assert_eq!(power[0].displacement.map(|port| system.full_name(port)).unwrap(), "contact.displacement");
    assert_eq!(power[0].velocity.map(|port| system.full_name(port)).unwrap(), "contact.velocity");
}

#[test]
fn an_algebraic_loop_is_found_and_named() {
    let system = beam_with(JENKINS, Shaker { amplitude: 1.0, omega: 1.0, growth: 1.0 });
    let loops = system.algebraic_loops();
    assert_eq!(loops.len(), 1);
    // Force makes the axial spring yield, which is displacement, which makes force.
    let mut names: Vec<String> = loops[0].iter().map(|port| system.full_name(*port)).collect();
    names.sort();
    assert_eq!(names, ["beam.contact_force", "contact.displacement"]);
    let settings = Settings { refuse_algebraic_loops: true, ..Settings::new(JACOBI, 1e-4, 1.0) };
    let error = Master::new(system, settings).unwrap_err();
    assert!(matches!(error, SystemError::AlgebraicLoop { .. }), "{error}");
    assert!(joined(TWO_MASSES.slaves()).algebraic_loops().is_empty(), "the first mass has inertia");
}
