//! Nonlinear modes, and responses over a parameter, as a user asks for them.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{error, read_json, stdout, stickslip};

fn example() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let model = include_str!("../../../../examples/friction-vibration/model.toml");
    fs::write(folder.path().join("model.toml"), model).unwrap();
    folder
}

fn numbers(points: &Value, key: &str) -> Vec<f64> {
    points.as_array().unwrap().iter().map(|point| point[key].as_f64().unwrap()).collect()
}

#[test]
fn a_mode_begins_as_the_one_in_stick_and_softens_as_the_contact_slips() {
    let folder = example();
    let arguments = ["modes", "model.toml", "--node", "m2", "--from", "1e-3", "--to", "3", "--points", "12"];
    let files = ["--json", "mode.json", "--csv", "mode.csv", "--report", "mode.html"];
    let output = stickslip(folder.path(), &[&arguments[..], &files].concat());
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "mode.json");
    assert_eq!((&json["schema"], &json["complete"]), (&"stickslip.modes/1".into(), &true.into()));
    let [omega, damping, loss] =
        ["omega", "damping_ratio", "dissipated_energy"].map(|key| numbers(&json["points"], key));
    assert_eq!(omega.len(), 12);
    // In stick nothing is lost in the contact, and the frequency is the linear one of the undamped structure, but for
    // the square of the damping.
    assert!((omega[0] / json["linear_omega"].as_f64().unwrap() - 1.0).abs() < 1e-2, "{omega:?}");
    assert!(loss[0].abs() < 1e-12 && loss[11] > 0.1, "{loss:?}");
    assert!(omega[11] < 0.9 * omega[0], "{omega:?}");
    // Friction damps most in between.
    let most = damping.iter().copied().fold(0.0, f64::max);
    assert!(most > 2.0 * damping[0] && most > 1.1 * damping[11], "{damping:?}");
    // Table, file and JSON say the same.
    let table = fs::read_to_string(folder.path().join("mode.csv")).unwrap();
    let row: Vec<f64> =
        table.lines().last().unwrap().split(',').map(|value| value.parse().unwrap()).collect();
    for (row, json) in [(row[2], damping[11]), (row[3], loss[11])] {
        assert!((row / json - 1.0).abs() < 1e-14, "{row} {json}");
    }
    assert!(stdout(&output).contains(&format!("{:.6e}", loss[11])), "{}", stdout(&output));
    let page = fs::read_to_string(folder.path().join("mode.html")).unwrap();
    for expected in ["Mode 1 of model.toml", "12 amplitudes", "damping ratio", "amplitude of m2"] {
        assert!(page.contains(expected), "{expected}");
    }
}

#[test]
fn what_has_no_mode_is_named() {
    let folder = example();
    let said = |more: &[&str]| {
        let output = stickslip(folder.path(), &[&["modes", "model.toml"][..], more].concat());
        assert_eq!(output.status.code(), Some(2), "{}", error(&output));
        error(&output)
    };
    assert!(said(&["--from", "0.1", "--to", "1", "--node", "m3"]).contains("no node `m3`"));
    assert!(said(&["--from", "0.1", "--to", "1", "--mode", "0"]).contains("counted from 1"));
    assert!(said(&["--from", "-1", "--to", "1"]).contains("positive"));
}

/// Amplitudes of both masses over the friction, at its ends.
fn varied(folder: &TempDir, range: &str) -> (Value, Vec<Vec<f64>>) {
    let vary = format!("contact.friction_coefficient={range}");
    let arguments =
        ["frf", "model.toml", "--vary", &vary, "--at", "0.8", "--unit", "rad/s", "--force", "0.4"];
    let output = stickslip(
        folder.path(),
        &[&arguments[..], &["--json", "v.json", "--csv", "v.csv", "--report", "v.html"]].concat(),
    );
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(folder, "v.json");
    let amplitudes = json["points"].as_array().unwrap().iter();
    let amplitudes =
        amplitudes.map(|point| serde_json::from_value(point["amplitude"].clone()).unwrap()).collect();
    (json, amplitudes)
}

#[test]
fn a_response_over_a_parameter_is_the_same_from_either_end() {
    let folder = example();
    let (up, there) = varied(&folder, "0.05:0.4");
    let (_, back) = varied(&folder, "0.4:0.05");
    assert_eq!(up["complete"], true);
    let values = numbers(&up["points"], "value");
    assert_eq!((values[0], values[values.len() - 1]), (0.05, 0.4));
    for (one, other) in [(&there[0], &back[back.len() - 1]), (&there[there.len() - 1], &back[0])] {
        for (one, other) in one.iter().zip(other) {
            assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
        }
    }
    let rows = fs::read_to_string(folder.path().join("v.csv")).unwrap().lines().count();
    assert_eq!(rows, back.len() + 1);
    let page = fs::read_to_string(folder.path().join("v.html")).unwrap();
    for expected in ["contact.friction_coefficient", "0.8\u{a0}rad/s", "400\u{a0}mN", "loss per cycle"] {
        assert!(page.contains(expected), "{expected}");
    }
}

#[test]
fn a_resonance_tracked_over_the_force_is_that_of_a_sweep_and_of_the_exact_flow() {
    let folder = example();
    let arguments = ["frf", "model.toml", "--unit", "rad/s", "--harmonics", "41"];
    let track = ["--vary", "force=0.05:0.4", "--at", "0.6", "--track", "peak:m1"];
    let files = ["--json", "t.json", "--csv", "t.csv", "--report", "t.html"];
    let output = stickslip(folder.path(), &[&arguments[..], &track, &files].concat());
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "t.json");
    assert_eq!((&json["complete"], &json["tracked"]), (&true.into(), &"peak:m1".into()));
    let points = &json["points"];
    let [force, omega] = ["value", "frequency"].map(|key| numbers(points, key));
    let [first, last] = [0, 50].map(|index| points[index]["amplitude"][0].as_f64().unwrap());
    assert_eq!((force.len(), force[0], force[50]), (51, 0.05, 0.4));
    // ω and amplitude of the event-driven exact solution.
    assert!((omega[50] - 0.527394).abs() < 2e-6, "{}", omega[50]);
    assert!((last / 1.008048920 - 1.0).abs() < 1e-6, "{last}");
    let sweep = ["--force", "0.05", "--from", "0.45", "--to", "0.9", "--json", "f.json"];
    let output = stickslip(folder.path(), &[&arguments[..], &sweep].concat());
    assert!(output.status.success(), "{}", error(&output));
    let swept = read_json(&folder, "f.json");
    let peaks = swept["peaks"].as_array().unwrap().iter();
    let peak = peaks.filter(|peak| peak["node"] == "m1").map(|peak| peak["amplitude"].as_f64().unwrap());
    let nearest = peak.map(|peak| (first / peak - 1.0).abs()).fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-7, "{nearest}");
    let table = fs::read_to_string(folder.path().join("t.csv")).unwrap();
    assert!(table.starts_with("force,frequency [rad/s],amplitude:m1 [m]"), "{table}");
    assert!(table.lines().last().unwrap().starts_with(&format!("0.4,{}", omega[50])), "{table}");
    assert!(stdout(&output).contains("m1") && table.lines().count() == 52);
    let page = fs::read_to_string(folder.path().join("t.html")).unwrap();
    for expected in ["at the peak of m1", "frequency of the resonance", "Frequency (rad/s)"] {
        assert!(page.contains(expected), "{expected}");
    }
}

#[test]
fn a_response_over_the_force_grows_in_proportion_until_the_contact_slips() {
    let folder = example();
    let arguments = [
        "frf",
        "model.toml",
        "--unit",
        "rad/s",
        "--at",
        "0.677",
        "--vary",
        "force=0:0.4",
        "--json",
        "f.json",
    ];
    let output = stickslip(folder.path(), &arguments);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "f.json");
    assert!(json["force"].is_null() && json["complete"] == true);
    let [force, loss] = ["value", "dissipated_energy"].map(|key| numbers(&json["points"], key));
    assert_eq!((force[0], force[force.len() - 1]), (0.0, 0.4));
    // In closed form it slips from 0.01739 N on.
    for (force, loss) in force.iter().zip(loss) {
        assert!((force - 0.01739).abs() < 2e-5 || (loss > 0.0) == (*force > 0.01739), "{force}: {loss}");
    }
}

#[test]
fn a_parameter_that_is_not_there_is_named() {
    let folder = example();
    let said = |vary: &str, more: &[&str]| {
        let output = stickslip(folder.path(), &[&["frf", "model.toml", "--vary", vary][..], more].concat());
        assert_eq!(output.status.code(), Some(2), "{}", error(&output));
        error(&output)
    };
    assert!(said("contact.friction=0.1:0.2", &["--at", "0.8"]).contains("contact.friction"));
    assert!(said("contact.friction_coefficient", &["--at", "0.8"]).contains("write it as"));
    assert!(said("contact.friction_coefficient=0.1:0.2", &[]).contains("--at"));
    assert!(said("contact.friction_coefficient=0.1:0.2", &["--at", "-1"]).contains("--at"));
    assert!(said("force=0.1:0.2", &["--at", "0.8", "--force", "1"]).contains("either varied or given"));
    let tracked = |what| said("force=0.1:0.2", &["--at", "0.8", "--track", what]);
    assert!(tracked("peek:m1").contains("did you mean `peak`"));
    assert!(tracked("peak").contains("write it as"));
    assert!(tracked("phase:m3").contains("no node `m3`"));
    assert!(said("force=0:0.2", &["--at", "0.8", "--track", "peak:m1"]).contains("zero"));
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_mode_ends_within_a_second_and_keeps_its_points() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let folder = example();
    let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .current_dir(folder.path())
        .args([
            "modes",
            "model.toml",
            "--from",
            "1e-3",
            "--to",
            "3",
            "--points",
            "2000000",
            "--json",
            "mode.json",
        ])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(700));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let asked = Instant::now();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // A second of its own, and one for what else the machine does.
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
    let json = read_json(&folder, "mode.json");
    assert_eq!(json["complete"], false);
    assert!(!json["points"].as_array().unwrap().is_empty());
}
