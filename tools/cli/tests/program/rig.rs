//! `stickslip rig`

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use stickslip::model::Model;
use tempfile::TempDir;

use crate::support::{entries, error, read_json, stdout, stickslip};

const PLAN: &str = r#"schema = "stickslip.rig/1"
title = "Three levels"
model = "model.toml"

[sensors]
noise = 0.01
noise_told = true
seed = 4

[[stepped_sine]]
name = "level"
amplitude = [20.0, 40.0, 70.0]
frequency = "resonance"

[[random]]
force = 0.1
band = [10.0, 200.0]
duration = 0.5
sampling = 4096.0
"#;

fn folder(plan: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let model = include_str!("../../../../examples/frictional-support/published.toml");
    fs::write(folder.path().join("model.toml"), model).unwrap();
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    folder
}

fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let inside = |path: PathBuf| match path.is_dir() {
        true => contents(&path),
        false => vec![(name(&path), fs::read(&path).unwrap())],
    };
    entries(folder).into_iter().flat_map(inside).collect()
}

#[test]
fn its_dataset_is_compared_with_the_model_and_only_noise_is_left() {
    let folder = folder(PLAN);
    let output = stickslip(&folder, &["rig", "plan.toml", "-o", "measured"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("level-3.csv") && table.contains("wrote measured with 4 records"), "{table}");
    let compared = ["compare", "model.toml", "measured", "--no-fit", "--json", "c.json"];
    let output = stickslip(&folder, &compared);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let json = read_json(&folder, "c.json").to_string();
    assert!(json.contains("level-1.csv"));
    let table = String::from_utf8_lossy(&output.stdout);
    for level in ["level-1.csv", "level-2.csv", "level-3.csv"] {
        let line = table.lines().find(|line| line.starts_with(level)).unwrap();
        let numbers: Vec<f64> = line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
        assert!(numbers[0] < 1.1 * numbers[1] && numbers[1] == 0.01, "{line}");
    }
}

#[test]
fn the_same_plan_writes_the_same_bytes_and_a_folder_with_files_is_left_alone() {
    let folder = folder(PLAN);
    fs::create_dir(folder.path().join("empty")).unwrap();
    for out in ["new", "empty"] {
        let output = stickslip(&folder, &["rig", "plan.toml", "-o", out]);
        assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    }
    let once = contents(&folder.path().join("new"));
    // Dataset and records; chain, model and contacts of the truth.
    assert_eq!(once.len(), 5 + 6);
    assert!(once == contents(&folder.path().join("empty")));
    let output = stickslip(&folder, &["rig", "plan.toml", "-o", "new"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("not empty"), "{}", error(&output));
    assert!(once == contents(&folder.path().join("new")));
    assert_eq!(entries(folder.path()).len(), 4, "something temporary is left");
}

#[test]
fn a_plan_that_cannot_be_carried_out_writes_nothing() {
    let refusals = [
        ("noise = 0.01", "nois = 0.01", vec!["plan.toml:6", "did you mean `noise`"]),
        ("200.0]", "3000.0]", vec!["plan.toml:15", "half the sampling"]),
        ("model.toml", "none.toml", vec!["plan.toml:3", "none.toml"]),
    ];
    for (from, to, hints) in refusals {
        let folder = folder(&PLAN.replace(from, to));
        let output = stickslip(&folder, &["rig", "plan.toml", "-o", "measured"]);
        let message = error(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(hints.iter().all(|hint| message.contains(hint)), "{message}");
        assert_eq!(entries(folder.path()).len(), 2);
    }
    let folder = folder(PLAN);
    let output = stickslip(&folder, &["rig", "plan.toml", "-o", "no/such/place"]);
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
}

#[test]
fn what_the_rig_knows_is_beside_the_dataset() {
    for (told, model) in [("", true), ("masses_told = false\n", false)] {
        let plan = PLAN
            .replace("seed = 4", &format!("seed = 4\nmass = [0.0, 0.01, 0.0]\ngain_scatter = 0.02\n{told}"));
        let folder = folder(&plan);
        let output = stickslip(&folder, &["rig", "plan.toml", "-o", "measured"]);
        assert_eq!(output.status.code(), Some(0), "{}", error(&output));
        let read = |name: &str| fs::read_to_string(folder.path().join("measured").join(name)).unwrap();
        // The model with the accelerometer's mass, to whoever may know it, and to whoever scores.
        let weighed = Model::parse(&read("truth/model.toml")).unwrap();
        let untouched = Model::parse(&fs::read_to_string(folder.path().join("model.toml")).unwrap()).unwrap();
        let at_the_middle = "beam.point_mass.2.mass";
        let added = weighed.get(at_the_middle).unwrap() - untouched.get(at_the_middle).unwrap();
        assert_eq!(weighed.get("beam.point_mass.2.position"), Some(0.3));
        assert!((added - 0.01).abs() < 1e-15, "{added}");
        assert_eq!(folder.path().join("measured/model.toml").is_file(), model);
        assert!(!model || Model::parse(&read("model.toml")).unwrap() == weighed);
        // Gains as drawn are those that were printed.
        let drawn: Vec<String> = read("truth/rig.toml")
            .lines()
            .filter_map(|line| line.strip_prefix("gain = "))
            .map(|gain| format!("{:.5}", gain.parse::<f64>().unwrap()))
            .collect();
        assert!(drawn.len() == 4 && stdout(&output).contains(&drawn.join(", ")), "{drawn:?}");
        // The contact as `identify` writes it.
        assert!(
            read("truth/level-2-contact.csv")
                .starts_with("time [s],displacement [m],velocity [m/s],force [N]\n")
        );
        assert_eq!(read("truth/random-contact.csv").lines().count(), read("random.csv").lines().count());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn it_ends_soon_when_it_is_interrupted_and_writes_nothing() {
    let tests = [
        PLAN.replace("duration = 0.5", "duration = 0.5\nlead = 1e5"),
        PLAN.replace("amplitude = [", "amplitude = [1.0, ")
            .replace("frequency = \"resonance\"", "from = 40\nto = 60\ncount = 10000"),
    ];
    for plan in tests {
        let folder = folder(&plan);
        let child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .current_dir(folder.path())
            .args(["rig", "plan.toml", "-o", "measured"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs(2));
        let begin = Instant::now();
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        // A tenth of a second; other tests may keep the processors busy.
        assert!(begin.elapsed() < Duration::from_secs(4), "{:?}", begin.elapsed());
        assert!(error(&output).contains("nothing was written"), "{}", error(&output));
        assert_eq!(entries(folder.path()).len(), 2);
    }
}
