//! Systems of FMUs as a user simulates them.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

#[path = "../../fmi-host/tests/support/unruly.rs"]
#[allow(dead_code)]
mod unruly;

fn stickslip(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip")).current_dir(folder).args(arguments).output().unwrap()
}

/// Runs and expects this exit code; standard output and error.
fn ended(folder: &Path, code: i32, arguments: &[&str]) -> (String, String) {
    let output = stickslip(folder, arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, errors) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{out}\n{errors}");
    (out, errors)
}

/// A folder with BeamWithJenkins.ssp.
fn systems() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    ended(folder.path(), 0, &["fmu", "BeamWithJenkins", "JenkinsContact"]);
    folder
}

fn json(folder: &TempDir, file: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.path().join(file)).unwrap()).unwrap()
}

fn column<'j>(json: &'j Value, name: &str) -> Vec<f64> {
    let columns = json["columns"].as_array().unwrap();
    let column: &'j Value = columns.iter().find(|column| column["name"] == name).unwrap();
    column["values"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn a_finer_explicit_coupling_approaches_the_strong_one_and_so_does_its_energy() {
    let folder = systems();
    let run = |algorithm: &str, step: &str, every: &str| {
        let arguments = [
            "simulate",
            "BeamWithJenkins.ssp",
            "--stop",
            "0.01",
            "--algorithm",
            algorithm,
            "--extrapolation",
            "0",
            "--step",
            step,
            "--every",
            every,
            "--out",
            "r.json",
        ];
        ended(folder.path(), 0, &arguments);
        json(&folder, "r.json")
    };
    let reference = run("strong", "5e-6", "20");
    let exact = column(&reference, "beam.displacement");
    let scale = exact.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    assert!(scale > 1e-7);
    let error = |json: &Value| {
        let found = column(json, "beam.displacement");
        assert_eq!(found.len(), exact.len());
        let worst = found.iter().zip(&exact).map(|(one, other)| (one - other).abs());
        worst.fold(0.0_f64, f64::max) / scale
    };
    let (coarse, fine) = (run("jacobi", "2e-5", "5"), run("jacobi", "1e-5", "10"));
    assert!(error(&fine) < 0.7 * error(&coarse), "{} {}", error(&fine), error(&coarse));
    let residual = |json: &Value| json["energy"][0]["magnitude"].as_f64().unwrap();
    assert!(residual(&fine) < 0.7 * residual(&coarse));
    let strong = run("strong", "2e-5", "5");
    assert!(error(&strong) < 0.3 * error(&coarse), "{} {}", error(&strong), error(&coarse));
}

#[test]
fn tables_have_units_and_reports_the_energy() {
    let folder = systems();
    let (table, _) = ended(
        folder.path(),
        0,
        &[
            "simulate",
            "BeamWithJenkins.ssp",
            "--stop",
            "0.005",
            "--step",
            "1e-4",
            "--out",
            "r.csv",
            "--report",
            "r.html",
        ],
    );
    assert!(table.contains("beam.contact_force") && table.contains("strong"), "{table}");
    let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
    let header = csv.lines().next().unwrap();
    assert!(header.starts_with("time [s],beam.displacement [m],beam.velocity [m/s]"), "{header}");
    assert!(header.contains("contact.slip_state [1]"), "{header}");
    assert_eq!(csv.lines().count(), 52);
    let page = fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(page.contains("Energy residual") && page.contains("contact.force"));
    ended(folder.path(), 0, &["simulate", "BeamWithJenkins.ssp", "--stop", "0.005", "--out", "r.parquet"]);
    let parquet = fs::read(folder.path().join("r.parquet")).unwrap();
    assert!(parquet.starts_with(b"PAR1") && parquet.ends_with(b"PAR1"));
}

#[test]
fn values_from_the_command_line_and_from_a_file_act() {
    let folder = systems();
    let path = folder.path();
    let force = |more: &[&str]| {
        let base = ["simulate", "JenkinsContact.fmu", "--stop", "0.01", "--step", "1e-3", "--out", "r.json"];
        ended(path, 0, &[&base[..], more].concat());
        column(&json(&folder, "r.json"), "JenkinsContact.force")
    };
    // 0.6 · 147.15 N, or less normal load, once the displacement is beyond the limit.
    let held = force(&["--set", "displacement=1e-4"]);
    assert!((held[5] - 0.6 * 147.15).abs() < 1e-9, "{held:?}");
    let light = force(&["--set", "displacement=1e-4", "--set", "JenkinsContact.normal_load=10"]);
    assert!((light[5] - 6.0).abs() < 1e-9, "{light:?}");
    fs::write(path.join("push.csv"), "time [s],displacement [m]\n0,0\n0.004,4e-6\n0.1,4e-6\n").unwrap();
    let driven = force(&["--input", "push.csv", "--algorithm", "gauss-seidel"]);
    assert!((driven[2] - 7.9e6 * 2e-6).abs() < 1e-9 && (driven[9] - 31.6).abs() < 1e-9, "{driven:?}");
}

#[test]
fn bad_input_is_told_with_names_and_nothing_is_written() {
    let folder = systems();
    let path = folder.path();
    fs::write(path.join("broken.ssd"), "<a>").unwrap();
    fs::write(path.join("broken.fmu"), "PK").unwrap();
    let system = "BeamWithJenkins.ssp";
    let cases: [(&[&str], &str); 9] = [
        (&["nowhere.ssp"], "nowhere.ssp"),
        (&["broken.ssd"], "broken.ssd"),
        (&["broken.fmu"], "broken.fmu"),
        (&[system, "--set", "contact.nix=1"], "contact (resources/JenkinsContact.fmu) has no variable `nix`"),
        (&[system, "--set", "gear.nix=1"], "the system has beam, contact"),
        (&[system, "--set", "contact.normal_load=much"], "`much`"),
        (&[system, "--step=-1"], "step"),
        (&[system, "--out", "r.xlsx"], ".parquet"),
        (&[system, "--out", "BeamWithJenkins.ssp"], "would replace the input"),
    ];
    for (arguments, message) in cases {
        let whole: Vec<&str> = ["simulate"].iter().chain(arguments).copied().collect();
        let (_, errors) = ended(path, 2, &whole);
        assert!(errors.contains(message), "{arguments:?}: {errors}");
    }
    assert!(!path.join("r.xlsx").exists());
}

#[test]
fn a_crash_in_its_own_process_ends_the_run_in_order() {
    let (folder, _file) = unruly::file();
    for behaviour in ["1", "2", "3", "5", "6"] {
        let set = format!("behaviour={behaviour}");
        let arguments = [
            "simulate",
            "Unruly.fmu",
            "--stop",
            "1",
            "--step",
            "0.1",
            "--isolate",
            "--set",
            &set,
            "--set",
            "u=2",
            "--out",
            "r.csv",
        ];
        let (out, _) = ended(folder.path(), 1, &arguments);
        assert!(out.contains("Unruly.fmu") && out.contains("0.4 s"), "{out}");
        let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
        let last: Vec<f64> =
            csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(csv.lines().count(), 1 + 5, "{csv}");
        assert!((last[0] - 0.4).abs() < 1e-12 && (last[1] - 0.8).abs() < 1e-12, "{last:?}");
    }
}

#[test]
fn discarded_steps_are_repeated_shorter_or_told() {
    let (folder, _file) = unruly::file();
    let arguments =
        ["simulate", "Unruly.fmu", "--stop", "1", "--step", "0.1", "--set", "behaviour=4", "--out", "r.csv"];
    let (out, _) = ended(folder.path(), 1, &arguments);
    assert!(out.contains("gave up") && out.contains("0.45"), "{out}");
}

#[test]
fn two_contacts_on_one_beam_share_it_and_take_its_energy() {
    let folder = tempfile::tempdir().unwrap();
    ended(folder.path(), 0, &["fmu", "BeamWithTwoContacts"]);
    // With the step that the beam proposes.
    let arguments = ["simulate", "BeamWithTwoContacts.ssp", "--stop", "0.02", "--out", "r.json"];
    ended(folder.path(), 0, &arguments);
    let json = json(&folder, "r.json");
    let energy = json["energy"].as_array().unwrap();
    assert_eq!(energy.len(), 2, "{energy:?}");
    for one in energy {
        let (magnitude, exchanged) = (one["magnitude"].as_f64().unwrap(), one["exchanged"].as_f64().unwrap());
        assert!(exchanged > 0.0 && magnitude < 0.01 * exchanged, "{one}");
    }
    let force = column(&json, "damper.force");
    let largest = force.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    assert!((largest - 0.6 * 15.0).abs() < 1e-9, "the damper slips at its limit: {largest}");
    for contact in ["contact", "damper"] {
        let dissipated = column(&json, &format!("{contact}.dissipated_energy"));
        assert!(
            dissipated.windows(2).all(|pair| pair[1] >= pair[0] - 1e-15) && *dissipated.last().unwrap() > 0.0
        );
    }
}
