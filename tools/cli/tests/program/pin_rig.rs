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
fn it_makes_an_fmu() {
    let folder = folder();
    let output = stickslip(&folder, &["export", "model.toml", "-o", "rig.fmu"]);
    assert!(output.status.success(), "{}", error(&output));
    assert!(fs::read(folder.path().join("rig.fmu")).unwrap().starts_with(b"PK"));
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
    said(&["compare", "model.toml", "data"], 1, &["needs the regime `steady`"]);
    said(&["identify", "model.toml", "data"], 2, &["steady"]);
    said(&["identify", "model.toml", "data", "-o", "new.toml"], 2, &["--out", "two directions"]);
    said(&["identify", "model.toml", "data", "--fit", "a"], 2, &["--fit", "two directions"]);
}

#[test]
fn frequencies_tell_the_tangential_stiffness_and_hardly_the_normal_one() {
    let folder = folder();
    fs::write(folder.path().join("rig.toml"), model().replace("modes = 6", "modes = 20")).unwrap();
    // Those of the published rig with 3.95 and 23.7 MN/m.
    let asked = ["identify", "rig.toml", "--frequencies", "52.787,164.42,335.86"];
    let output =
        stickslip(&folder, &[&asked[..], &["--frequency-error", "5e-4", "--json", "k.json"]].concat());
    assert!(output.status.success(), "{}", error(&output));
    assert!(stdout(&output).contains("do not tell: normal stiffness k_n"), "{}", stdout(&output));
    let json = read_json(&folder, "k.json");
    assert_eq!(json["schema"], "stickslip.stiffness/1");
    let number = |name: &str| {
        let all = json["parameters"].as_array().unwrap();
        all.iter().find(|one| one["name"] == name).unwrap().clone()
    };
    let tangential = number("tangential_stiffness");
    let [low, high] = ["low", "high"].map(|end| tangential[end].as_f64().unwrap());
    assert!(3.5e6 < low && low < 3.95e6 && 3.95e6 < high && high < 4.4e6, "{tangential}");
    assert!(number("normal_stiffness")["high"].is_null() && json["fits"] == true, "{json}");
    assert_eq!((&tangential["told"], &number("normal_stiffness")["told"]), (&true.into(), &false.into()));
}

#[test]
fn what_frequencies_cannot_give_is_refused() {
    let folder = folder();
    let refused = |arguments: &[&str], word: &str| {
        let output = stickslip(&folder, &[&["identify", "model.toml"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", error(&output));
        assert!(error(&output).contains(word), "{arguments:?}: {}", error(&output));
    };
    let of = |more: &[&str], word: &str| {
        refused(&[&["--frequencies", "52.8,164.4,335.9"], more].concat(), word);
    };
    refused(&["--frequencies", "52.8,164.4"], "three positive frequencies");
    refused(&["--frequencies", "52.8,164.4,-3"], "--frequencies");
    refused(&["--frequencies", "335.9,164.4,52.8"], "do not rise");
    of(&["-o", "new.toml"], "--out");
    of(&["--sensor-gain", "0.5"], "--sensor-gain");
    of(&["--regime", "steady"], "--regime");
    of(&["--frequency-error", "0"], "--frequency-error");
    refused(&["data", "--frequencies", "52.8,164.4,335.9"], "cannot be used with");
    refused(&["data", "--frequency-error", "1e-3"], "cannot be used with");
    refused(&[], "DATASET");
    // A second frequency 3 % too high.
    let output = stickslip(&folder, &["identify", "model.toml", "--frequencies", "52.787,169,335.86"]);
    assert_eq!(output.status.code(), Some(1), "{}", stdout(&output));
    assert!(error(&output).contains("no stiffness of the contact"), "{}", error(&output));
}

const PLAN: &str = r#"schema = "stickslip.rig/1"
model = "model.toml"

[sensors]
positions = [0.55, 0.3, 0.05]

[[dual_mode]]
name = "level"
first = [14.0, 20.0]
third = [34.0, 50.0]
frequency = 52.0
periods = 2
"#;

/// Column `name` of a table.
fn column(table: &str, name: &str) -> Vec<f64> {
    let place = table.lines().next().unwrap().split(',').position(|head| head == name).expect(name);
    table.lines().skip(1).map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

/// Root mean square of the difference over that of the truth, means left out.
fn error_of(found: &[f64], truth: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (there, here) = (mean(truth), mean(found));
    let off: f64 = found.iter().zip(truth).map(|(x, y)| ((x - here) - (y - there)).powi(2)).sum();
    (off / truth.iter().map(|y| (y - there).powi(2)).sum::<f64>()).sqrt()
}

#[test]
fn both_forces_are_identified_from_what_the_rig_writes() {
    let folder = tempfile::tempdir().unwrap();
    // With its many sliders.
    let model = include_str!("../../../../examples/slip-slap/model.toml");
    fs::write(folder.path().join("model.toml"), model).unwrap();
    fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    let output = stickslip(&folder, &["rig", "plan.toml", "-o", "measured"]);
    assert!(output.status.success(), "{}", error(&output));
    let asked = ["identify", "model.toml", "measured", "--sensor-gain", "0", "--excitation-gain", "0"];
    let files = ["--csv", "contact", "--json", "found.json", "--report", "found.html"];
    let output = stickslip(&folder, &[&asked[..], &files].concat());
    assert!(output.status.success(), "{}", error(&output));
    // What is an echo of assumptions is no column, and is named.
    assert!(error(&output).contains("leave out `normal_displacement [m]`"), "{}", error(&output));
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let table = read("contact/level-2-contact.csv");
    assert!(table.starts_with("time [s],displacement [m],velocity [m/s],force [N],normal_force [N]\n"));
    let truth = read("measured/truth/level-2-contact.csv");
    // The truth has 256 samples a period, the table 512.
    for (name, known, most) in [
        ("force [N]", "force [N]", 0.05),
        ("normal_force [N]", "normal_load [N]", 0.03),
        ("displacement [m]", "displacement [m]", 0.02),
    ] {
        let found: Vec<f64> = column(&table, name).into_iter().step_by(2).collect();
        let off = error_of(&found, &column(&truth, known)[..found.len()]);
        assert!(off < most, "{name}: {off}");
    }
    let json = read_json(&folder, "found.json");
    assert_eq!(json["schema"], "stickslip.identification/1");
    assert_eq!(
        (&json["records"][1]["file"], &json["method"]),
        (&"level-2.csv".into(), &"receptance-inversion".into())
    );
    assert!(json["records"][0]["force_interval"].as_f64().unwrap() > 0.0);
    assert!(json["unidentified"].as_array().unwrap().iter().any(|name| name == "normal_stiffness"));
    let following = json["coupling"]["following"].as_f64().unwrap();
    assert!((following - 1.0).abs() < 0.1, "{following}");
    assert!(read("found.html").contains("Contact in two directions identified"));
}

/// From the rig's plan to the model with the effect that was missing: what the guide says of a constant load.
#[test]
fn a_constant_load_is_diagnosed_and_the_effect_added() {
    let folder = tempfile::tempdir().unwrap();
    let following = model()
        .replace("\"jenkins\"", "\"valanis\"\nsmoothness = 0.3")
        .replace("\"hertz\"", "\"linear\"")
        .lines()
        .filter(|line| !line.starts_with("normal_exponent") && !line.starts_with("impact_damping"))
        .map(|line| format!("{line}\n"))
        .collect::<String>();
    let constant = following.replace("normal_law = \"linear\"\n", "");
    let plan = PLAN
        .replace("[14.0, 20.0]", "[8.0, 12.0, 16.0, 20.0]")
        .replace("[34.0, 50.0]", "[20.0, 29.0, 39.0, 50.0]")
        .replace("0.3, 0.05]\n", "0.3, 0.05]\nnoise = 0.01\nnoise_told = true\nseed = 3\n");
    for (name, text) in [("truth.toml", &following), ("model.toml", &constant)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    fs::write(folder.path().join("plan.toml"), plan.replace("model.toml", "truth.toml")).unwrap();
    let output = stickslip(&folder, &["rig", "plan.toml", "-o", "measured"]);
    assert!(output.status.success(), "{}", error(&output));
    let asked = ["diagnose", "model.toml", "measured", "--effects", "normal_load_variation"];
    let output = stickslip(&folder, &[&asked[..], &["--json", "d.json", "-o", "found.toml"]].concat());
    // 10: something is missing.
    assert_eq!(output.status.code(), Some(10), "{}{}", error(&output), stdout(&output));
    let found = read_json(&folder, "d.json");
    assert_eq!(found["verdict"], "effect-found", "{found:#}");
    assert_eq!(found["effects"], serde_json::json!(["normal_load_variation"]));
    let gain = found["parameters"]["effect.1.load_gain"]["value"].as_f64().unwrap();
    assert!((gain - 1.0).abs() < 0.05, "{gain}");
    // The error of the test records falls to the noise, from several times as much.
    let told = |name: &str| found["error"][name].as_f64().unwrap();
    assert!(told("untouched") < 1.2 * told("noise_floor"), "{}", found["error"]);
    assert!(told("untouched_refitted") > 3.0 * told("noise_floor"), "{}", found["error"]);
    let asked = ["add", "model.toml", "normal_load_variation", "--fit", "measured", "-o", "new.toml"];
    let output = stickslip(&folder, &asked);
    assert!(output.status.success(), "{}", error(&output));
    let error_of = |model: &str| {
        let output = stickslip(&folder, &["compare", model, "measured", "--no-fit", "--json", "c.json"]);
        assert!(output.status.success(), "{}", error(&output));
        read_json(&folder, "c.json")["error"]["baseline"].as_f64().unwrap()
    };
    assert!(error_of("new.toml") < 0.015 && error_of("found.toml") < 0.015);
    assert!(error_of("model.toml") > 0.05);
}
