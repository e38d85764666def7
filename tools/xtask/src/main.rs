//! Development tasks: `cargo xtask check`, `cargo xtask test`, `cargo xtask golden`, `cargo xtask hidden-effects`,
//! `cargo xtask cosimulation`.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask TASK

  check           what to run before each commit: format, lints, docs, tests, golden files fresh
  test            every test: Rust, then the FMUs under independent importers (prepares its own Python environment)
  golden          regenerate the golden files under modelDescription/ (review the diff)
  hidden-effects  find hidden effects in simulated measurements and write benches/hidden-effects.md;
                  with arguments (--help lists them) only what they say, and the table under target/
  cosimulation    errors of coupled slaves over the communication step; write benches/cosimulation.md and .svg
";

fn main() -> ExitCode {
    let task = std::env::args().nth(1).unwrap_or_default();
    let done = match task.as_str() {
        "check" => check(),
        "test" => test(),
        "golden" => cargo(
            &["test", "--package", "stickslip-fmu-package", "--test", "package"],
            &[("STICKSLIP_GOLDEN", "write")],
        ),
        "cosimulation" => {
            cargo(&["run", "--release", "--package", "stickslip", "--example", "cosimulation"], &[])
        }
        "hidden-effects" => hidden_effects(std::env::args().skip(2).collect()),
        _ => Err(USAGE.to_owned()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn check() -> Result<(), String> {
    cargo(&["fmt", "--all", "--check"], &[])?;
    cargo(&["clippy", "--workspace", "--all-targets", "--locked", "--", "--deny", "warnings"], &[])?;
    cargo(&["doc", "--workspace", "--no-deps", "--locked"], &[("RUSTDOCFLAGS", "--deny warnings")])?;
    test()
}

/// Golden files are compared by the Rust tests, so a stale one fails here.
fn test() -> Result<(), String> {
    cargo(&["test", "--workspace", "--locked"], &[])?;
    let python = python_environment()?;
    let fmus = root().join("target/fmus-under-test");
    // A file that an earlier version exported must not be what is judged.
    let _ = std::fs::remove_dir_all(&fmus);
    // The tests have built both programs; built once more by themselves they would want the library with other features.
    let built =
        |name: &str| root().join("target/debug").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    run(Command::new(built("examples/native_trajectories")).arg(&fmus))?;
    let program = built("stickslip");
    run(Command::new(python)
        .args(["-m", "pytest", "--quiet", "tests/fmi"])
        .env("STICKSLIP_FMUS", &fmus)
        .env("STICKSLIP", &program)
        .env("PYTHONDONTWRITEBYTECODE", "1"))
}

/// Builds the program and hands over to the benchmark; the whole of it writes the table that is committed.
fn hidden_effects(arguments: Vec<String>) -> Result<(), String> {
    let runs = ["--list", "--generate", "--visibility", "--help"]
        .iter()
        .all(|word| arguments.iter().all(|a| a != word));
    if runs {
        cargo(&["build", "--release", "--package", "stickslip-cli"], &[])?;
    }
    let whole = arguments.iter().all(|word| ["--fresh", "--resume"].contains(&word.as_str()));
    let table: &[&str] = if whole { &["--table", "benches/hidden-effects.md"] } else { &[] };
    let benchmark = ["run", "--quiet", "--release", "--package", "stickslip-hidden-effects", "--"];
    let given: Vec<&str> = arguments.iter().map(String::as_str).collect();
    cargo(&[&benchmark[..], &given, table].concat(), &[])
}

/// A virtual environment under `target/` with exactly the pinned packages; made anew when the pins change.
fn python_environment() -> Result<PathBuf, String> {
    let requirements = root().join("tests/fmi/requirements.txt");
    let alone = root().join("tests/fmi/requirements-alone.txt");
    let mut wanted = String::new();
    for file in [&requirements, &alone] {
        wanted += &std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    let environment = root().join("target/python");
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let stamp = environment.join("requirements-installed.txt");
    if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    let _ = std::fs::remove_dir_all(&environment);
    run(Command::new("python3").args(["-m", "venv"]).arg(&environment))?;
    run(Command::new(&python)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"])
        .arg(&requirements))?;
    run(Command::new(&python)
        .args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--no-deps",
            "--requirement",
        ])
        .arg(&alone))?;
    std::fs::write(&stamp, wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
    Ok(python)
}

fn cargo(arguments: &[&str], environment: &[(&str, &str)]) -> Result<(), String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    run(Command::new(cargo).args(arguments).envs(environment.iter().copied()))
}

fn run(command: &mut Command) -> Result<(), String> {
    let shown = format!("{command:?}");
    eprintln!("$ {shown}");
    match command.current_dir(root()).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{shown} failed: {status}")),
        Err(error) => Err(format!("{shown} could not be started: {error}")),
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
