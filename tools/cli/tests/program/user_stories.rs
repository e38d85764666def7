//! What a user does with the program, and what it says when the input is wrong.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

use crate::external;

const CONTACT: &str = r#"schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "jenkins"
tangential_stiffness = 2.0e6
friction_coefficient = 0.5
normal_load = 100.0
"#;

const DATASET: &str = r#"schema = "stickslip.dataset/1"

[[record]]
file = "loop.csv"
regime = "from-rest"
"#;

fn stickslip(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip")).current_dir(folder).args(arguments).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A folder with `model.toml`, `data/dataset.toml` and a loop measured on a contact of 3e6 N/m and 60 N.
fn example() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.toml"), CONTACT).unwrap();
    fs::create_dir(folder.path().join("data")).unwrap();
    fs::write(folder.path().join("data/dataset.toml"), DATASET).unwrap();
    fs::write(folder.path().join("data/loop.csv"), measured_loop()).unwrap();
    folder
}

/// Jenkins' element stepped by hand, in millimetres and kilonewtons.
fn measured_loop() -> String {
    let (mut slider, mut text) = (0.0_f64, "time [s],displacement [mm],force [kN]\n".to_owned());
    for index in 0..400 {
        let time = f64::from(index) * 0.0025;
        let displacement = 50e-6 * (std::f64::consts::TAU * 2.0 * time).sin();
        let force = (3e6 * (displacement - slider)).clamp(-60.0, 60.0);
        slider = displacement - force / 3e6;
        text += &format!("{time},{},{}\n", displacement * 1e3, force * 1e-3);
    }
    text
}

fn rms_of(stage: &serde_json::Value) -> f64 {
    stage["records"][0]["channels"]["frequency"]["rms"].as_f64().unwrap()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.sort();
    all
}

#[test]
fn the_demonstration_lets_the_error_fall_and_exports_the_best_model() {
    let folder = tempfile::tempdir().unwrap();
    // The demonstration is what the program does when it is told nothing.
    let output = stickslip(folder.path(), &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let results = folder.path().join("stickslip-demo");
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(results.join("comparison.json")).unwrap()).unwrap();
    let rms: Vec<f64> = json["stages"].as_array().unwrap().iter().map(rms_of).collect();
    // An independent program: 1.80 Hz (linear), 0.80 Hz (its frequencies with the printed parameters), 0.15
    // and 0.10 Hz refitted. Jenkins has no independent number.
    for (stage, expected) in rms.iter().zip([1.81, 1.07, 0.80, 0.23, 0.15, 0.10]) {
        assert!((stage - expected).abs() < 0.01, "{rms:?}");
    }
    assert!(rms.is_sorted_by(|before, after| before > after));
    // One frequency for all levels is at best their mean.
    assert!(
        (json["stages"][1]["error"].as_f64().unwrap() - 1.0).abs() < 1e-4,
        "{}",
        json["stages"][1]["error"]
    );
    // F of nested fits to eight values, from the errors alone; slip is beyond doubt, what follows is not.
    let steps = json["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 3);
    for (step, [before, after, free]) in steps.iter().zip([[1, 3, 2], [3, 4, 3], [4, 5, 4]]) {
        let ratio = (rms[before].powi(2) / rms[after].powi(2) - 1.0) * (8 - free) as f64;
        assert!((step["f"].as_f64().unwrap() / ratio - 1.0).abs() < 1e-6, "{step} {ratio}");
    }
    let chances: Vec<f64> = steps.iter().map(|step| step["chance"].as_f64().unwrap()).collect();
    assert!(chances[0] < 1e-3 && chances[1] > 0.01 && chances[2] > 0.01, "{chances:?}");
    assert!(stdout(&output).contains("FrictionalSupport.fmu"));
    let page = fs::read_to_string(results.join("report.html")).unwrap();
    assert!(page.contains("Plotly") && page.len() > 1_000_000);
    // What was exported is what was fitted: read back from the FMU it makes the same error.
    let again = stickslip(
        &results,
        &["compare", "FrictionalSupport.fmu", "frictional-support", "--no-fit", "--json", "again.json"],
    );
    assert!(again.status.success(), "{}", String::from_utf8_lossy(&again.stderr));
    let again: serde_json::Value =
        serde_json::from_slice(&fs::read(results.join("again.json")).unwrap()).unwrap();
    assert_eq!(rms_of(&again["stages"][0]), rms[5]);
}

#[test]
fn the_demonstration_leaves_a_changed_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let example = folder.path().join("stickslip-demo/frictional-support");
    fs::create_dir_all(&example).unwrap();
    fs::write(example.join("jenkins.toml"), "my own").unwrap();
    let output = stickslip(folder.path(), &["demo"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("jenkins.toml"));
    assert_eq!(fs::read_to_string(example.join("jenkins.toml")).unwrap(), "my own");
    assert_eq!(entries(&example).len(), 1);
}

#[test]
fn a_refit_finds_the_parameters_of_an_exact_loop() {
    let folder = example();
    let output = stickslip(
        folder.path(),
        &["compare", "model.toml", "data", "-o", "refitted.toml", "--json", "c.json", "--report", "r.html"],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("c.json")).unwrap()).unwrap();
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
    let again: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("d.json")).unwrap()).unwrap();
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
fn standard_fmus_are_written_by_name_or_all() {
    let folder = tempfile::tempdir().unwrap();
    assert!(stickslip(folder.path(), &["fmu", "--out", "all"]).status.success());
    let names: Vec<String> = entries(&folder.path().join("all"))
        .iter()
        .map(|path| path.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    let systems = ["BeamWithJenkins.ssp", "BeamWithTwoContacts.ssp", "BeamWithValanis.ssp"];
    let beams = ["FrictionalBeam.fmu", "JenkinsContact.fmu", "ModalBeam.fmu", "ModalBeamTwoContacts.fmu"];
    assert_eq!(names, [&systems[..], &beams, &["ValanisContact.fmu"]].concat());
    assert!(stickslip(folder.path(), &["fmu", "--out", "one", "ModalBeam"]).status.success());
    assert_eq!(entries(&folder.path().join("one")).len(), 1);
    let unknown = stickslip(folder.path(), &["fmu", "--out", "none", "Modalbeam"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(!folder.path().join("none").exists());
}

/// Compares with something wrong in it: exit code 2, one message that holds every one of `hints`, no file written.
fn refused(change: impl Fn(&Path), arguments: &[&str], hints: &[&str]) {
    let folder = example();
    change(folder.path());
    let before = entries(folder.path());
    let output = stickslip(folder.path(), arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.matches("error: ").count(), 1, "{message}");
    for hint in hints {
        assert!(message.contains(hint), "no `{hint}` in\n{message}");
    }
    assert_eq!(entries(folder.path()), before, "something was written");
}

const COMPARE: [&str; 8] =
    ["compare", "model.toml", "data", "-o", "new.toml", "--json", "c.json", "--report=r.html"];

fn replace(file: &'static str, from: &'static str, to: &'static str) -> impl Fn(&Path) {
    move |folder| {
        let path = folder.join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from));
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    }
}

#[test]
fn an_unknown_key_is_refused_with_file_and_line() {
    refused(
        replace("model.toml", "friction_coefficient", "friction_coeficient"),
        &COMPARE,
        &["model.toml:7", "friction_coeficient", "friction_coefficient"],
    );
}

#[test]
fn a_missing_column_is_refused_with_its_file() {
    refused(replace("data/loop.csv", "force [kN]", "velocity [m/s]"), &COMPARE, &["loop.csv:1", "force"]);
}

#[test]
fn a_unit_of_another_dimension_is_refused_with_file_and_line() {
    refused(replace("data/loop.csv", "[kN]", "[kg]"), &COMPARE, &["loop.csv:1", "kg", "kN"]);
}

#[test]
fn a_number_that_is_none_is_refused_with_file_and_line() {
    refused(replace("data/loop.csv", "\n0.0025,", "\nNaN,"), &COMPARE, &["loop.csv:3", "NaN"]);
}

#[test]
fn a_smoothness_of_one_is_refused_with_file_and_line() {
    let change = replace("model.toml", "law = \"jenkins\"", "law = \"valanis\"\nsmoothness = 1.0");
    refused(change, &COMPARE, &["model.toml:6", "smoothness"]);
}

#[test]
fn a_mass_of_zero_is_refused_with_file_and_line() {
    let beam = include_str!("../../../../examples/frictional-support/published.toml")
        .replace("mass = 0.02515", "mass = 0.0");
    assert!(beam.contains("mass = 0.0\n") || beam.contains("mass = 0.0 "));
    refused(
        move |folder| fs::write(folder.join("model.toml"), &beam).unwrap(),
        &["export", "model.toml", "-o", "X.fmu"],
        &["model.toml:", "mass"],
    );
}

#[test]
fn an_oscillator_is_compared_by_its_masses_and_a_contact_loop_is_not_its_record() {
    let example = include_str!("../../../../examples/friction-vibration/model.toml");
    let oscillator = |folder: &Path| fs::write(folder.join("model.toml"), example).unwrap();
    refused(oscillator, &COMPARE, &["loop.csv", "excitation:m1 [N]", "it drives the model"]);
}

#[test]
fn a_truncated_fmu_is_refused_by_name() {
    let truncate = |folder: &Path| {
        assert!(stickslip(folder, &["export", "model.toml", "-o", "X.fmu"]).status.success());
        let whole = fs::read(folder.join("X.fmu")).unwrap();
        fs::write(folder.join("X.fmu"), &whole[..whole.len() / 2]).unwrap();
    };
    refused(truncate, &["compare", "X.fmu", "data", "--json", "c.json"], &["X.fmu", "not a whole FMU"]);
}

#[test]
fn a_destination_that_cannot_be_written_is_refused_before_any_work() {
    refused(|_| (), &["compare", "model.toml", "data", "--report", "nowhere/r.html"], &["nowhere"]);
    refused(|_| (), &["export", "model.toml", "-o", "model.so"], &[".fmu"]);
    refused(|_| (), &["export", "model.toml", "-o", "two words.fmu"], &["two words"]);
    refused(|_| (), &["compare", "missing.toml", "data"], &["missing.toml"]);
    refused(|_| (), &["compare", "model.toml", "data", "--json", "x", "--report", "./x"], &["two results"]);
    refused(|_| (), &["compare", "model.toml", "data", "--json", "x", "-o", "data/../x"], &["two results"]);
    refused(|_| (), &["export", "model.toml", "-o", "X.fmu", "--report", "X.fmu"], &["two results"]);
}

#[test]
fn a_refitted_model_without_anything_free_is_refused_and_a_comparison_is_not() {
    let fixed =
        |folder: &Path| fs::write(folder.join("model.toml"), format!("{CONTACT}[fit]\nfree = []\n")).unwrap();
    refused(fixed, &COMPARE, &["[fit] free"]);
    let folder = example();
    fixed(folder.path());
    let output = stickslip(folder.path(), &["compare", "model.toml", "data", "--json", "c.json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("nothing is free"));
    assert!(folder.path().join("c.json").is_file());
}

#[test]
fn columns_that_are_left_aside_are_named() {
    let folder = example();
    let table = measured_loop().replace('\n', ",100\n").replacen(",100", ",excitation [N]", 1);
    fs::write(folder.path().join("data/loop.csv"), table).unwrap();
    let output = stickslip(folder.path(), &["compare", "model.toml", "data", "--no-fit"]);
    assert!(output.status.success());
    let note = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(note.contains("loop.csv: column `excitation` is not used"), "{note}");
}

#[test]
fn a_channel_that_never_changes_is_bad_input() {
    let folder = example();
    let table = "time [s],displacement [mm],force [N]\n0,0,0.1\n1,0.01,0.1\n2,0,0.1\n";
    fs::write(folder.path().join("data/loop.csv"), table).unwrap();
    for arguments in [&["compare", "model.toml", "data"][..], &["diagnose", "model.toml", "data"]] {
        let output = stickslip(folder.path(), arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("loop.csv") && message.contains("`force`"), "{message}");
        assert!(message.contains("the same number throughout"), "{message}");
    }
}

#[test]
fn what_could_never_be_done_is_bad_input_and_told_before_the_work() {
    let folder = example();
    let path = folder.path();
    let with = format!("{CONTACT}\n[[effect]]\nid = \"backlash\"\nhalf_gap = 1e-6\n");
    fs::write(path.join("with.toml"), with).unwrap();
    fs::write(path.join("file"), "").unwrap();
    let cases: [(&[&str], &str); 5] = [
        (&["compare", "model.toml", "data", "--report", "r.pdf"], "should end in .html"),
        (&["add", "with.toml", "backlash", "--fit", "data", "-o", "new.toml"], "`backlash` already"),
        (&["fmu", "--out", "file"], "file cannot be a folder"),
        (&["compare", "model.toml", "data", "-o", "/proc/new.toml"], "cannot write /proc/new.toml"),
        (&["export", "model.toml", "-o", "/proc/New.fmu"], "cannot write /proc/New.fmu"),
    ];
    let before = entries(path);
    for (arguments, message) in cases {
        let output = stickslip(path, arguments);
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?} {errors}");
        assert!(errors.contains(message), "{arguments:?} {errors}");
    }
    assert_eq!(entries(path), before);
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
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
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
    // So many modes that the refit takes a minute.
    let slow = include_str!("../../../../examples/frictional-support/valanis.toml")
        .replace("modes = 4", "modes = 40");
    assert!(slow.contains("modes = 40"));
    fs::write(folder.path().join("slow.toml"), slow).unwrap();
    let started = std::time::Instant::now();
    let output = interrupted(folder.path(), &["compare", "slow.toml", ".", "--json", "c.json"]);
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("interrupted"));
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("c.json")).unwrap()).unwrap();
    assert!(json["error"]["baseline"].as_f64().unwrap() > 0.1);
    assert!(started.elapsed().as_secs() < 30);
}

#[test]
fn measured_friction_damper_is_compared_where_its_data_are_present() {
    let Some(folder) = external::data("friction-damper") else { return };
    let out = tempfile::tempdir().unwrap();
    let (model, dataset) = (folder.join("model.toml"), folder.join("dataset.toml"));
    let (model, dataset) = (model.to_str().unwrap(), dataset.to_str().unwrap());
    let output =
        stickslip(out.path(), &["compare", model, dataset, "--json", "c.json", "--report", "r.html"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(out.path().join("c.json")).unwrap()).unwrap();
    let error = |name: &str| json["error"][name].as_f64().unwrap();
    assert!(error("refitted") < 0.5 * error("baseline"), "{} {}", error("baseline"), error("refitted"));
    assert_eq!(json["stages"][1]["records"].as_array().unwrap().len(), 10);
}

#[test]
fn the_measured_friction_damper_lacks_backlash() {
    let Some(folder) = external::data("friction-damper") else { return };
    let out = tempfile::tempdir().unwrap();
    let (model, dataset) = (folder.join("model.toml"), folder.join("dataset.toml"));
    let (model, dataset) = (model.to_str().unwrap(), dataset.to_str().unwrap());
    let tried = ["--effects", "backlash,residual_stiffness"];
    let output =
        stickslip(out.path(), &[&["diagnose", model, dataset, "--json", "d.json"], &tried[..]].concat());
    assert_eq!(output.status.code(), Some(10), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(out.path().join("d.json")).unwrap()).unwrap();
    assert_eq!(json["effects"], serde_json::json!(["backlash"]));
    let error = |name: &str| json["error"][name].as_f64().unwrap();
    assert!(
        error("untouched") < 0.75 * error("untouched_refitted")
            && error("untouched") < 0.5 * error("baseline")
    );
    assert!(json["error"]["noise_floor"].is_null(), "nothing tells the noise of these records");
}

/// Exit code 2, one message that holds every one of `hints`, and every file as it was.
fn refused_and_untouched(folder: &Path, arguments: &[&str], hints: &[&str]) {
    let files = ["model.toml", "data/dataset.toml", "data/loop.csv"];
    let contents = || files.map(|file| fs::read(folder.join(file)).unwrap());
    let before = (entries(folder), contents());
    let output = stickslip(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    for hint in hints {
        assert!(message.contains(hint), "no `{hint}` in\n{message}");
    }
    assert_eq!((entries(folder), contents()), before, "{arguments:?} changed something");
}

#[test]
fn no_result_replaces_what_it_was_made_from() {
    let folder = example();
    let refused = |arguments: &[&str], hints: &[&str]| refused_and_untouched(folder.path(), arguments, hints);
    let replaced = "would replace the input";
    let compare = ["compare", "model.toml", "data"];
    let with = |more: &[&str], hints: &[&str]| refused(&[&compare[..], more].concat(), hints);
    with(&["--json", "model.toml"], &["model.toml", replaced]);
    with(&["--report", "./data/../model.toml"], &["data/../model.toml", replaced, "model.toml;"]);
    with(&["--json", "data/dataset.toml"], &["data/dataset.toml", replaced]);
    with(&["--json", "data/loop.csv"], &["data/loop.csv", replaced]);
    with(&["--out", "data/loop.csv"], &["data/loop.csv", replaced]);
    refused(&["export", "model.toml", "--out", "x.fmu", "--json", "model.toml"], &["model.toml", replaced]);
    let frf = ["frf", "model.toml", "--from", "1", "--to", "2", "--report", "model.toml"];
    refused(&frf, &["model.toml", replaced]);
    assert!(stickslip(folder.path(), &["export", "model.toml", "--out", "x.fmu"]).status.success());
    let fmu = fs::read(folder.path().join("x.fmu")).unwrap();
    refused(&["export", "x.fmu", "--out", "x.fmu"], &["x.fmu", replaced]);
    assert_eq!(fs::read(folder.path().join("x.fmu")).unwrap(), fmu);
}

#[cfg(unix)]
#[test]
fn pipes_and_links_to_an_input_are_left_alone() {
    use std::os::unix::fs::{FileTypeExt as _, symlink};
    let folder = example();
    let made = Command::new("mkfifo").arg(folder.path().join("pipe")).status();
    symlink("model.toml", folder.path().join("link.toml")).unwrap();
    let refused = |arguments: &[&str], hints: &[&str]| refused_and_untouched(folder.path(), arguments, hints);
    let replaced = "would replace the input";
    refused(
        &["compare", "model.toml", "data", "--json", "link.toml"],
        &["link.toml", replaced, "model.toml"],
    );
    refused(
        &["compare", "link.toml", "data", "--json", "model.toml"],
        &["link.toml", replaced, "model.toml"],
    );
    assert!(made.is_ok_and(|status| status.success()), "no pipe to try with");
    for command in [
        &["compare", "model.toml", "data", "--report", "pipe"][..],
        &["frf", "model.toml", "--from", "1", "--to", "2", "--json", "pipe"],
        &["export", "model.toml", "--out", "x.fmu", "--json", "pipe"],
    ] {
        refused(command, &["pipe is not a regular file"]);
        assert!(fs::metadata(folder.path().join("pipe")).unwrap().file_type().is_fifo());
    }
}
