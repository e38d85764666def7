//! The virtual rig: its records are what independent methods say, and its faults those that were asked for.

#[path = "../common/mod.rs"]
mod common;
mod dual_mode;
mod faults;
mod levels;
mod random;
mod ring_down;
mod slip_slap;
mod steady;

use stickslip::data::Record;
use stickslip::model::Model;
use stickslip::rig::{Plan, Test, TestKind, test_on};

const SENSORS: [f64; 3] = [0.55, 0.3, 0.1];

/// The published beam with the published contact, of `modes` modes, changed.
fn published(modes: usize, change: impl Fn(String) -> String) -> Model {
    let text = include_str!("../../examples/frictional-support/published.toml");
    Model::parse(&change(text.replace("modes = 4", &format!("modes = {modes}")))).unwrap()
}

/// The record of one test without faults.
fn record_of(model: &Model, kind: TestKind) -> Record {
    let mut plan = Plan::of_sensors(&SENSORS);
    plan.tests.push(test("test", kind));
    test_on(model, &plan, &mut |_| true).unwrap().remove(0)
}

fn test(name: &str, kind: TestKind) -> Test {
    Test { name: name.into(), use_for: None, kind }
}

fn accelerations(record: &Record) -> Vec<&[f64]> {
    record.channels_of("acceleration").map(|channel| channel.values.as_slice()).collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count)).sqrt()
}
