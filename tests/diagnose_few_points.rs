//! A table of few points is diagnosed by the points left out: the measured frequencies of the frictional support,
//! and tables that the model itself makes.

use std::time::Instant;

use stickslip::diagnose::{
    DiagnoseOptions, DiagnoseWatch, Diagnosis, Verdict, Watch, diagnose, evaluate, refit,
};
use stickslip::measure::{Channel, Dataset, Record, Regime};
use stickslip::model::Model;

const JENKINS: &str = include_str!("../examples/frictional-support/jenkins.toml");
const TABLE: &str = include_str!("../examples/frictional-support/backbone.csv");

fn dataset(amplitudes: Vec<f64>, frequencies: Vec<f64>) -> Dataset {
    let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
    let channels =
        vec![channel("amplitude", "m/s^2", amplitudes), channel("frequency", "Hz", frequencies)];
    let record = Record { name: "backbone".into(), regime: Regime::Backbone, use_for: None, channels };
    Dataset { title: None, records: vec![record] }
}

fn measured() -> Dataset {
    let rows = TABLE.lines().skip(1).map(|line| {
        let (amplitude, frequency) = line.split_once(',').unwrap();
        (amplitude.parse::<f64>().unwrap(), frequency.parse::<f64>().unwrap())
    });
    let (amplitudes, frequencies) = rows.unzip();
    dataset(amplitudes, frequencies)
}

/// What `model` itself says of the measured levels, its friction limit lowered so that it slips.
fn made_by(model: &Model, scatter: impl Fn(usize) -> f64) -> Dataset {
    let levels = measured();
    let stage = evaluate("", model, &levels);
    let frequencies = &stage.records[0].channels[0].predicted;
    let shifted = frequencies.iter().enumerate().map(|(index, value)| value + scatter(index)).collect();
    dataset(levels.records[0].channel("amplitude").unwrap().values.clone(), shifted)
}

fn diagnosed(model: &Model, dataset: &Dataset, effects: Option<&[&str]>) -> Diagnosis {
    let effects = effects.map(|ids| ids.iter().map(|id| (*id).to_owned()).collect());
    let options = DiagnoseOptions { effects, ..DiagnoseOptions::default() };
    let start = Instant::now();
    let found = diagnose(model, dataset, &options, DiagnoseWatch::default()).unwrap();
    println!("{:?} after {:.1} s, {:?}", found.verdict, start.elapsed().as_secs_f64(), found.cost);
    for candidates in std::iter::once(&found.candidates).chain(&found.rounds) {
        for candidate in candidates {
            println!(
                "  {:?} {:?} error {:.4} z {:.2} share {:.3} {:?}",
                candidate.effects, candidate.location, candidate.error, candidate.gain_z, candidate.gain_share,
                candidate.failure
            );
        }
        println!();
    }
    for stage in &found.comparison.stages {
        println!("{}: {:.4} Hz", stage.name, stage.records[0].channels[0].rms);
    }
    found.reasons.iter().for_each(|reason| println!("- {reason}"));
    println!("{:?}", found.groups);
    found
}

#[test]
fn trial_all() {
    diagnosed(&Model::parse(JENKINS).unwrap(), &measured(), None);
}

#[test]
fn a_table_made_by_the_model_itself_gives_no_effect() {
    let mut model = Model::parse(JENKINS).unwrap();
    let truth = refit("", &model, &measured(), Watch::default()).unwrap().model;
    let found = diagnosed(&model, &made_by(&truth, |_| 0.0), None);
    assert!(found.steps.is_empty());
    model.set("contact.tangential_stiffness", 6e6).unwrap();
    // Scatter of the size of the last digits, without a trend.
    for seed in 0..6u64 {
        let mut state = seed;
        let noise: Vec<f64> = (0..8)
            .map(|_| {
                (0..12)
                    .map(|_| {
                        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
                    })
                    .sum::<f64>()
                    * 0.1
            })
            .collect();
        diagnosed(&model, &made_by(&truth, |index| noise[index]), None);
    }
}
