//! The rig that slips and slaps compared with records of its dual-mode test.
//!
//! Items to verify: the rig that made a record predicts it, with more harmonics than it was made with; a model whose friction
//! is under a constant load does not; a mode over its amplitude is predicted; what is not says so.

use stickslip::data::{Channel, Dataset, Record, Regime};
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

/// A table of the first bending mode over its amplitude: while the contact sticks the frequency is that of the linear rig, and it
/// falls and is damped as friction yields.
#[test]
fn a_mode_over_its_amplitude_is_predicted() {
    let channel = |name: &str, unit: &'static str, values: [f64; 4]| Channel {
        name: name.into(),
        unit,
        values: values.to_vec(),
        noise: None,
    };
    let channels = vec![
        channel("amplitude:x=0.55", "m/s^2", [1e-3, 2.0, 10.0, 20.0]),
        channel("frequency", "Hz", [52.8, 52.7, 52.0, 51.0]),
        channel("damping_ratio", "1", [0.003, 0.004, 0.01, 0.02]),
    ];
    let record = Record { name: "mode.csv".into(), regime: Regime::Backbone, use_for: None, channels };
    let predicted = predict(&rig(FOLLOWING), &record).unwrap();
    let [frequency, damping] = [0, 1].map(|place| &predicted[place].values);
    assert!((frequency[0] - 52.79).abs() < 0.1 && (damping[0] - 0.003).abs() < 2e-4, "{predicted:?}");
    assert!(frequency.windows(2).all(|pair| pair[1] < pair[0]), "{frequency:?}");
    assert!(damping.windows(2).all(|pair| pair[1] > pair[0]), "{damping:?}");
    let mut without = record.clone();
    without.channels[0].name = "amplitude".into();
    let error = predict(&rig(FOLLOWING), &without).unwrap_err().to_string();
    assert!(error.contains("where on the beam"), "{error}");
}

#[test]
fn other_records_of_a_rig_say_what_is_predicted() {
    let mut record = measured(&rig(FOLLOWING), &[[1.0, 2.0]], 5).records.remove(0);
    record.regime = Regime::FromRest;
    let error = predict(&rig(FOLLOWING), &record).unwrap_err().to_string();
    assert!(error.contains("`steady`"), "{error}");
}
