//! What the program prints where, and how it is used from a shell.

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;

use crate::support::{error, example, stdout, stickslip};

const COMPARE: [&str; 3] = ["compare", "model.toml", "data"];

#[test]
fn json_on_standard_output_stands_there_alone() {
    let folder = example();
    let output = stickslip(folder.path(), &[&COMPARE[..], &["--json", "-", "--report", "r.html"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["schema"], "stickslip.comparison/1");
    assert!(folder.path().join("r.html").is_file() && !folder.path().join("-").exists());
    // Not two results at once.
    let output = stickslip(folder.path(), &[&COMPARE[..], &["--json", "-", "-o", "-"]].concat());
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
}

#[test]
fn the_quiet_say_nothing_but_errors() {
    let folder = example();
    for place in [0, 3] {
        let mut words = COMPARE.to_vec();
        words.insert(place, "--quiet");
        let output = stickslip(folder.path(), &words);
        assert_eq!((stdout(&output), error(&output)), (String::new(), String::new()));
    }
    let output = stickslip(folder.path(), &["-q", "compare", "none.toml", "data"]);
    assert!(error(&output).starts_with("error: ") && output.status.code() == Some(2));
    let output = stickslip(folder.path(), &["compare", "model.toml", "data", "-q", "--json", "-"]);
    assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
}

/// The program on a terminal, by util-linux' `script`.
#[cfg(target_os = "linux")]
fn on_a_terminal(variables: &[(&str, &str)]) -> Output {
    let program = format!("{} compare model.toml data --no-fit", env!("CARGO_BIN_EXE_stickslip"));
    Command::new("script")
        .args(["--quiet", "--return", "--command", &program, "/dev/null"])
        .current_dir(example().path())
        .env_remove("NO_COLOR")
        .env("TERM", "xterm")
        .envs(variables.iter().copied())
        .output()
        .unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn colours_are_for_terminals_that_want_them() {
    if Command::new("script").arg("--version").output().is_err() {
        println!("skipped: there is no program `script` to make a terminal");
        return;
    }
    let escapes = |variables: &[(&str, &str)]| stdout(&on_a_terminal(variables)).contains('\u{1b}');
    assert!(escapes(&[]) && escapes(&[("NO_COLOR", "")]));
    assert!(!escapes(&[("NO_COLOR", "1")]) && !escapes(&[("TERM", "dumb")]));
}

#[test]
fn shells_complete_and_the_manual_has_a_page_for_every_command() {
    let folder = example();
    let output = stickslip(folder.path(), &["completions", "bash"]);
    assert!(stdout(&output).contains("complete -F _stickslip") && stdout(&output).contains("diagnose"));
    let output = stickslip(folder.path(), &["man"]);
    assert!(stdout(&output).contains(".TH stickslip 1") && !stdout(&output).contains("serve"));
    for command in ["compare", "diagnose", "simulate"] {
        let page = stdout(&stickslip(folder.path(), &["man", command]));
        assert!(page.contains(&format!("stickslip\\-{command}")) && page.contains("SYNOPSIS"), "{page}");
    }
    let output = stickslip(folder.path(), &["man", "nothing"]);
    assert!(output.status.code() == Some(2) && error(&output).contains("`nothing`"));
}

/// The command of a report can be pasted into a shell.
#[cfg(unix)]
#[test]
fn the_command_in_a_report_is_quoted_for_a_shell() {
    let folder = example();
    std::fs::rename(folder.path().join("data"), folder.path().join("my data")).unwrap();
    let output = stickslip(folder.path(), &["compare", "model.toml", "my data", "--report", "it's.html"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    let page = std::fs::read_to_string(folder.path().join("it's.html")).unwrap();
    assert!(page.contains("compare model.toml 'my data' --report 'it'\\''s.html'"));
}

/// Runs the program, sends SIGTERM after `wait`, and gives the time that it takes from there, and its exit code.
#[cfg(unix)]
fn answered(
    folder: &std::path::Path,
    arguments: &[&str],
    wait: std::time::Duration,
) -> (std::time::Duration, Option<i32>) {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .current_dir(folder)
        .args(arguments)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(wait);
    assert!(child.try_wait().unwrap().is_none(), "{arguments:?} ended before it was asked to");
    let begin = std::time::Instant::now();
    let sent = std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let code = child.wait().unwrap().code();
    (begin.elapsed(), code)
}

#[cfg(unix)]
#[test]
fn a_signal_is_answered_in_the_middle_of_a_solve_that_does_not_look_up() {
    let folder = tempfile::tempdir().unwrap();
    // Ten thousand masses: their matrices alone take minutes.
    let mut model =
        "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nexcitation = { at = \"m1\" }\n".to_owned();
    for mass in 1..=10_000 {
        let before = if mass == 1 { "ground".to_owned() } else { format!("m{}", mass - 1) };
        model += &format!(
            "[[mass]]\nname = \"m{mass}\"\nmass = 1.0\n[[spring]]\nbetween = [\"{before}\", \"m{mass}\"]\nstiffness = 1e4\ndamping = 1.0\n"
        );
    }
    fs::write(folder.path().join("many.toml"), model).unwrap();
    let frf = ["frf", "many.toml", "--from", "1", "--to", "30", "--force", "1"];
    let (time, code) = answered(folder.path(), &frf, std::time::Duration::from_secs(3));
    // A second, and what a machine takes that does other things, too; the solve takes minutes.
    assert!(code == Some(130) && time.as_secs_f64() < 10.0, "{code:?} after {time:?}");
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_and_files_without_end_are_refused_at_once() {
    let folder = example();
    let made = std::process::Command::new("mkfifo").arg(folder.path().join("fifo.csv")).status().unwrap();
    assert!(made.success());
    // Large on paper only: a hole.
    fs::File::create(folder.path().join("large.csv")).unwrap().set_len(1_200_000_000).unwrap();
    for file in ["fifo.csv", "/dev/zero", "large.csv"] {
        let begin = std::time::Instant::now();
        for arguments in
            [&["compare", "model.toml", file][..], &["import", file, "-o", "out"], &["compare", file, "data"]]
        {
            let output = stickslip(&folder, arguments);
            assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", error(&output));
            let told = error(&output);
            assert!(told.contains("pipe or a device") || told.contains("up to 300 MB"), "{told}");
        }
        assert!(begin.elapsed().as_secs_f64() < 2.0);
    }
}
