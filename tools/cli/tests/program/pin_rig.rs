//! What the program does with a beam whose pin slips and slaps, and what it says where it cannot.

use std::fs;

use tempfile::TempDir;

use crate::support::{error, read_json, stdout, stickslip};

/// The example with few modes and one slider, which take little time.
fn model() -> String {
    let example = include_str!("../../../../examples/slip-slap/model.toml");
    let plain = &example[..example.find("[[effect]]").unwrap()];
    plain.replace("modes = 20", "modes = 6")
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.toml"), model()).unwrap();
    folder
}

#[test]
fn its_modes_and_its_response_agree_on_the_first_bending_mode() {
    let folder = folder();
    // The pendulum and the mass that bounces on its string come first.
    let asked = ["modes", "model.toml", "--mode", "3", "--from", "1e-7", "--to", "1e-7", "--points", "1"];
    let files = ["--harmonics", "3", "--json", "mode.json"];
    let output = stickslip(&folder, &[&asked[..], &files[..]].concat());
    assert!(output.status.success(), "{}", error(&output));
    let mode = read_json(&folder, "mode.json")["points"][0]["frequency"].as_f64().unwrap();
    assert!((mode - 52.79).abs() < 0.1, "{mode}");
    let asked = ["frf", "model.toml", "--from", "52", "--to", "54", "--force", "1e-4", "--harmonics", "3"];
    let output = stickslip(&folder, &[&asked[..], &["--no-stability", "--json", "frf.json"]].concat());
    assert!(output.status.success(), "{}", error(&output));
    let peak = read_json(&folder, "frf.json")["peaks"][0]["frequency_hz"].as_f64();
    assert!((peak.unwrap() - mode).abs() < 0.02, "{peak:?} {mode}");
}

#[test]
fn what_it_cannot_do_with_such_a_model_is_said() {
    let folder = folder();
    let said = |arguments: &[&str], code: i32, words: &[&str]| {
        let output = stickslip(&folder, arguments);
        let text = format!("{}{}", error(&output), stdout(&output));
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
        for word in words {
            assert!(text.contains(word), "{arguments:?}: {text}");
        }
    };
    said(&["export", "model.toml", "-o", "rig.fmu"], 2, &["pin_rig", "no FMU"]);
    let asked = ["frf", "model.toml", "--from", "52", "--to", "54", "--excite", "m1"];
    said(&asked, 2, &["--excite names a mass of an oscillator"]);
    fs::create_dir(folder.path().join("data")).unwrap();
    let dataset = "schema = \"stickslip.dataset/1\"\n[[record]]\nfile = \"a.csv\"\nregime = \"from-rest\"\n";
    fs::write(folder.path().join("data/dataset.toml"), dataset).unwrap();
    let rows: String = (0..40)
        .map(|k| {
            let phase = f64::from(k) * 0.3;
            format!("{},{},{}\n", f64::from(k) * 1e-3, phase.sin(), phase.cos())
        })
        .collect();
    let csv = format!("time [s],excitation [N],acceleration:x=0.3 [m/s^2]\n{rows}");
    fs::write(folder.path().join("data/a.csv"), csv).unwrap();
    said(&["compare", "model.toml", "data"], 1, &["records of a pin rig are not predicted"]);
    said(&["identify", "model.toml", "data"], 2, &["the model's kind must be \"beam\""]);
}
