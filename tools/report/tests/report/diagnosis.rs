//! What page, text and JSON of a diagnosis promise, whatever was found.

use serde_json::Value;
use stickslip::diagnose::{Cost, Diagnosis, Verdict};
use stickslip_report::diagnosis::{Run, diagnosis_html, diagnosis_json, diagnosis_table};

use crate::synthetic::diagnosis::{found, group, insufficient, large, nothing, run, unexplained};
use crate::synthetic::settings;

fn all() -> Vec<Diagnosis> {
    vec![found(), group(), unexplained(), nothing(), insufficient()]
}

fn json(diagnosis: &Diagnosis) -> Value {
    diagnosis_json(diagnosis, &run())
}

fn is_number_or_null(value: &Value) -> bool {
    value.is_number() || value.is_null()
}

#[test]
fn json_has_the_keys_of_the_schema_with_their_types() {
    for diagnosis in all() {
        let json = json(&diagnosis);
        assert_eq!(json["schema"], "stickslip.diagnosis/1");
        assert_eq!(json["verdict"], diagnosis.verdict.id());
        assert!(json["effects"].as_array().unwrap().iter().all(Value::is_string));
        let groups = json["groups"].as_array().unwrap();
        assert!(groups.iter().all(|group| group.as_array().unwrap().iter().all(Value::is_string)));
        for key in ["baseline", "refitted", "final", "untouched", "noise_floor"] {
            assert!(is_number_or_null(json["error"].get(key).unwrap()), "{key}");
        }
        for candidate in json["candidates"].as_array().unwrap() {
            assert!(candidate["effect"].is_string());
            assert!(is_number_or_null(&candidate["error"]) && is_number_or_null(&candidate["gain_z"]));
            for parameter in candidate["parameters"].as_object().unwrap().values() {
                assert!(
                    ["value", "low", "high"].iter().all(|key| is_number_or_null(parameter.get(key).unwrap()))
                );
                assert!(parameter["unit"].is_string());
            }
        }
        for one in json["detectable"].as_object().unwrap().values() {
            assert!(
                one["parameter"].is_string() && is_number_or_null(&one["value"]) && one["unit"].is_string()
            );
        }
        assert!(json["next_experiment"].is_string() || json["next_experiment"].is_null());
        assert_eq!(json["seconds"], 1.9);
        assert!(!json.to_string().contains("NaN"));
    }
}

#[test]
fn names_are_withheld_unless_an_effect_is_significant() {
    for diagnosis in all() {
        // Even if something put names there.
        let named = Diagnosis { effects: vec!["wear"], ..diagnosis };
        let effects = json(&named)["effects"].as_array().unwrap().len();
        // Beside effects that cannot be distinguished there may be one that is certain.
        let certain = matches!(named.verdict, Verdict::EffectFound | Verdict::NotDistinguishable);
        assert_eq!(effects, usize::from(certain), "{:?}", named.verdict);
    }
    assert_eq!(json(&group())["groups"], serde_json::json!([["asymmetry", "sensor_offset"]]));
    assert!(json(&group())["next_experiment"].as_str().unwrap().contains("from rest"));
    assert_eq!(json(&unexplained())["surrogates"], serde_json::json!(["residual_stiffness"]));
}

#[test]
fn every_verdict_is_said_first_and_with_a_next_step() {
    let said = [
        ("Effect found", "Residual stiffness is missing"),
        ("Not distinguishable", "Asymmetric limit or Sensor offset"),
        ("Unexplained", "effects that were tried explains"),
        ("Nothing is missing", "These data show no missing effect"),
        ("Insufficient data", "too few data to decide"),
    ];
    for (diagnosis, (badge, sentence)) in all().iter().zip(said) {
        let text = diagnosis_table(diagnosis, &run(), 400, false);
        assert!(text.starts_with(badge) && text.contains(sentence), "{text}");
        let page = diagnosis_html(diagnosis, &run(), &settings());
        let (verdict, next) = (page.find(sentence).unwrap(), page.find("id=\"error\"").unwrap());
        assert!(verdict < next, "{badge}");
    }
}

#[test]
fn fits_to_fewer_samples_are_said_before_the_next_step() {
    for (fitted_samples, said) in [(9600, false), (800, true)] {
        let cost = Cost { fitted_samples, ..found().cost };
        let diagnosis = Diagnosis { cost, ..found() };
        let text = diagnosis_table(&diagnosis, &run(), 400, false);
        assert_eq!(text.split("Next").next().unwrap().contains("Fitted to 800 of 9600 samples"), said);
        assert_eq!(json(&diagnosis)["cost"]["fitted_samples"], fitted_samples);
    }
}

#[test]
fn an_unknown_noise_is_never_passed_over() {
    for diagnosis in [unexplained(), Diagnosis { error: unexplained().error, ..nothing() }] {
        let text = diagnosis_table(&diagnosis, &run(), 400, false);
        assert!(text.contains("noise is unknown"), "{text}");
        assert!(json(&diagnosis)["error"]["noise_floor"].is_null());
    }
}

#[test]
fn the_text_keeps_its_width() {
    for diagnosis in all() {
        for width in [40, 80] {
            let text = diagnosis_table(&diagnosis, &run(), width, false);
            for line in text.lines() {
                assert!(line.chars().count() <= width, "{width}: {line}");
            }
        }
    }
}

#[test]
fn pages_are_whole_fetch_nothing_and_stay_small() {
    for diagnosis in all().into_iter().chain([large()]) {
        let page = diagnosis_html(&diagnosis, &run(), &settings());
        assert!(page.contains("default-src 'none'"));
        assert!(!page.contains("<link") && !page.contains("<iframe") && !page.contains("<img"));
        assert!(!page.contains("<script src"), "no script from elsewhere");
        assert!(page.len() < 3_000_000, "{} bytes", page.len());
        for section in ["id=\"next\"", "id=\"error\"", "id=\"why\"", "id=\"where\"", "id=\"settings\""] {
            let next = section == "id=\"next\"" && diagnosis.verdict == Verdict::InsufficientData;
            assert!(next || page.contains(section), "{section} of {:?}", diagnosis.verdict);
        }
        let slower = Run { seconds: 7.0 * run().seconds, ..run() };
        assert_eq!(page, diagnosis_html(&diagnosis, &slower, &settings()), "same input, same bytes");
    }
}

#[test]
fn the_residual_is_shown_where_no_effect_explains_it() {
    let shown = |diagnosis: &Diagnosis| {
        diagnosis_html(diagnosis, &run(), &settings()).contains("Against displacement: ")
    };
    assert!(shown(&unexplained()) && !shown(&found()));
}

#[test]
fn an_interrupted_diagnosis_says_so() {
    let run = Run { interrupted: true, ..run() };
    assert!(diagnosis_table(&found(), &run, 80, false).contains("Interrupted"));
    assert!(diagnosis_html(&found(), &run, &settings()).contains("Interrupted"));
    assert_eq!(diagnosis_json(&found(), &run)["interrupted"], true);
}
