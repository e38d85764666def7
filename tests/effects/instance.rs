//! Effects in an FMU: parameters of their own, and the law they make, walked as it is natively.

use stickslip::contact::Inputs;
use stickslip::fmi::{Causality, Instance};
use stickslip::model::Model;

const MODEL: &str = r#"
schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "jenkins"
tangential_stiffness = 5e6
friction_coefficient = 0.5
normal_load = 150.0

[[effect]]
id = "micro_slip"
spread = 0.6

[[effect]]
id = "residual_stiffness"
residual_stiffness = 2e5

[[effect]]
id = "contact_damping"
damping = 40.0

[[effect]]
id = "velocity_weakening"
weakening = 0.3
weakening_velocity = 2e-3

[[effect]]
id = "wear"
rate = 20.0

[[effect]]
id = "backlash"
half_gap = 6e-6

[[effect]]
id = "stiffening"
cubic_stiffness = 1e14

[[effect]]
id = "asymmetry"
asymmetry = 0.1

[[effect]]
id = "normal_load_variation"
load_gain = 0.8

[[effect]]
id = "sensor_gain"
channel = "force"
gain = 1.1
"#;

/// Displacement, velocity and measured normal load at `time` (s).
fn motion(time: f64) -> [f64; 3] {
    let (a, b) = (40.0 * time, 93.0 * time);
    let displacement = 6e-5 * (a.sin() + 0.4 * b.sin());
    let velocity = 6e-5 * (40.0 * a.cos() + 0.4 * 93.0 * b.cos());
    [displacement, velocity, 150.0 * (1.0 + 1.5 * (17.0 * time).sin())]
}

fn reference(instance: &Instance, name: &str) -> u32 {
    let variables = &instance.description().variables;
    let index = variables.iter().position(|variable| variable.name == name);
    u32::try_from(index.unwrap_or_else(|| panic!("{name} is no variable"))).unwrap()
}

/// Forces of an instance of `model` in which `changed` parameters were set.
fn forces(model: &str, changed: &[(&str, f64)]) -> Vec<f64> {
    let mut instance = Instance::new(model).unwrap();
    let inputs = ["displacement", "velocity", "normal_load"].map(|name| reference(&instance, name));
    let force = reference(&instance, "force");
    instance.enter_initialization().unwrap();
    for (name, value) in changed {
        let parameter = reference(&instance, name);
        instance.set_real(&[parameter], &[*value]).unwrap();
    }
    instance.set_real(&inputs, &motion(0.0)).unwrap();
    instance.exit_initialization().unwrap();
    let mut all = Vec::new();
    for index in 0..400 {
        let time = f64::from(index) * 1e-3;
        instance.set_real(&inputs, &motion(time + 1e-3)).unwrap();
        instance.do_step(time, 1e-3).unwrap();
        let mut value = [0.0];
        instance.get_real(&[force], &mut value).unwrap();
        all.push(value[0]);
    }
    all
}

/// The same forces from the law itself.
fn walked(model: &Model) -> Vec<f64> {
    let law = model.law().unwrap().unwrap();
    let joint = model.changes().joint;
    let mut state = vec![0.0; law.state_len()];
    let inputs = |time: f64| {
        let [displacement, velocity, measured] = motion(time);
        Inputs { displacement, velocity, normal_load: joint.normal_load(150.0, Some(measured)) }
    };
    law.set_state(0.0, inputs(0.0).normal_load, 0.0, &mut state);
    law.advance(&mut state, inputs(0.0));
    (1..=400).map(|index| law.advance(&mut state, inputs(f64::from(index) * 1e-3))).collect()
}

fn same(found: &[f64], expected: &[f64]) {
    assert!(expected.iter().any(|force| force.abs() > 50.0));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-9, "{a} and {b}");
    }
}

#[test]
fn an_instance_with_every_effect_is_the_law_walked() {
    same(&forces(MODEL, &[]), &walked(&Model::parse(MODEL).unwrap()));
}

#[test]
fn effects_are_parameters_that_can_be_set_also_to_nothing() {
    let changed = [("effect.6.half_gap", 2e-6), ("effect.5.rate", 0.0), ("effect.1.spread", 0.0)];
    let mut model = Model::parse(MODEL).unwrap();
    let paths: Vec<(&str, f64)> = changed.to_vec();
    model.set_all(&paths).unwrap();
    same(&forces(MODEL, &changed), &walked(&model));
}

#[test]
fn parameters_carry_the_effects_name_and_faults_of_sensors_are_none() {
    let instance = Instance::new(MODEL).unwrap();
    let variables = &instance.description().variables;
    let gap = &variables[reference(&instance, "effect.6.half_gap") as usize];
    assert_eq!((gap.causality, gap.start, gap.quantity.unit), (Causality::Parameter, 6e-6, "m"));
    assert!(gap.description.starts_with("Backlash: "), "{}", gap.description);
    assert!(
        variables
            .iter()
            .all(|variable| !variable.name.contains("gain") || variable.name.ends_with("load_gain"))
    );
    let mut names: Vec<&str> = variables.iter().map(|variable| &*variable.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), variables.len());
    // The force hangs on the velocity here.
    let force = &variables[reference(&instance, "force") as usize];
    assert!(force.dependencies.iter().any(|dependency| dependency.on == reference(&instance, "velocity")));
}
