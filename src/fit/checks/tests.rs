//! Every fault is found where it was put in, and nothing in clean records.

mod models;
mod records;
mod starts;

use super::{Fault, check};
use crate::contact::{ContactLaw, Inputs, Jenkins};
use crate::data::{Channel, Dataset, Record, Regime};
use crate::model::Model;

const SAMPLES: usize = 1200;
const STEP: f64 = 1e-3;

fn model() -> Model {
    let text = r#"
        schema = "stickslip.model/1"
        kind = "contact"
        contact = { law = "jenkins", tangential_stiffness = 5e6, friction_coefficient = 0.5, normal_load = 160.0 }
    "#;
    Model::parse(text).unwrap()
}

/// Loops of the model's contact, with noise of this part of the largest values.
fn record(name: &str, noise: f64, seed: u64) -> Record {
    let law = Jenkins::new(5e6, 0.5).unwrap();
    let mut state = vec![0.0; law.state_len()];
    let mut random = fastrand::Rng::with_seed(seed);
    let mut noisy = |size: f64| noise * size * (0..12).map(|_| random.f64() - 0.5).sum::<f64>();
    let (mut time, mut displacement, mut force) = (Vec::new(), Vec::new(), Vec::new());
    let speed = 13.7 + seed as f64;
    for k in 0..SAMPLES {
        let t = STEP * k as f64;
        let (u, v) = (4e-5 * (speed * t).sin(), 4e-5 * speed * (speed * t).cos());
        let inputs = Inputs { displacement: u, velocity: v, normal_load: 160.0 };
        time.push(t);
        displacement.push(u + noisy(4e-5));
        force.push(law.advance(&mut state, inputs) + noisy(80.0));
    }
    let channel = |name: &str, unit, values| Channel { name: name.to_owned(), unit, values, noise: None };
    let channels = vec![
        channel("time", "s", time),
        channel("displacement", "m", displacement),
        channel("force", "N", force),
    ];
    Record { name: name.to_owned(), regime: Regime::UnknownInitialState, use_for: None, channels }
}

fn ids(records: Vec<Record>) -> Vec<&'static str> {
    check(&model(), &Dataset { title: None, records }).iter().map(|found| found.fault.id()).collect()
}

/// The faults that `change` makes in the record, at every level of noise.
fn faults(change: impl Fn(&mut Record)) -> Vec<Vec<&'static str>> {
    let changed = |(seed, noise): (usize, f64)| {
        let mut record = record("r.csv", noise, seed as u64);
        change(&mut record);
        ids(vec![record])
    };
    [0.001, 0.003, 0.01, 0.03].into_iter().enumerate().map(changed).collect()
}

fn values<'r>(record: &'r mut Record, name: &str) -> &'r mut Vec<f64> {
    &mut record.channels.iter_mut().find(|channel| channel.name == name).unwrap().values
}

#[test]
fn clean_records_have_no_findings() {
    for noise in [0.0, 1e-4, 0.003, 0.01, 0.03, 0.1] {
        for seed in 0..20 {
            let records = vec![record("a.csv", noise, seed), record("b.csv", noise, seed + 100)];
            assert_eq!(ids(records), Vec::<&str>::new(), "noise {noise}, seed {seed}");
        }
    }
}

#[test]
fn each_fault_is_named_at_every_noise() {
    let hum = |k: usize| 6.0 * (std::f64::consts::TAU * 50.0 * STEP * k as f64).sin();
    type Change = (&'static str, Box<dyn Fn(&mut Record)>);
    let changes: Vec<Change> = vec![
        ("reversed-sign", Box::new(|one| values(one, "force").iter_mut().for_each(|f| *f = -*f))),
        ("scale", Box::new(|one| values(one, "force").iter_mut().for_each(|f| *f *= 1e-3))),
        ("scale", Box::new(|one| values(one, "force").iter_mut().for_each(|f| *f *= 1e3))),
        ("scale", Box::new(|one| values(one, "displacement").iter_mut().for_each(|u| *u *= 1e3))),
        ("scale", Box::new(|one| values(one, "displacement").iter_mut().for_each(|u| *u *= 1e-3))),
        ("outlier", Box::new(|one| values(one, "force")[500] *= 10.0)),
        ("outlier", Box::new(|one| values(one, "displacement")[612] *= 100.0)),
        ("clipping", Box::new(|one| values(one, "force").iter_mut().for_each(|f| *f = f.clamp(-60.0, 60.0)))),
        (
            "drop-outs",
            Box::new(|one| {
                [520, 700, 911].into_iter().for_each(|from| values(one, "force")[from..from + 9].fill(0.0))
            }),
        ),
        (
            "quantisation",
            Box::new(|one| {
                values(one, "force").iter_mut().for_each(|f| *f = (*f / 8.0).round() * 8.0);
            }),
        ),
        (
            "mains-hum",
            Box::new(move |one| {
                values(one, "force").iter_mut().enumerate().for_each(|(k, f)| *f += hum(k));
            }),
        ),
        ("time-gap", Box::new(|one| values(one, "time")[700..].iter_mut().for_each(|t| *t += 0.03))),
        (
            "moving-at-start",
            Box::new(|one| {
                one.regime = Regime::FromRest;
                one.channels.iter_mut().skip(1).for_each(|channel| drop(channel.values.drain(..60)));
                values(one, "time").truncate(SAMPLES - 60);
            }),
        ),
        (
            "copy-of-channel",
            Box::new(|one| {
                let copy = values(one, "force").clone();
                one.channels.push(Channel {
                    name: "normal_load".to_owned(),
                    unit: "N",
                    values: copy,
                    noise: None,
                });
            }),
        ),
    ];
    for (name, change) in changes {
        for found in faults(change) {
            assert!(found.contains(&name), "{name}: {found:?}");
            assert!(found.len() == 1 || name == "copy-of-channel", "{name}: {found:?}");
        }
    }
}

#[test]
fn a_record_given_twice_is_named_under_another_name_and_time() {
    let first = record("a.csv", 0.01, 1);
    let mut second = Record { name: "b.csv".to_owned(), ..first.clone() };
    values(&mut second, "time").iter_mut().for_each(|t| *t += 3.0);
    assert_eq!(ids(vec![first, second]), ["given-twice"]);
}

/// What the wrong unit of a key makes of a beam is said with the key.
#[test]
fn implausible_keys_of_a_beam_are_named() {
    let text = include_str!("../../../examples/frictional-support/published.toml");
    let dataset = Dataset { title: None, records: Vec::new() };
    assert_eq!(check(&Model::parse(text).unwrap(), &dataset), []);
    for (from, to, key) in [
        ("youngs_modulus = 197.1e9", "youngs_modulus = 197.1", "beam.youngs_modulus"),
        ("thickness = 0.005 ", "thickness = 5.0 ", "beam.thickness"),
        ("density = 7850.0", "density = 7.85e-9", "beam.density"),
    ] {
        let found = check(&Model::parse(&text.replace(from, to)).unwrap(), &dataset);
        assert!(found.iter().any(|one| one.channel.as_deref() == Some(key)), "{found:?}");
        assert!(matches!(found[0].fault, Fault::Implausible { .. }));
        assert!(found[0].to_string().contains("expected"), "{}", found[0]);
    }
}

/// A mass in g where kg is expected makes the frequencies of the data and the model part by √1000.
#[test]
fn frequencies_of_a_model_in_other_units_part_from_the_data() {
    let model = |mass: f64| {
        let text = format!(
            "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{{ name = \"m1\", mass = {mass} }}]\n\
             spring = [{{ between = [\"ground\", \"m1\"], stiffness = 4e4 }}]"
        );
        Model::parse(&text).unwrap()
    };
    let of = |f: &dyn Fn(f64) -> f64| (0..4000).map(|k| f(k as f64 * 1e-3)).collect::<Vec<f64>>();
    let channel = |name: &str, unit, values| Channel { name: name.to_owned(), unit, values, noise: None };
    let channels = vec![
        channel("time", "s", of(&|t| t)),
        channel("acceleration:m1", "m/s^2", of(&|t| 30.0 * (200.0 * t).sin())),
    ];
    let record = Record { name: "r.csv".to_owned(), regime: Regime::Steady, use_for: None, channels };
    let dataset = Dataset { title: None, records: vec![record] };
    assert_eq!(check(&model(1.0), &dataset), []);
    let found = check(&model(1000.0), &dataset);
    assert!(found.len() == 1 && found[0].to_string().contains("mass in g"), "{found:?}");
}

#[test]
fn a_pin_that_sticks_is_held_in_both_directions() {
    let model = Model::parse(include_str!("../../../examples/slip-slap/model.toml")).unwrap();
    let [free, stuck] = super::natural_frequencies(&model).unwrap();
    // Frequencies (Hz) of the exact determinant of this rig, its pin bonded.
    for reference in [52.7873, 164.4231, 335.8551] {
        let near = |all: &[f64]| all.iter().any(|one| (one / reference - 1.0).abs() < 1e-3);
        assert!(near(&stuck) && !near(&free), "{reference}: {stuck:?} {free:?}");
    }
}
