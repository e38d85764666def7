//! Two effects at once.

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{DiagnoseOptions, DiagnoseWatch, Verdict, diagnose};
use stickslip::fit::predict::predict;
use stickslip::model::Model;

const SAMPLES: usize = 600;
const NOISE: f64 = 0.01;

fn text(stiffness: f64, friction: f64) -> String {
    format!(
        "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
         tangential_stiffness = {stiffness}\nfriction_coefficient = {friction}\nnormal_load = 74.0\n"
    )
}

/// A joint with sliders that yield one after the other and a slope that is left in slip, moved to and fro at several levels, and
/// the model of an engineer who knows neither.
fn measured(random: &mut fastrand::Rng) -> (Model, Dataset) {
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let (stiffness, friction) = (between(5e6, 7e6), between(0.3, 0.5));
    let hidden = format!(
        "{}[[effect]]\nid = \"micro_slip\"\nspread = {}\n[[effect]]\nid = \"residual_stiffness\"\nresidual_stiffness = {}\n",
        text(stiffness, friction),
        between(0.8, 0.95),
        between(0.08, 0.12) * stiffness,
    );
    let truth = Model::parse(&hidden).unwrap();
    let yielding = 74.0 * friction / stiffness;
    let mut record = |level: f64| {
        let step = std::f64::consts::TAU * between(5.0, 14.0).round() / SAMPLES as f64;
        let motion = (0..SAMPLES).map(|i| level * yielding * (step * i as f64).sin()).collect();
        let channel = |name: &str, unit, values, noise| Channel { name: name.into(), unit, values, noise };
        let channels = vec![
            channel("time", "s", (0..SAMPLES).map(|i| 2.5e-3 * i as f64).collect(), None),
            channel("displacement", "m", motion, None),
            channel("force", "N", vec![0.0; SAMPLES], None),
        ];
        let mut record =
            Record { name: level.to_string(), regime: Regime::FromRest, use_for: None, channels };
        let clean = predict(&truth, &record).unwrap()[0].values.clone();
        let size = (clean.iter().map(|f| f * f).sum::<f64>() / SAMPLES as f64).sqrt();
        let mut normal = || (0..12).map(|_| between(0.0, 1.0)).sum::<f64>() - 6.0;
        record.channels[2].values = clean.iter().map(|f| f + NOISE * size * normal()).collect();
        record.channels[2].noise = Some(NOISE * size);
        record
    };
    let records = [0.6, 1.2, 2.5, 3.5, 4.5, 5.0].map(&mut record).to_vec();
    (Model::parse(&text(1.1 * stiffness, 0.95 * friction)).unwrap(), Dataset { title: None, records })
}

/// Each alone leaves a residual so smooth and large that it passes for a slow noise as well as that of the model without.
#[test]
fn two_effects_are_found_of_which_neither_alone_looks_likelier_than_none() {
    let mut random = fastrand::Rng::with_seed(5);
    for case in 0..3 {
        let (model, dataset) = measured(&mut random);
        let (options, watch) = (DiagnoseOptions::default(), DiagnoseWatch::default());
        let found = diagnose(&model, &dataset, &options, watch).unwrap();
        let mut effects = found.effects.clone();
        effects.sort_unstable();
        assert_eq!(found.verdict, Verdict::EffectFound, "case {case}");
        assert_eq!(effects, ["micro_slip", "residual_stiffness"], "case {case}");
        let error = &found.error;
        assert!(error.refitted < error.baseline && error.last < 1.1 * NOISE, "case {case}: {error:?}");
    }
}

#[test]
fn where_fewer_than_are_missing_may_be_added_more_are_pointed_to() {
    let (model, dataset) = measured(&mut fastrand::Rng::with_seed(5));
    let options = DiagnoseOptions { max_effects: 1, ..DiagnoseOptions::default() };
    let found = diagnose(&model, &dataset, &options, DiagnoseWatch::default()).unwrap();
    assert_eq!(found.verdict, Verdict::Unexplained, "{:#?}", found.reasons);
    assert_eq!((found.surrogates.len(), found.may_lack_more_than(1)), (1, true));
    assert!(found.reasons.iter().any(|reason| reason.ends_with("(--max-effects 2)")), "{:#?}", found.reasons);
    // There is no second one to try.
    let options = DiagnoseOptions { effects: Some(vec!["micro_slip".into()]), ..options };
    let found = diagnose(&model, &dataset, &options, DiagnoseWatch::default()).unwrap();
    assert!(
        !found.may_lack_more_than(1) && found.reasons.iter().all(|reason| !reason.contains("--max-effects"))
    );
}
