//! A record that cannot be solved is left out with its reason; the others are fitted, diagnosed and added to.
//!
//! Items to verify: refit, diagnosis and addition give what they give without the record, and name it with its
//! reason; where no record can be solved there is an error.

use std::f64::consts::TAU;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{
    DiagnoseOptions, DiagnoseWatch, RefitError, Watch, add, diagnose, evaluate, refit,
};
use stickslip::model::Model;

fn contact() -> Model {
    Model::parse(
        "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
         tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0",
    )
    .unwrap()
}

/// A loop of a slider with a limit of 40 N, to `level` (m) and back, three times.
fn measured(level: f64) -> Record {
    let mut random = fastrand::Rng::with_seed(level.to_bits());
    let (mut slider, mut columns) = (0.0, [Vec::new(), Vec::new(), Vec::new()]);
    for index in 0..300 {
        let u = level * (TAU * f64::from(index) / 100.0).sin();
        slider = f64::clamp(slider, u - 20e-6, u + 20e-6);
        let noise = 0.2 * (random.f64() - 0.5);
        columns[0].push(1e-3 * f64::from(index));
        columns[1].push(u);
        columns[2].push(2e6 * (u - slider) + noise);
    }
    let names = [("time", "s"), ("displacement", "m"), ("force", "N")];
    let channel =
        |((name, unit), values): ((&str, _), _)| Channel { name: name.into(), unit, values, noise: None };
    let channels = names.into_iter().zip(columns).map(channel).collect();
    Record { name: format!("{level}.csv"), regime: Regime::FromRest, use_for: None, channels }
}

/// Marked steady, but its end does not lead to its beginning: no periodic motion is one like that.
fn open() -> Record {
    let mut record = measured(45e-6);
    record.channels.iter_mut().for_each(|channel| channel.values.truncate(230));
    Record { name: "open.csv".into(), regime: Regime::Steady, ..record }
}

fn dataset(records: Vec<Record>) -> Dataset {
    Dataset { title: None, records }
}

/// Loops at four levels, and the same with the open one among them.
fn with_and_without() -> [Dataset; 2] {
    let all: Vec<Record> = [30e-6, 40e-6, 50e-6, 60e-6].map(measured).into();
    let mut with = all.clone();
    with.insert(1, open());
    [dataset(with), dataset(all)]
}

#[test]
fn a_refit_leaves_out_what_cannot_be_solved_and_says_why() {
    let [with, without] = with_and_without();
    let found = refit("", &contact(), &with, Watch::default()).unwrap();
    assert_eq!(found.model, refit("", &contact(), &without, Watch::default()).unwrap().model);
    let [skipped] = &found.skipped[..] else { panic!("{:?}", found.skipped) };
    assert_eq!(skipped.record, "open.csv");
    assert!(skipped.reason.contains("whole periods"), "{}", skipped.reason);
    assert_eq!(found.stage.records[1].failure.as_ref(), Some(&skipped.reason));
    assert!(found.stage.error < 0.01);
}

#[test]
fn where_nothing_can_be_solved_there_is_an_error() {
    let only = dataset(vec![open()]);
    let refused = |error: &dyn std::fmt::Display| {
        assert!(
            error.to_string().contains("open.csv") && error.to_string().contains("whole periods"),
            "{error}"
        );
    };
    refused(&refit("", &contact(), &only, Watch::default()).unwrap_err());
    let (options, watch) = (DiagnoseOptions::default(), DiagnoseWatch::default());
    refused(&diagnose(&contact(), &only, &options, watch).unwrap_err());
    let mut marked = with_and_without()[0].clone();
    marked.records[1].use_for = Some(stickslip::data::Use::Fit);
    let error = refit("", &contact(), &marked, Watch::default()).unwrap_err();
    assert!(matches!(error, RefitError::Unpredictable { .. }), "{error}");
}

#[test]
fn a_diagnosis_is_that_of_the_other_records_and_names_the_one_left_out() {
    let [with, without] = with_and_without();
    let options = DiagnoseOptions { effects: Some(vec!["backlash".into()]), ..DiagnoseOptions::default() };
    let run = |dataset| diagnose(&contact(), dataset, &options, DiagnoseWatch::default()).unwrap();
    let (found, alone) = (run(&with), run(&without));
    assert_eq!((found.verdict, &found.model), (alone.verdict, &alone.model));
    assert_eq!(found.skipped.iter().map(|one| one.record.as_str()).collect::<Vec<_>>(), ["open.csv"]);
    assert!(alone.skipped.is_empty());
    let names: Vec<&str> = found.comparison.records.iter().map(|record| record.name.as_str()).collect();
    assert!(!names.contains(&"open.csv") && names.len() == 4);
}

#[test]
fn an_effect_is_added_by_the_other_records_and_the_stages_name_the_one_left_out() {
    let [with, without] = with_and_without();
    let effect = stickslip::effects::find("backlash").unwrap();
    let run = |dataset| add(&contact(), effect, None, dataset, DiagnoseWatch::default()).unwrap();
    let (found, alone) = (run(&with), run(&without));
    assert_eq!(found.model, alone.model);
    for (stage, alone) in found.stages.iter().zip(&alone.stages) {
        assert_eq!((stage.records.len(), stage.error), (5, alone.error));
        assert!(stage.records[1].failure.as_ref().is_some_and(|reason| reason.contains("whole periods")));
        assert_eq!(stage.records[4], alone.records[3]);
    }
    // What has no error is not equal to itself.
    let before = evaluate("as given", &contact(), &with);
    assert_eq!(format!("{:?}", found.stages[0]), format!("{before:?}"));
}
