//! `diagnose`, `add` and `effects` as a user calls them, and what they say when the input is wrong.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use stickslip::model::Model;
use tempfile::TempDir;

use crate::support::{error, read_json, stickslip};

const MODEL: &str = r#"schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "jenkins"
tangential_stiffness = 2.4e6
friction_coefficient = 0.5
normal_load = 100.0
"#;

/// Six records from rest at several levels, of a slider with a spring of `beside` (N/m) next to it.
fn example(beside: f64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.toml"), MODEL).unwrap();
    fs::create_dir(folder.path().join("data")).unwrap();
    let mut dataset = "schema = \"stickslip.dataset/1\"\n".to_owned();
    for (record, size) in [20e-6, 30e-6, 40e-6, 50e-6, 60e-6, 80e-6].into_iter().enumerate() {
        write!(dataset, "\n[[record]]\nfile = \"r{record}.csv\"\nregime = \"from-rest\"\n").unwrap();
        fs::write(folder.path().join(format!("data/r{record}.csv")), table(record as u64, size, beside))
            .unwrap();
    }
    fs::write(folder.path().join("data/dataset.toml"), dataset).unwrap();
    folder
}

/// Jenkins' element stepped by hand, with noise of 0.3 N.
fn table(seed: u64, size: f64, beside: f64) -> String {
    // A fork, since the numbers of neighbouring seeds resemble each other.
    let mut numbers = fastrand::Rng::with_seed(seed).fork();
    let mut uniform = || 2.0 * numbers.f64() - 1.0;
    let (mut slider, mut text) = (0.0_f64, "time [s],displacement [m],force [N]\n".to_owned());
    for index in 0..600 {
        let time = f64::from(index) * 0.005;
        let u = size * (std::f64::consts::TAU * time).sin();
        let sliding = (2.5e6 * (u - slider)).clamp(-48.0, 48.0);
        slider = u - sliding / 2.5e6;
        let noise = 0.3 * (uniform() + uniform() + uniform());
        writeln!(text, "{time},{u:e},{:e}", sliding + beside * u + noise).unwrap();
    }
    text
}

#[test]
fn a_missing_spring_is_found_added_and_the_error_falls() {
    let folder = example(4e5);
    let path = folder.path();
    let found = stickslip(
        path,
        &[
            "diagnose",
            "model.toml",
            "data",
            "--effects",
            "residual_stiffness,backlash,sensor_offset",
            "--json",
            "d.json",
            "--report",
            "d.html",
            "-o",
            "found.toml",
        ],
    );
    assert_eq!(found.status.code(), Some(10), "{}", error(&found));
    let diagnosis = read_json(path, "d.json");
    assert_eq!(diagnosis["schema"], "stickslip.diagnosis/1");
    assert_eq!(diagnosis["effects"], serde_json::json!(["residual_stiffness"]));
    assert_eq!(diagnosis["model_written"], "found.toml");
    assert!(fs::read_to_string(path.join("d.html")).unwrap().contains("Residual stiffness is missing"));
    // The engineer adds it by hand, and compares again.
    let added = stickslip(
        path,
        &["add", "model.toml", "residual_stiffness", "--fit", "data", "-o", "new.toml", "--json", "a.json"],
    );
    assert_eq!(added.status.code(), Some(0), "{}", error(&added));
    let added = read_json(path, "a.json");
    assert_eq!(added["effect"], "residual_stiffness");
    let compared = stickslip(path, &["compare", "new.toml", "data", "--no-fit", "--json", "c.json"]);
    assert_eq!(compared.status.code(), Some(0), "{}", error(&compared));
    let after = read_json(path, "c.json")["error"]["baseline"].as_f64().unwrap();
    let before = diagnosis["error"]["refitted"].as_f64().unwrap();
    assert!(after < 0.3 * before, "{before} → {after}");
    let text = fs::read_to_string(path.join("new.toml")).unwrap();
    assert!(text.contains("id = \"residual_stiffness\""), "{text}");
}

/// What `diagnose` tells of `folder` with so many threads, without what it took.
fn told_with(folder: &Path, threads: &str) -> serde_json::Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.current_dir(folder).env("RAYON_NUM_THREADS", threads);
    let output = command.args(["diagnose", "model.toml", "data", "--json", "d.json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(10), "{}", error(&output));
    let mut told = read_json(folder, "d.json");
    told["seconds"].take();
    for rate in ["refits_per_second", "seconds_per_refit"] {
        told["cost"][rate].take();
    }
    told
}

#[test]
fn a_diagnosis_is_the_same_to_the_last_bit_however_many_threads_work_on_it() {
    let folder = example(4e5);
    let one = told_with(folder.path(), "1");
    for threads in ["2", "3"] {
        let several = told_with(folder.path(), threads);
        for (name, value) in one.as_object().unwrap() {
            assert_eq!(value, &several[name], "{name} with {threads} threads");
        }
    }
}

#[test]
fn wrong_input_is_named_and_nothing_is_written() {
    let folder = example(0.0);
    let cases: [(&[&str], &str); 7] = [
        (
            &["diagnose", "model.toml", "data", "--effects", "backlsh", "--json", "x"],
            "did you mean `backlash`",
        ),
        (&["diagnose", "model.toml", "nowhere", "--json", "x"], "nowhere"),
        (&["add", "model.toml", "backlash", "--fit", "data"], "--out"),
        (&["add", "model.toml", "wer", "--fit", "data", "-o", "x"], "did you mean `wear`"),
        (&["add", "model.toml", "backlash@m2", "--fit", "data", "-o", "x"], "needs no place"),
        (&["add", "model.toml", "sensor_offset", "--fit", "data", "-o", "x"], "sensor_offset@force"),
        (&["add", "model.toml", "added_mass@m2", "--fit", "data", "-o", "x"], "kind \"contact\""),
    ];
    for (arguments, said) in cases {
        let output = stickslip(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(error(&output).contains(said), "{arguments:?}: {}", error(&output));
        assert!(!folder.path().join("x").exists(), "{arguments:?}");
    }
    let unknown = stickslip(folder.path(), &["effects", "magic"]);
    assert_eq!(unknown.status.code(), Some(2));
}

#[test]
fn the_catalogue_prints_every_effect() {
    let folder = tempfile::tempdir().unwrap();
    let list = String::from_utf8(stickslip(folder.path(), &["effects"]).stdout).unwrap();
    for effect in stickslip::effects::CATALOGUE {
        assert!(list.contains(&format!("{}: {}", effect.id, effect.title)), "{}", effect.id);
        let one = String::from_utf8(stickslip(folder.path(), &["effects", effect.id]).stdout).unwrap();
        assert!(effect.parameters.iter().all(|parameter| one.contains(parameter.quantity.name)), "{one}");
        assert!(one.contains("How to confirm it") && one.lines().all(|line| line.chars().count() <= 80));
    }
}

#[test]
fn what_is_taken_for_granted_can_be_said_and_is_told() {
    let folder = example(4e5);
    let diagnosed = |assumed: &[&str]| {
        let base = ["diagnose", "model.toml", "data", "--effects", "residual_stiffness", "--json", "d.json"];
        stickslip(folder.path(), &[&base[..], assumed].concat())
    };
    assert_eq!(diagnosed(&[]).status.code(), Some(10));
    let usual = read_json(folder.path(), "d.json")["settings"]["assumptions"]["odds"].as_f64();
    assert_eq!(usual, Some(0.5));
    // Who takes an effect for nearly impossible is told that none is certain; who thinks nothing of ten per cent, that
    // none is missing.
    let unlikely = diagnosed(&["--assume", "odds=1e-300", "--assume", "relevant=0.5"]);
    assert_eq!(unlikely.status.code(), Some(0));
    assert_eq!(read_json(folder.path(), "d.json")["settings"]["assumptions"]["odds"], 1e-300);
    for (wrong, hint) in [("patience=1", "certain"), ("odds=-1", "positive"), ("odds", "NAME=VALUE")] {
        let refused = diagnosed(&["--assume", wrong]);
        assert_eq!(refused.status.code(), Some(2), "{wrong}");
        assert!(error(&refused).contains(hint), "{}", error(&refused));
    }
}

#[test]
fn an_effect_fitted_to_free_decays_predicts_the_stepped_sine() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/free-decay-and-sweep");
    let [model, decays, sweeps] = ["model.toml", "decays", "sweeps"].map(|name| format!("{example}/{name}"));
    let folder = tempfile::tempdir().unwrap();
    let add = ["add", &model, "quadratic_damping", "--fit", &decays, "-o", "new.toml", "--json", "a.json"];
    let output = stickslip(folder.path(), &add);
    assert!(output.status.success(), "{}", error(&output));
    let new = Model::parse(&fs::read_to_string(folder.path().join("new.toml")).unwrap()).unwrap();
    for (path, truth, bound) in [
        ("effect.1.quadratic_damping", 4.0, 0.1),
        ("spring.1.damping", 2.0, 0.05),
        ("contact.tangential_stiffness", 4e3, 0.02),
        ("contact.friction_coefficient", 0.1, 0.03),
    ] {
        let found = new.get(path).unwrap();
        assert!((found / truth - 1.0).abs() < bound, "{path}: {found}");
    }
    for (model, error) in [("new.toml", 0.05), (&model, 10.0)] {
        let output = stickslip(folder.path(), &["compare", model, &sweeps, "--no-fit", "--json", "c.json"]);
        assert!(output.status.success());
        let found = read_json(&folder, "c.json")["stages"][0]["error"].as_f64().unwrap();
        println!("{model}: {found}");
        assert!(found < error && (error < 1.0 || found > 0.3), "{model}: {found}");
    }
}
