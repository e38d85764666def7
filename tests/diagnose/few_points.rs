//! A table of few points is weighed as a whole: the measured frequencies of the frictional support,
//! and tables that the model itself makes.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{
    DiagnoseError, DiagnoseOptions, DiagnoseWatch, Diagnosis, Verdict, diagnose, evaluate,
};
use stickslip::fit::FitError;
use stickslip::fit::compare::RefitError;
use stickslip::model::Model;

const JENKINS: &str = include_str!("../../examples/frictional-support/jenkins.toml");
const TABLE: &str = include_str!("../../examples/frictional-support/backbone.csv");

fn dataset(amplitudes: Vec<f64>, frequencies: Vec<f64>) -> Dataset {
    let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
    let channels = vec![channel("amplitude", "m/s^2", amplitudes), channel("frequency", "Hz", frequencies)];
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

/// What `model` itself says of the measured levels.
fn made_by(model: &Model) -> Dataset {
    let levels = measured();
    let stage = evaluate("", model, &levels);
    let frequencies = &stage.records[0].channels[0].predicted;
    dataset(levels.records[0].channel("amplitude").unwrap().values.clone(), frequencies.clone())
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
                "  {:?} {:?} error {:.4} z {:.2} fraction {:.3}",
                candidate.effects,
                candidate.location,
                candidate.error,
                candidate.gain_z,
                candidate.gain_fraction
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
fn measured_frequencies_give_candidates_with_their_probability_and_never_nothing_missing() {
    let model = Model::parse(JENKINS).unwrap();
    let found = diagnosed(&model, &measured(), Some(&["micro_slip", "residual_stiffness", "sensor_gain"]));
    assert!(found.untried.iter().any(|untried| untried.effect == "sensor_gain"), "{:?}", found.untried);
    let size = |stage: usize| found.comparison.stages[stage].records[0].channels[0].rms;
    assert!((0.2..0.26).contains(&size(1)), "Jenkins refitted: {} Hz", size(1));
    // Eight points cannot tell micro-slip from a residual stiffness, nor either from nothing.
    assert!(matches!(found.verdict, Verdict::InsufficientData | Verdict::NotDistinguishable));
    assert!(found.effects.is_empty() && found.probability < 0.95, "{}", found.probability);
    for id in ["micro_slip", "residual_stiffness"] {
        let alone = found.candidates.iter().find(|candidate| candidate.effects == [id]).unwrap();
        assert!(alone.gain_z > 1.0 && alone.gain_fraction > 0.2, "{alone:?}");
        assert!(found.reasons.iter().any(|reason| reason.contains(id)), "{id}: {:?}", found.reasons);
    }
    assert!(found.reasons[0].starts_with("8 measured values are little evidence"));
}

#[test]
fn a_table_made_by_the_model_itself_gives_no_effect() {
    let model = Model::parse(JENKINS).unwrap();
    let table = made_by(&model);
    let mut off = model;
    off.set("contact.tangential_stiffness", 6e6).unwrap();
    let found = diagnosed(&off, &table, Some(&["micro_slip", "residual_stiffness"]));
    assert!(found.steps.is_empty() && found.effects.is_empty());
    assert_eq!(found.verdict, Verdict::InsufficientData);
}

#[test]
fn a_model_far_off_is_refused_with_its_frequency_the_measured_ones_and_what_to_check() {
    let failure = |modulus: &str| {
        let model = Model::parse(&JENKINS.replace("197.1e9", modulus)).unwrap();
        evaluate("", &model, &measured()).records[0].failure.clone()
    };
    assert_eq!(failure("197.1e9"), None);
    let refused = failure("197.1e3").expect("a beam of a thousandth of the frequency has no such backbone");
    for words in [
        "harmonic balance failed",
        "natural frequency",
        "0.0 Hz",
        "measured are 50.1 to 52.9 Hz",
        "youngs_modulus",
    ] {
        assert!(refused.contains(words), "{words}: {refused}");
    }
}

#[test]
fn an_interrupt_begins_nothing_more_and_keeps_what_was_found() {
    let model = Model::parse(JENKINS).unwrap();
    let told = AtomicUsize::new(0);
    let progress = |_: &str, done: usize, _: usize| {
        told.fetch_add(usize::from(done > 0), Ordering::SeqCst);
    };
    let interrupt = || told.load(Ordering::SeqCst) > 0;
    let watch = DiagnoseWatch { progress: Some(&progress), interrupt: Some(&interrupt) };
    let found = diagnose(&model, &measured(), &DiagnoseOptions::default(), watch).unwrap();
    assert!(found.reasons.iter().any(|reason| reason.contains("interrupted")), "{:?}", found.reasons);
    // What was being tried at that moment, on any thread, may have ended.
    let tried = told.load(Ordering::SeqCst);
    assert!(tried <= rayon::current_num_threads(), "{tried}");
    let watch = DiagnoseWatch { progress: None, interrupt: Some(&|| true) };
    let error = diagnose(&model, &measured(), &DiagnoseOptions::default(), watch).unwrap_err();
    assert_eq!(error, DiagnoseError::Refit(RefitError::Fit(FitError::Interrupted)));
}
