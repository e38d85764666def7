//! What the program says when the input is wrong, and that it leaves alone what is there.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{CONTACT, entries, error, example, measured_loop, stickslip};

/// Compares with something wrong in it: exit code 2, one message that holds every one of `hints`, no file written.
fn refused(change: impl Fn(&Path), arguments: &[&str], hints: &[&str]) {
    let folder = example();
    change(folder.path());
    let before = entries(folder.path());
    let output = stickslip(folder.path(), arguments);
    let message = error(&output);
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
    assert!(output.status.success(), "{}", error(&output));
    assert!(error(&output).contains("nothing is free"));
    assert!(folder.path().join("c.json").is_file());
}

#[test]
fn columns_that_are_not_used_are_named() {
    let folder = example();
    let table = measured_loop().replace('\n', ",100\n").replacen(",100", ",excitation [N]", 1);
    fs::write(folder.path().join("data/loop.csv"), table).unwrap();
    let output = stickslip(folder.path(), &["compare", "model.toml", "data", "--no-fit"]);
    assert!(output.status.success());
    let note = error(&output);
    assert!(note.contains("loop.csv: column `excitation` is not used"), "{note}");
}

#[test]
fn a_channel_that_never_changes_is_bad_input() {
    let folder = example();
    let table = "time [s],displacement [mm],force [N]\n0,0,0.1\n1,0.01,0.1\n2,0,0.1\n";
    fs::write(folder.path().join("data/loop.csv"), table).unwrap();
    for arguments in [&["compare", "model.toml", "data"][..], &["diagnose", "model.toml", "data"]] {
        let output = stickslip(folder.path(), arguments);
        let message = error(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("loop.csv") && message.contains("`force`"), "{message}");
        assert!(message.contains("the same number throughout"), "{message}");
    }
}

#[test]
fn what_could_never_be_done_is_bad_input_and_reported_before_the_work() {
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
        let errors = error(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?} {errors}");
        assert!(errors.contains(message), "{arguments:?} {errors}");
    }
    assert_eq!(entries(path), before);
}

/// Exit code 2, one message that holds every one of `hints`, and every file as it was.
fn refused_and_untouched(folder: &Path, arguments: &[&str], hints: &[&str]) {
    let files = ["model.toml", "data/dataset.toml", "data/loop.csv"];
    let contents = || files.map(|file| fs::read(folder.join(file)).unwrap());
    let before = (entries(folder), contents());
    let output = stickslip(folder, arguments);
    let message = error(&output);
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
fn pipes_and_links_to_an_input_are_not_replaced() {
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
