//! What a user does with the program and a loop that was measured.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::{entries, error, example, read_json, stickslip};

#[test]
fn a_refit_finds_the_parameters_of_an_exact_loop() {
    let folder = example();
    let output = stickslip(
        folder.path(),
        &["compare", "model.toml", "data", "-o", "refitted.toml", "--json", "c.json", "--report", "r.html"],
    );
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "c.json");
    assert_eq!(json["schema"], "stickslip.comparison/1");
    assert!(json["error"]["baseline"].as_f64().unwrap() > 0.1);
    assert!(json["error"]["refitted"].as_f64().unwrap() < 1e-6);
    let parameters = &json["stages"][1]["parameters"];
    assert!((parameters["contact.tangential_stiffness"]["value"].as_f64().unwrap() / 3e6 - 1.0).abs() < 1e-6);
    assert!((parameters["contact.friction_coefficient"]["value"].as_f64().unwrap() / 0.6 - 1.0).abs() < 1e-6);
    // The refitted model makes the error that was promised, and exports.
    let again =
        stickslip(folder.path(), &["compare", "refitted.toml", "data", "--no-fit", "--json", "d.json"]);
    assert!(again.status.success());
    let again = read_json(&folder, "d.json");
    assert_eq!(again["error"]["baseline"], json["error"]["refitted"]);
    assert!(stickslip(folder.path(), &["export", "refitted.toml", "-o", "Refitted.fmu"]).status.success());
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let folder = example();
    for name in ["first", "second"] {
        fs::create_dir(folder.path().join(name)).unwrap();
        let files = [format!("{name}/c.json"), format!("{name}/X.fmu")];
        let compared = stickslip(folder.path(), &["compare", "model.toml", "data", "--json", &files[0]]);
        let exported = stickslip(folder.path(), &["export", "model.toml", "-o", &files[1]]);
        assert!(compared.status.success() && exported.status.success());
    }
    for file in ["c.json", "X.fmu"] {
        let read = |name: &str| fs::read(folder.path().join(name).join(file)).unwrap();
        assert!(read("first") == read("second"), "{file}");
    }
}

#[test]
fn an_fmu_is_of_the_version_that_is_asked_for_and_a_model_is_read_from_either() {
    let folder = example();
    let export = |version: &str, from: &str, out: &str| {
        stickslip(folder.path(), &["export", from, "-o", out, "--fmi", version, "--json", "e.json"])
    };
    for (version, number, out) in [("2", "2.0", "Two.fmu"), ("3", "3.0", "Three.fmu")] {
        assert!(export(version, "model.toml", out).status.success());
        assert_eq!(read_json(&folder, "e.json")["fmi_version"], number);
    }
    // From the one to the other, the same bytes.
    assert!(export("2", "Three.fmu", "again/Two.fmu").status.code() == Some(2), "no such folder");
    fs::create_dir(folder.path().join("again")).unwrap();
    assert!(export("3", "Two.fmu", "again/Three.fmu").status.success());
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("Three.fmu") == read("again/Three.fmu") && read("Two.fmu") != read("Three.fmu"));
    let unknown = export("1", "model.toml", "One.fmu");
    assert_eq!(unknown.status.code(), Some(2));
    assert!(error(&unknown).contains("FMI 2 and 3") && !folder.path().join("One.fmu").exists());
}

#[test]
fn standard_fmus_are_written_by_name_or_all() {
    let folder = tempfile::tempdir().unwrap();
    assert!(stickslip(folder.path(), &["fmu", "--out", "all"]).status.success());
    let names: Vec<String> = entries(&folder.path().join("all"))
        .iter()
        .map(|path| path.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    let systems =
        ["BeamWithJenkins.ssp", "BeamWithSlipSlap.ssp", "BeamWithTwoContacts.ssp", "BeamWithValanis.ssp"];
    let beams = ["FrictionalBeam.fmu", "JenkinsContact.fmu", "ModalBeam.fmu", "ModalBeamTwoContacts.fmu"];
    assert_eq!(
        names,
        [
            &systems[..],
            &beams,
            &["PinnedBeam.fmu", "SlipSlapBeam.fmu", "SlipSlapContact.fmu", "ValanisContact.fmu"]
        ]
        .concat()
    );
    assert!(stickslip(folder.path(), &["fmu", "--out", "one", "ModalBeam"]).status.success());
    assert_eq!(entries(&folder.path().join("one")).len(), 1);
    let unknown = stickslip(folder.path(), &["fmu", "--out", "none", "Modalbeam"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(!folder.path().join("none").exists());
}

#[test]
fn a_reader_that_closes_the_pipe_does_not_cost_the_results() {
    let folder = example();
    let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .current_dir(folder.path())
        .args(["compare", "model.toml", "data", "--no-fit", "--json", "c.json"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", error(&output));
    assert!(folder.path().join("c.json").is_file());
}

/// Starts the program, interrupts it while it works and waits for its end.
#[cfg(unix)]
fn interrupted(folder: &Path, arguments: &[&str]) -> Output {
    let child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .current_dir(folder)
        .args(arguments)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough to be past the start, short against the work.
    std::thread::sleep(std::time::Duration::from_millis(700));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn an_interrupted_refit_writes_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("backbone.csv", include_str!("../../../../examples/frictional-support/backbone.csv")),
        ("dataset.toml", include_str!("../../../../examples/frictional-support/dataset.toml")),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    // So many modes that the refit takes seconds.
    let slow = include_str!("../../../../examples/frictional-support/valanis.toml")
        .replace("modes = 4", "modes = 40");
    assert!(slow.contains("modes = 40"));
    fs::write(folder.path().join("slow.toml"), slow).unwrap();
    let started = std::time::Instant::now();
    let output = interrupted(folder.path(), &["compare", "slow.toml", ".", "--json", "c.json"]);
    assert_eq!(output.status.code(), Some(130), "{}", error(&output));
    assert!(error(&output).contains("interrupted"));
    let json = read_json(&folder, "c.json");
    assert!(json["error"]["baseline"].as_f64().unwrap() > 0.1);
    assert!(started.elapsed().as_secs() < 30);
}
