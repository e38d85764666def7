//! The scorer on answers written by hand, and the runner on a program that always says the same.

use serde_json::{Value, json};
use stickslip_hidden_effects::scoring::score::{Diagnosis, score};
use stickslip_hidden_effects::scoring::truth::{Class, Truth};

fn truth(effect: &str) -> Truth {
    let entry = json!({
        "family": "contact", "effect": effect, "noise": 0.01,
        "parameters": {"backlash": {"half_gap": 2.3e-3}},
    });
    Truth::read(&entry).unwrap()
}

fn answer(verdict: &str, effects: &[&str], groups: Value) -> Diagnosis {
    let json = json!({
        "schema": "stickslip.diagnosis/1",
        "verdict": verdict,
        "effects": effects,
        "groups": groups,
        "error": {"baseline": 0.41, "refitted": 0.38, "final": 0.021, "untouched": 0.023, "noise_floor": 0.02},
        "candidates": [{"effect": "backlash", "error": 0.021, "gain_z": 41.0, "parameters":
            {"half_gap": {"value": 2.3e-3, "low": 2.2e-3, "high": 2.4e-3, "unit": "m"}}}],
        "detectable": {}, "next_experiment": null, "seconds": 1.9,
    });
    Diagnosis::read(&json).unwrap()
}

fn points(effect: &str, verdict: &str, effects: &[&str], groups: Value) -> f64 {
    score(&truth(effect), &answer(verdict, effects, groups)).right
}

#[test]
fn a_named_effect_counts_one_and_a_group_that_holds_it_half() {
    let group = json!([["backlash", "wear"]]);
    assert_eq!(points("backlash", "effect-found", &["backlash"], json!([])), 1.0);
    assert_eq!(points("backlash", "not-distinguishable", &[], group.clone()), 0.5);
    assert_eq!(points("backlash", "not-distinguishable", &["backlash"], group.clone()), 0.5);
    assert_eq!(points("stiffening", "not-distinguishable", &[], group), 0.0);
    assert_eq!(points("backlash", "effect-found", &["wear"], json!([])), 0.0);
    assert_eq!(points("backlash", "effect-found", &["backlash", "wear"], json!([])), 0.0);
    assert_eq!(points("backlash", "nothing-missing", &[], json!([])), 0.0);
    assert_eq!(points("backlash", "unexplained", &["backlash"], json!([])), 0.0);
}

#[test]
fn an_interval_counts_for_what_is_hidden_where_it_sits() {
    let candidate = |place: &str, low: f64| {
        json!({"effect": "added_mass", "location": place, "error": 0.02, "gain_z": 9.0, "parameters":
            {"mass": {"value": low + 0.1, "low": low, "high": low + 0.2, "unit": "kg"}}})
    };
    let said = json!({
        "schema": "stickslip.diagnosis/1", "verdict": "effect-found", "effects": ["added_mass"], "groups": [],
        "candidates": [candidate("m1", 0.9), candidate("m2", 3.0)],
    });
    let covered = |places: Value| {
        let truth = Truth::read(&json!({
            "family": "oscillator", "effect": "added_mass", "places": places,
            "parameters": {"added_mass": {"mass": 1.0}},
        }));
        score(&truth.unwrap(), &Diagnosis::read(&said).unwrap()).covered
    };
    let mass = |holds: bool| ("added_mass.mass".to_owned(), holds);
    assert_eq!(covered(json!({"added_mass": "m1"})), [mass(true)]);
    assert_eq!(covered(json!({"added_mass": "m2"})), [mass(false)]);
    assert_eq!(covered(json!({})), [mass(true), mass(false)]);
}

#[test]
fn an_effect_at_another_place_is_not_found() {
    let truth = json!({"family": "oscillator", "effect": "added_mass", "places": {"added_mass": "m1"}});
    let points = |place: &str| {
        let said = json!({
            "schema": "stickslip.diagnosis/1", "verdict": "effect-found", "effects": ["added_mass"], "groups": [],
            "places": {"added_mass": place},
        });
        score(&Truth::read(&truth).unwrap(), &Diagnosis::read(&said).unwrap()).right
    };
    assert_eq!((points("m1"), points("m2")), (1.0, 0.0));
}

#[test]
fn a_pair_counts_when_both_are_named_in_any_order() {
    let pair = "wear+backlash";
    assert_eq!(truth(pair).class(), Class::Pair);
    assert_eq!(points(pair, "effect-found", &["backlash", "wear"], json!([])), 1.0);
    assert_eq!(points(pair, "effect-found", &["wear", "backlash"], json!([])), 1.0);
    assert_eq!(points(pair, "effect-found", &["backlash"], json!([])), 0.0);
    let group = json!([["wear", "asymmetry"]]);
    assert_eq!(points(pair, "not-distinguishable", &["backlash"], group.clone()), 0.5);
    assert_eq!(points(pair, "not-distinguishable", &["backlash", "stiffening"], group), 0.0);
    assert_eq!(points(pair, "not-distinguishable", &[], json!([["wear", "x"], ["backlash", "y"]])), 0.5);
    assert_eq!(
        points(pair, "not-distinguishable", &[], json!([["wear", "x"], ["backlash", "y"], ["z", "a"]])),
        0.0
    );
}

#[test]
fn naming_anything_where_nothing_of_the_catalogue_is_hidden_is_a_false_alarm() {
    for effect in ["none", "unknown:position_dependent_friction"] {
        let judge =
            |verdict, effects: &[&str], groups| score(&truth(effect), &answer(verdict, effects, groups));
        assert!(judge("effect-found", &["backlash"], json!([])).named_falsely);
        assert!(judge("not-distinguishable", &[], json!([["backlash", "wear"]])).named_falsely);
        for verdict in ["nothing-missing", "unexplained", "insufficient-data"] {
            assert!(!judge(verdict, &[], json!([])).named_falsely);
        }
        // Surrogates are listed, but not sold.
        assert!(!judge("unexplained", &["backlash"], json!([])).named_falsely);
    }
    assert_eq!(points("none", "nothing-missing", &[], json!([])), 1.0);
    assert_eq!(points("unknown:x", "unexplained", &[], json!([])), 1.0);
    assert_eq!(points("unknown:x", "nothing-missing", &[], json!([])), 0.0);
}

#[test]
fn a_weaker_word_counts_as_what_it_claims() {
    let group = json!([["backlash", "wear"]]);
    assert_eq!(points("backlash", "effect-likely", &["backlash"], json!([])), 1.0);
    assert_eq!(points("backlash", "effect-likely", &["wear"], json!([])), 0.0);
    assert_eq!(points("backlash", "perhaps-one-of-these", &[], group), 0.5);
    assert_eq!(points("none", "probably-nothing-missing", &[], json!([])), 1.0);
    assert_eq!(points("unknown:x", "probably-unexplained", &[], json!([])), 1.0);
    assert_eq!(points("none", "no-idea", &[], json!([])), 0.0);
    let named = score(&truth("none"), &answer("effect-likely", &["backlash"], json!([])));
    assert!(named.named_falsely);
}

#[test]
fn a_fault_of_the_measurement_may_be_named() {
    let entry = json!({"family": "contact", "effect": "unknown:hum", "faults": ["mains_hum", "hum"]});
    let judge = |verdict, effects: &[&str]| {
        let score = score(&Truth::read(&entry).unwrap(), &answer(verdict, effects, json!([])));
        (score.right, score.named_falsely)
    };
    assert_eq!(judge("unexplained", &[]), (1.0, false));
    assert_eq!(judge("effect-found", &["hum"]), (1.0, false));
    assert_eq!(judge("effect-found", &["hum", "wear"]), (0.0, true));
    assert_eq!(judge("effect-found", &["wear"]), (0.0, true));
    assert_eq!(judge("nothing-missing", &[]), (0.0, false));
}

#[test]
fn the_law_is_that_of_what_was_found() {
    let law = |effects: Value| {
        let said = json!({
            "schema": "stickslip.diagnosis/1", "verdict": "effect-found", "effects": effects, "groups": [],
            "candidates": [{"effect": "wear"}, {"effect": "micro_slip", "law": "dahl"}],
        });
        Diagnosis::read(&said).unwrap().law
    };
    assert_eq!(law(json!(["micro_slip"])).as_deref(), Some("dahl"));
    assert_eq!(law(json!(["wear"])), None);
    let said = json!({"schema": "stickslip.diagnosis/1", "verdict": "effect-found", "law": "valanis"});
    assert_eq!(Diagnosis::read(&said).unwrap().law.as_deref(), Some("valanis"));
}

#[test]
fn intervals_and_errors_are_judged_where_the_verdict_is_right() {
    let right = score(&truth("backlash"), &answer("effect-found", &["backlash"], json!([])));
    let gap = |holds: bool| ("backlash.half_gap".to_owned(), holds);
    assert_eq!(right.covered, [gap(true)]);
    assert!((right.test_error_over_noise.unwrap() - 2.3).abs() < 1e-12);
    let mut elsewhere = truth("backlash");
    elsewhere.parameters.get_mut("backlash").unwrap().insert("half_gap".to_owned(), 2.5e-3);
    assert_eq!(score(&elsewhere, &answer("effect-found", &["backlash"], json!([]))).covered, [gap(false)]);
    let wrong = score(&truth("wear"), &answer("effect-found", &["backlash"], json!([])));
    assert_eq!((wrong.covered, wrong.test_error_over_noise), (Vec::new(), None));
}

#[test]
fn truths_are_read_as_their_authors_write_them() {
    for entry in [
        json!({"family": "beam", "effect": "wear+backlash", "noise": 0.1}),
        json!({"family": "beam", "effect": "backlash, wear", "noise": 0.1}),
        json!({"family": "beam", "effect": ["wear", "backlash"], "noise": 0.1}),
        json!({"family": "beam", "effects": ["wear", "backlash"], "noise": 0.1}),
    ] {
        assert_eq!(Truth::read(&entry).unwrap().effects, ["backlash", "wear"]);
    }
    assert_eq!(Truth::read(&json!({"family": "beam", "effect": "none"})).unwrap().class(), Class::Null);
    let moving = |entry: Value| Truth::read(&entry).unwrap().moving;
    assert!(moving(json!({"family": "contact", "effect": "none", "moving": true})));
    assert!(!moving(json!({"family": "contact", "effect": "none"})));
    assert!(Truth::read(&json!({"family": "beam"})).is_err());
    assert!(Diagnosis::read(&json!({"schema": "other/1", "verdict": "unexplained"})).is_err());
}

#[cfg(unix)]
mod runs {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::path::{Path, PathBuf};
    use std::time::Duration;

    use stickslip_hidden_effects::scoring::run::{Outcome, Plan, Task, run};
    use stickslip_hidden_effects::scoring::table;

    use super::truth;

    /// A program that finds backlash everywhere and counts its runs; it breaks down on a folder called `bad`.
    fn program(folder: &Path) -> PathBuf {
        let path = folder.join("program");
        let script = r#"#!/bin/sh
echo run >> "$(dirname "$0")/runs"
case "$2" in bad/*) exit 2;; esac
cat > "$5" <<'END'
{"schema": "stickslip.diagnosis/1", "verdict": "effect-found", "effects": ["backlash"], "seconds": 0.5, "probability": 0.97,
 "candidates": [{"effect": "backlash", "parameters": {"half_gap": {"low": 2.2e-3, "high": 2.4e-3}}}]}
END
exit 10
"#;
        fs::write(&path, script).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    fn tasks() -> Vec<Task> {
        ["backlash", "none", "wear", "bad"]
            .map(|name| Task {
                name: name.to_owned(),
                truth: truth(if name == "bad" { "backlash" } else { name }),
                folder: Box::new(move || Ok(PathBuf::from(name))),
            })
            .into()
    }

    fn go(folder: &Path, fresh: bool) -> (Vec<Outcome>, usize) {
        let plan = Plan {
            program: folder.join("program"),
            results: folder.join("results"),
            jobs: 2,
            fresh,
            resume: false,
            assume: None,
            max_effects: None,
            longest: Duration::from_secs(20),
        };
        let outcomes = run(&plan, &tasks()).unwrap();
        (outcomes, fs::read_to_string(folder.join("runs")).unwrap().lines().count())
    }

    #[test]
    fn what_is_finished_is_not_run_again() {
        let folder = tempfile::tempdir().unwrap();
        program(folder.path());
        let (outcomes, runs) = go(folder.path(), false);
        let points: Vec<f64> = outcomes.iter().map(|outcome| outcome.score.right).collect();
        assert_eq!((points, runs), (vec![1.0, 0.0, 0.0, 0.0], 4));
        assert_eq!(outcomes[3].diagnosis.verdict, "failed");
        // Only the one that broke down runs again; all of them when asked; all with another build.
        assert_eq!(go(folder.path(), false).1, 5);
        assert_eq!(go(folder.path(), true).1, 9);
        let changed = fs::read_to_string(folder.path().join("program")).unwrap() + "# another build\n";
        fs::write(folder.path().join("program"), changed).unwrap();
        assert_eq!(go(folder.path(), false).1, 13);
    }

    #[test]
    fn the_page_counts_probabilities_intervals_and_exit_codes() {
        let folder = tempfile::tempdir().unwrap();
        program(folder.path());
        let first = go(folder.path(), false).0;
        for outcomes in [first, go(folder.path(), false).0] {
            let page = table::markdown(&outcomes, "command", "machine");
            for part in [
                "probability of at least 0.95: 33.3 % (1 of 3; 6.1 … 79.2 %) true",
                "| 0.95 … 0.99 | 0.9700 | 33.3 % (1 of 3; 6.1 … 79.2 %) |",
                "| backlash.half_gap | 100.0 % (1 of 1; 20.7 … 100.0 %) |",
                "| 1 % | 100.0 % (1 of 1; 20.7 … 100.0 %) |",
                "| 2 | failed | 1 |\n| 10 | effect-found | 3 |",
            ] {
                assert!(page.contains(part), "{part}\n{page}");
            }
        }
    }

    #[test]
    fn what_later_cases_ask_has_a_section() {
        let folder = tempfile::tempdir().unwrap();
        program(folder.path());
        let mut outcomes = go(folder.path(), false).0;
        assert!(!table::markdown(&outcomes, "command", "machine").contains("## Later kinds"));
        for outcome in &mut outcomes[..2] {
            outcome.truth.question = Some("ramped".to_owned());
        }
        let page = table::markdown(&outcomes, "command", "machine");
        let row = "| noise visible in cycles inside ramped records alone | 50.0 % (1 of 2; 9.5 … 90.5 %) | 100.0 % (1 of 1; ";
        assert!(page.contains(row), "{page}");
        // The first cases are told apart from them.
        assert!(page.contains("| first cases | 0 % of 2 |"), "{page}");
        let row = "| single effects named correctly | 0.0 % (0 of 2; 0.0 … 65.8 %) | 33.3 % (1 of 3; ";
        assert!(page.contains(row), "{page}");
    }

    #[test]
    fn the_table_gives_fractions_with_intervals_and_every_error() {
        let folder = tempfile::tempdir().unwrap();
        program(folder.path());
        let page = table::markdown(&go(folder.path(), false).0, "command", "machine");
        for part in [
            "| single effects named correctly | 33.3 % (1 of 3; 6.1 … 79.2 %) |",
            "| false alarms on null cases | 100.0 % (1 of 1; 20.7 … 100.0 %) |",
            "| wear | 1 | backlash × 1 |",
            "| bad | (failed) |",
        ] {
            assert!(page.contains(part), "{part}\n{page}");
        }
    }
}
