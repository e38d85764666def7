//! Oscillators compared with records: made by the exact flow here, and by a program of other make where its data
//! are at hand (`../shared/data` or `STICKSLIP_DATA`).

use stickslip::contact::Jenkins;
use stickslip::data::{Channel, ChannelName, Dataset, Record, Regime};
use stickslip::diagnose::evaluate;
use stickslip::effects::{AppliedEffect, find};
use stickslip::fit::{self, Options, Parameter, Scale};
use stickslip::model::Model;
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow};

use crate::common::external;

/// A case of the hidden-effect data with the records wanted.
fn hidden(case: usize, records: &[usize]) -> Option<(Model, Dataset)> {
    let folder = external::data(&format!("hidden-effect/case-{case}"))?;
    let model = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    let table = std::fs::read_to_string(folder.join("dataset.toml")).unwrap();
    let noise_of = |record: usize, channel: &str| -> Option<f64> {
        let after = table.split(&format!("\"r{record}.csv\"")).nth(1)?.split("[[record]]").next()?;
        let after = after.split(&format!("\"{channel}\" = ")).nth(1)?;
        after.split([',', ' ', '}']).next()?.parse().ok()
    };
    let read = |record: &usize| {
        let text = std::fs::read_to_string(folder.join(format!("r{record}.csv"))).unwrap();
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',');
        let mut channels: Vec<Channel> = header
            .map(|name| {
                let name = ChannelName::parse(name.split(" [").next().unwrap()).unwrap();
                let (unit, name) = (name.quantity.unit, name.to_string());
                Channel { noise: noise_of(*record, &name), name, unit, values: Vec::new() }
            })
            .collect();
        for line in lines {
            for (channel, value) in channels.iter_mut().zip(line.split(',')) {
                channel.values.push(value.parse().unwrap());
            }
        }
        Record { name: format!("r{record}"), regime: Regime::FromRest, use_for: None, channels }
    };
    let records = records.iter().map(read).collect();
    Some((Model::parse(&model).unwrap(), Dataset { title: None, records }))
}

/// χ² per record and channel, over the stated noise.
fn chi_squares(model: &Model, dataset: &Dataset) -> Vec<f64> {
    let stage = evaluate("", model, dataset);
    let channels = stage.records.iter().zip(&dataset.records).flat_map(|(result, record)| {
        assert_eq!(result.failure, None);
        result
            .channels
            .iter()
            .map(|channel| channel.rms / record.channel(&channel.name).unwrap().noise.unwrap())
    });
    channels.map(|fraction| fraction * fraction).collect()
}

/// Fits springs, dampers and contact, and the value of an effect if there is one, to the records by their noise.
fn fitted(model: &Model, dataset: &Dataset, effect: Option<(&str, f64, f64)>) -> (Model, f64) {
    let paths = [
        "spring.1.stiffness",
        "spring.1.damping",
        "spring.2.stiffness",
        "spring.2.damping",
        "contact.tangential_stiffness",
        "contact.friction_coefficient",
    ];
    let around =
        |start: f64| Parameter { start, lower: 0.3 * start, upper: 3.0 * start, scale: Scale::Logarithmic };
    let mut parameters: Vec<Parameter> = paths.iter().map(|path| around(model.get(path).unwrap())).collect();
    if let Some((_, start, size)) = effect {
        parameters.push(Parameter { start, lower: -size, upper: size, scale: Scale::Linear });
    }
    let with = |values: &[f64]| {
        let mut trial = model.clone();
        for (path, value) in paths.iter().zip(values) {
            trial.set(path, *value).unwrap();
        }
        if let Some((id, _, _)) = effect {
            trial.effects = vec![AppliedEffect {
                effect: find(id).unwrap(),
                location: None,
                values: values[paths.len()..].to_vec(),
            }];
        }
        trial
    };
    let residual = |values: &[f64], out: &mut [f64]| -> Result<(), String> {
        let stage = evaluate("", &with(values), dataset);
        let mut out = out.iter_mut();
        for (result, record) in stage.records.iter().zip(&dataset.records) {
            for channel in &result.channels {
                let measured = record.channel(&channel.name).unwrap();
                for (value, measured_value) in channel.predicted.iter().zip(&measured.values) {
                    *out.next().unwrap() = (value - measured_value) / measured.noise.unwrap();
                }
            }
        }
        Ok(())
    };
    let count = dataset.records.iter().map(|record| 2 * record.len()).sum();
    let options = Options { max_iterations: 12, tolerance: 1e-6, ..Options::default() };
    let fit = fit::fit(residual, count, &parameters, &options).unwrap();
    (with(&fit.parameters), fit.parameters.last().copied().unwrap())
}

const TWO_MASSES: &str = include_str!("../../examples/friction-vibration/model.toml");
const OMEGA: f64 = 0.5;
const SAMPLES_OF_A_PERIOD: usize = 200;

/// What the exact flow of the two masses under `0.4 cos Ωt` shows between two periods, sampled.
fn sampled(regime: Regime, periods: std::ops::Range<usize>) -> Record {
    let model = Model::parse(TWO_MASSES).unwrap();
    let contact = model.contact.unwrap();
    let law = Jenkins::new(contact.tangential_stiffness, contact.friction_coefficient).unwrap();
    let contacts = [LoadedContact { law: &law, normal_load: contact.normal_load }];
    let mut flow = OscillatorFlow::new(&model.system().unwrap().linear_part(), &contacts).unwrap();
    let excitation = Excitation::cosine(OMEGA, 0.4);
    let step = std::f64::consts::TAU / OMEGA / SAMPLES_OF_A_PERIOD as f64;
    let mut motion = flow.rest();
    let mut columns: [Vec<f64>; 5] = Default::default();
    for index in 0..periods.end * SAMPLES_OF_A_PERIOD {
        if index >= periods.start * SAMPLES_OF_A_PERIOD {
            let (x, v) = (flow.displacement(&motion), flow.velocity(&motion));
            let force = excitation.value(motion.time());
            let acceleration = force - 0.1 * v[0] - x[0] - 0.5 * (x[0] - x[1]);
            for (column, value) in columns.iter_mut().zip([motion.time(), force, x[1], v[0], acceleration]) {
                column.push(value);
            }
        }
        flow.advance(&mut motion, step, &excitation).unwrap();
    }
    let names = ["time", "excitation:m1", "displacement:m2", "velocity:m1", "acceleration:m1"];
    let channels = names.into_iter().zip(columns).map(|(name, values)| {
        let unit = ChannelName::parse(name).unwrap().quantity.unit;
        Channel { name: name.into(), unit, values, noise: None }
    });
    Record { name: "sampled".into(), regime, use_for: None, channels: channels.collect() }
}

/// Errors of the channels, as fractions of their standard deviations.
fn errors(record: Record) -> Vec<f64> {
    let dataset = Dataset { title: None, records: vec![record] };
    let stage = evaluate("", &Model::parse(TWO_MASSES).unwrap(), &dataset);
    assert_eq!(stage.records[0].failure, None);
    stage.records[0].channels.iter().map(|channel| channel.error).collect()
}

#[test]
fn records_of_every_regime_in_time_are_predicted_far_below_any_noise() {
    for (regime, periods) in [
        (Regime::FromRest, 0..6),
        (Regime::Steady, 80..82),
        (Regime::UnknownInitialState, 2..6),
        (Regime::UnknownInitialState, 80..84),
    ] {
        let errors = errors(sampled(regime, periods));
        println!("{regime:?} {errors:?}");
        assert_eq!(errors.len(), 3);
        assert!(errors.iter().all(|error| *error < 5e-4), "{regime:?}: {errors:?}");
    }
}

#[test]
fn a_measured_load_counts_as_far_as_its_gain_says() {
    let mut record = sampled(Regime::FromRest, 0..3);
    let values = vec![1.4; record.len()];
    record.channels.push(Channel { name: "normal_load".into(), unit: "N", values, noise: None });
    let dataset = Dataset { title: None, records: vec![record] };
    let predicted = |model: &Model| -> Vec<Vec<f64>> {
        let stage = evaluate("", model, &dataset);
        stage.records[0].channels.iter().map(|channel| channel.predicted.clone()).collect()
    };
    let plain = Model::parse(TWO_MASSES).unwrap();
    let load = plain.contact.unwrap().normal_load;
    let mut following = plain.clone();
    following.effects.push(AppliedEffect {
        effect: find("normal_load_variation").unwrap(),
        location: None,
        values: vec![0.5],
    });
    let mut heavier = plain.clone();
    heavier.set("contact.normal_load", load + 0.5 * (1.4 - load)).unwrap();
    assert_eq!(predicted(&following), predicted(&heavier));
    assert_ne!(predicted(&following), predicted(&plain));
}

#[test]
fn a_stray_mass_is_refused_with_a_reason() {
    let model = Model::parse(TWO_MASSES).unwrap();
    let failure = |record: Record| {
        let dataset = Dataset { title: None, records: vec![record] };
        evaluate("", &model, &dataset).records[0].failure.clone().unwrap()
    };
    let mut record = sampled(Regime::FromRest, 0..1);
    record.channels[1].name = "excitation:m7".into();
    assert!(failure(record.clone()).contains("excitation:m7"));
    record.channels.remove(1);
    assert!(failure(record).contains("excitation"));
}

#[test]
fn a_complete_model_reaches_the_noise_of_data_of_other_make() {
    let Some((model, dataset)) = hidden(6, &[1, 5]) else { return };
    let (model, _) = fitted(&model, &dataset, None);
    let chi_squares = chi_squares(&model, &dataset);
    println!("{chi_squares:.4?}");
    assert!(chi_squares.iter().all(|chi_square| (0.9..1.1).contains(chi_square)), "{chi_squares:?}");
}

#[test]
fn the_effect_that_is_missing_brings_the_model_to_the_noise() {
    let Some((model, dataset)) = hidden(7, &[1, 6]) else { return };
    let (without, _) = fitted(&model, &dataset, None);
    let worst = chi_squares(&without, &dataset).into_iter().fold(0.0, f64::max);
    println!("without {worst}");
    assert!(worst > 1.5, "{worst}");
    let (with, stiffness) = fitted(&model, &dataset, Some(("geometric_stiffening", 1e6, 1e9)));
    let chi_squares = chi_squares(&with, &dataset);
    println!("{stiffness:e} {chi_squares:.4?}");
    assert!(stiffness > 0.0);
    assert!(chi_squares.iter().all(|chi_square| (0.9..1.1).contains(chi_square)), "{chi_squares:?}");
}
