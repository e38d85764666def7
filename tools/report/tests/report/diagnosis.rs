//! What page, text and JSON of a diagnosis promise, whatever was found.

use serde_json::Value;
use stickslip::diagnose::{
    Assumptions, Candidate, Cost, DiagnoseOptions, Diagnosis, Errors, Estimate, Untried, Verdict,
};
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
fn what_remains_beyond_the_noise_is_said_although_nothing_is_missing() {
    let floor = nothing().error.refitted;
    for (times, said) in [(1.0, false), (0.5, true)] {
        let error = Errors { noise_floor: Some(times * floor), ..nothing().error };
        let text = diagnosis_table(&Diagnosis { error, ..nothing() }, &run(), 400, false);
        assert_eq!(text.contains("more remains, too small to be taken for a missing effect"), said, "{text}");
    }
}

#[test]
fn fits_to_fewer_samples_are_said_before_the_next_step() {
    for (fitted_samples, said) in [(9600, false), (800, true)] {
        let cost = Cost { fitted_samples, ..found().cost };
        let diagnosis = Diagnosis { cost, ..found() };
        let text = diagnosis_table(&diagnosis, &run(), 400, false);
        assert_eq!(text.split("Next").next().unwrap().contains("weighed by 800 of 9600 samples"), said);
        assert_eq!(json(&diagnosis)["cost"]["fitted_samples"], fitted_samples);
    }
}

#[test]
fn commands_to_go_on_ask_what_was_asked() {
    let options = DiagnoseOptions {
        effects: Some(vec!["backlash".into(), "wear".into(), "asymmetry".into()]),
        max_effects: 3,
        assumptions: Assumptions::default().with("odds", 0.25).unwrap(),
    };
    let asked = Run { options, ..run() };
    let (two, pair) = (vec!["backlash", "wear"], found());
    let pair = Diagnosis { effects: two.clone(), candidates: Vec::new(), ..pair };
    let text = diagnosis_table(&pair, &asked, 400, false);
    let command = "stickslip diagnose model.toml data --effects backlash,wear,asymmetry --max-effects 3 --assume odds=0.25 -o NEW";
    assert!(text.contains(command), "{text}");
    // Where so many as may be tried do not explain all, more may.
    let candidate = |id: &'static str| Candidate { effects: vec![id], ..found().candidates[0].clone() };
    for (most, others, more) in [(2, true, true), (3, true, false), (2, false, false)] {
        let options = DiagnoseOptions { max_effects: most, ..run().options };
        let third = others.then_some("asymmetry");
        let candidates = two.iter().copied().chain(third).map(candidate).collect();
        let diagnosis = Diagnosis { surrogates: two.clone(), candidates, ..unexplained() };
        let text = diagnosis_table(&diagnosis, &Run { options, ..run() }, 400, false);
        assert_eq!(text.contains("`stickslip diagnose model.toml data --max-effects 3`"), more, "{text}");
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

/// The page as text, a cell of a table ended by a bar.
fn text(diagnosis: &Diagnosis) -> String {
    let page = diagnosis_html(diagnosis, &run(), &settings()).replace("</td>", "| ").replace("</th>", "| ");
    let parts = page.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| text);
    parts.collect::<String>()
}

/// What two sections say of the same thing is the same.
#[test]
fn sections_do_not_contradict_each_other() {
    let found = found();
    let unfitted = |effect| Candidate {
        effects: vec![effect],
        parameters: vec![],
        error: 0.39,
        gain_z: 0.0,
        gain_fraction: 0.0,
        evaluations: 0,
        ..found.candidates[0].clone()
    };
    let mut candidates = found.candidates.clone();
    candidates.push(unfitted("contact_damping"));
    let other = Untried { effect: "sensor_offset", reason: "not identifiable".into() };
    let text = text(&Diagnosis { candidates, untried: vec![other], ..found });
    // What was not fitted has no gain.
    assert!(text.contains("Contact damping| –| –| –| promises too little to be fitted| 0|"), "{text}");
    // What was tried at one place is not among what was not tried.
    assert!(text.contains("Sensor offset, at other places than above: not identifiable"), "{text}");
    // The error of the model as given on the test records, which the reasons tell, stands in the table, too.
    let given = text.split("model as given| ").nth(1).unwrap();
    let cells: Vec<&str> = given.split("| ").take(2).collect();
    assert!(cells.iter().all(|cell| cell.parse::<f64>().is_ok()), "{cells:?}");
}

#[test]
fn each_of_two_effects_has_its_own_parameters_as_they_are_in_the_end() {
    let found = found();
    let estimate =
        |name: &str, value: f64| Estimate { name: name.into(), value, ..found.parameters[0].clone() };
    let both = |values: [f64; 2]| Candidate {
        effects: vec!["residual_stiffness", "wear"],
        parameters: vec![estimate("residual_stiffness", values[0]), estimate("rate", values[1])],
        ..found.candidates[0].clone()
    };
    let third = Candidate { effects: vec!["residual_stiffness", "wear", "backlash"], ..both([9e5, 900.0]) };
    let text = text(&Diagnosis {
        effects: vec!["residual_stiffness", "wear"],
        rounds: vec![vec![both([3e5, 33.0])], vec![third]],
        ..found.clone()
    });
    let section = text.split("The effects").last().unwrap().split("Candidates").next().unwrap();
    let here: Vec<&str> = section.split("Here: ").skip(1).map(|one| one.split('.').next().unwrap()).collect();
    assert!(here[0].starts_with("residual stiffness = 300") && !here[0].contains("rate"), "{here:?}");
    assert!(here[1].starts_with("rate = 33") && !here[1].contains("stiffness"), "{here:?}");
    // In the first round they have the values of the end, and the row says so.
    assert!(text.contains("with all that was added: residual stiffness"), "{text}");
}

#[test]
fn an_error_below_the_estimated_noise_is_explained() {
    let error = |test| Diagnosis { error: Errors { test, ..found().error }, ..found() };
    let said =
        |diagnosis: &Diagnosis| diagnosis_table(diagnosis, &run(), 400, false).contains("it is smaller");
    assert!(said(&error(0.003)) && !said(&error(0.0103)));
}
