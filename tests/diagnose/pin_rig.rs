//! The rig that slips and slaps compared with records of its dual-mode test.
//!
//! Items to verify: the rig that made a record predicts it, with more harmonics than it was made with; a model whose friction
//! is under a constant load does not; what is not predicted says so.

use stickslip::data::{Dataset, Record};
use stickslip::diagnose::evaluate;
use stickslip::fit::predict::predict;
use stickslip::model::Model;
use stickslip::rig::{DualMode, Plan, Test, TestKind, test_on};

/// Valanis' contact whose friction limit follows the normal force, and the one under a constant load.
const FOLLOWING: &str = r#"
[contact]
law = "valanis"
tangential_stiffness = 3.95e6
friction_coefficient = 0.6
smoothness = 0.3
normal_load = 68.67
normal_law = "linear"
normal_stiffness = 2.37e7
"#;

fn constant() -> String {
    FOLLOWING.replace("normal_law = \"linear\"\n", "")
}

/// The example's rig with few modes and this contact.
fn rig(contact: &str) -> Model {
    let example = include_str!("../../examples/slip-slap/model.toml");
    let start = example.find("[contact]").unwrap();
    let rig = example[..start].replace("modes = 20", "modes = 6");
    Model::parse(&format!("{rig}{contact}")).unwrap()
}

/// Dual-mode records of `model` at these levels (m/s²).
fn measured(model: &Model, levels: &[[f64; 2]], harmonics: usize) -> Dataset {
    let mut plan = Plan::of_sensors(&[0.55, 0.3, 0.05]);
    let test =
        DualMode { harmonics, periods: 2, samples_per_period: 128, ..DualMode::at(52.0, levels.to_vec()) };
    plan.tests.push(Test { name: "level".into(), use_for: None, kind: TestKind::DualMode(test) });
    let records: Vec<Record> = test_on(model, &plan, &mut |_| true).unwrap();
    Dataset { title: None, records }
}

#[test]
fn the_rig_that_made_a_record_predicts_it() {
    let truth = rig(FOLLOWING);
    let dataset = measured(&truth, &[[14.0, 34.0], [20.0, 50.0]], 30);
    let stage = evaluate("", &truth, &dataset);
    assert!(stage.error < 1e-3, "{}", stage.error);
    let other = evaluate("", &rig(&constant()), &dataset);
    assert!(other.records.iter().all(|record| record.failure.is_none()));
    assert!(other.error > 0.05, "{}", other.error);
    // All of the change of the normal force reaches the friction: the same rig.
    let varying = format!("{}\n[[effect]]\nid = \"normal_load_variation\"\nload_gain = 1.0\n", constant());
    let same = evaluate("", &rig(&varying), &dataset);
    assert!((same.error - stage.error).abs() < 1e-6, "{} {}", same.error, stage.error);
}

#[test]
fn other_records_of_a_rig_say_what_is_predicted() {
    let mut record = measured(&rig(FOLLOWING), &[[1.0, 2.0]], 5).records.remove(0);
    record.regime = stickslip::data::Regime::FromRest;
    let error = predict(&rig(FOLLOWING), &record).unwrap_err().to_string();
    assert!(error.contains("`steady`"), "{error}");
}
