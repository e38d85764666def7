//! Development tasks: `cargo xtask check`, `cargo xtask test`, `cargo xtask golden`, `cargo xtask figures`,
//! `cargo xtask hidden-effects`, `cargo xtask cosimulation`, `cargo xtask masters`,
//! `cargo xtask judge`, `cargo xtask dist`, `cargo xtask install`.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

mod dist;
mod figures;
mod install;
mod judge;
mod public;
mod tally;

use tally::Tally;

const USAGE: &str = "usage: cargo xtask TASK

  check           what to run before each commit: format, lints, docs, tests, golden files fresh
  test            every test: Rust, and beside them the FMUs under independent importers (prepares its own
                  Python environment); the last line says how many passed, failed and were skipped
  golden          regenerate the golden files under modelDescription/ and capi/include/ (review the diff)
  install PREFIX  build the C interface and install header, libraries, pkg-config file and CMake package below PREFIX; with
                  --libraries FOLDER, the libraries that are there
  figures         lines and files per folder, long functions, public items without an example; with a number, the
                  seconds of the last timed build
  hidden-effects  find hidden effects in simulated measurements and write benches/hidden-effects.md, with --set 2
                  those of another set and benches/hidden-effects-set-2.md; with a selection of cases (--help lists
                  the arguments) only what it says, and the table under target/
  cosimulation    errors of coupled slaves over the communication step; write benches/cosimulation.md and .svg
  masters         our master beside libcosim, Ecos and FMPy on the same systems; write benches/masters/
  judge           every importer that can be had over every standard FMU, each in an environment of its own, and a suite of
                  calls in C; write benches/judges.md
  dist            build the program whose FMUs run on Linux (x86-64 and aarch64) and Windows, and have them loaded and
                  stepped where wine and qemu-user are installed; with --reproduce, build the libraries twice, from two
                  folders, and compare their bytes
";

fn main() -> ExitCode {
    let task = std::env::args().nth(1).unwrap_or_default();
    let mut tally = Tally::default();
    let done = match task.as_str() {
        "check" => check(&mut tally),
        "test" => test(&mut tally),
        "golden" => golden(),
        "install" => install::install(&std::env::args().skip(2).collect::<Vec<_>>()),
        "figures" => {
            figures::figures(&root(), std::env::args().nth(2).as_deref()).map(|text| print!("{text}"))
        }
        "cosimulation" => cargo(&["bench", "--package", "stickslip", "--bench", "coupling_errors"], &[]),
        "masters" => masters(),
        "judge" => judge::judge(),
        "dist" if std::env::args().any(|word| word == "--reproduce") => dist::reproduced(),
        "dist" => dist::dist(&mut tally),
        "hidden-effects" => hidden_effects(std::env::args().skip(2).collect()),
        _ => Err(USAGE.to_owned()),
    };
    if let Err(message) = &done {
        eprintln!("{message}");
    }
    if tally != Tally::default() {
        println!("{tally}");
    }
    if done.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn check(tally: &mut Tally) -> Result<(), String> {
    cargo(&["fmt", "--all", "--check"], &[])?;
    cargo(&["clippy", "--workspace", "--all-targets", "--locked", "--", "--deny", "warnings"], &[])?;
    cargo(&["doc", "--workspace", "--no-deps", "--locked"], &[("RUSTDOCFLAGS", "--deny warnings")])?;
    test(tally)
}

/// The tests that compare golden files write them instead.
fn golden() -> Result<(), String> {
    for (package, test) in [("stickslip-fmu-package", "package"), ("stickslip-capi", "c")] {
        let arguments = ["test", "--package", package, "--test", test, "fresh"];
        cargo(&arguments, &[("STICKSLIP_GOLDEN", "write")])?;
    }
    Ok(())
}

/// Golden files are compared by the Rust tests, so a stale one fails here. All that can be tested is, whatever failed
/// before. The two languages do not wait for each other: packages come over the network while the tests are built, and
/// the FMUs under independent importers keep one processor busy, as some of the Rust tests do.
fn test(tally: &mut Tally) -> Result<(), String> {
    let (built, environment) = beside(
        || tally.count(|_| cargo(&["test", "--workspace", "--locked", "--no-run"], &[])),
        python_environment,
    );
    if built.is_err() {
        return both(built, environment.map(|_| ()));
    }
    let mut fmus = Tally::default();
    let rust = ["test", "--workspace", "--locked", "--no-fail-fast"];
    let (rust, python) = beside(
        || tally.count(|tally| tally.watch(cargo_command(&rust))),
        || fmus.count(|tally| test_fmus(&environment?, tally)),
    );
    tally.join(&fmus);
    both(rust, python)
}

/// Says of two what failed.
fn both(first: Result<(), String>, second: Result<(), String>) -> Result<(), String> {
    match (first, second) {
        (Err(first), Err(second)) => Err(format!("{first}\n{second}")),
        (first, second) => first.and(second),
    }
}

/// Runs both at the same time.
fn beside<A, B: Send>(first: impl FnOnce() -> A, second: impl FnOnce() -> B + Send) -> (A, B) {
    std::thread::scope(|scope| {
        let second = scope.spawn(second);
        (first(), second.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// The FMUs under independent importers.
fn test_fmus(python: &Path, tally: &mut Tally) -> Result<(), String> {
    let fmus = target().join("fmus-under-test");
    // A file that an earlier version exported must not be what is judged.
    let _ = std::fs::remove_dir_all(&fmus);
    // The tests have built both programs; built once more by themselves they would want the library with other features.
    let built =
        |name: &str| target().join("debug").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    run(Command::new(built("examples/native_trajectories")).arg(&fmus))?;
    let program = built("stickslip");
    let mut pytest = Command::new(python);
    pytest
        .args(["-m", "pytest", "--quiet", "-rs", "tests/fmi", "tests/formats"])
        .env("STICKSLIP_FMUS", &fmus)
        .env("STICKSLIP", &program)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(root());
    tally.watch(pytest)
}

/// Builds the program and hands over to the script that runs all masters.
fn masters() -> Result<(), String> {
    cargo(&["build", "--locked", "--package", "stickslip-cli"], &[])?;
    let python = python_environment()?;
    let program = target().join("debug/stickslip").with_extension(std::env::consts::EXE_EXTENSION);
    run(Command::new(python).arg("benches/masters/masters.py").arg(program).arg("benches/masters"))
}

/// Builds the program and hands over to the benchmark; the whole of it writes the table that is committed.
fn hidden_effects(arguments: Vec<String>) -> Result<(), String> {
    let runs = ["--list", "--generate", "--visibility", "--help"]
        .iter()
        .all(|word| arguments.iter().all(|a| a != word));
    if runs {
        cargo(&["build", "--release", "--package", "stickslip-cli"], &[])?;
    }
    let page = hidden_effects_page(&arguments);
    let table: Vec<&str> = page.iter().flat_map(|page| ["--table", page]).collect();
    let benchmark = ["run", "--quiet", "--release", "--package", "stickslip-hidden-effects", "--"];
    let given: Vec<&str> = arguments.iter().map(String::as_str).collect();
    cargo(&[&benchmark[..], &given, &table].concat(), &[])
}

/// The committed page that a run of all cases of a set writes; `None` for a selection of them, or where the page is said.
fn hidden_effects_page(arguments: &[String]) -> Option<String> {
    let mut set = "0";
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--fresh" | "--resume" => {}
            "--jobs" | "--longest" => drop(words.next()),
            "--set" => set = words.next()?,
            _ => return None,
        }
    }
    let other = if set == "0" { String::new() } else { format!("-set-{set}") };
    Some(format!("benches/hidden-effects{other}.md"))
}

/// A virtual environment under `target/` with exactly the pinned packages; made anew when the pins change.
fn python_environment() -> Result<PathBuf, String> {
    let requirements = root().join("tests/fmi/requirements.txt");
    let alone = root().join("tests/fmi/requirements-alone.txt");
    let mut wanted = String::new();
    for file in [&requirements, &alone] {
        wanted += &std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    let environment = target().join("python");
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
    run(cargo_command(arguments).envs(environment.iter().copied()))
}

fn cargo_command(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    command
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

/// Where cargo builds.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_that_wait_for_each_other_run_beside_each_other() {
        let meeting = std::sync::Barrier::new(2);
        let meet = || meeting.wait().is_leader();
        let (first, second) = beside(meet, meet);
        assert_ne!(first, second);
    }

    #[test]
    fn only_all_cases_of_a_set_write_a_committed_page() {
        let page = |words: &str| {
            hidden_effects_page(&words.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
        };
        assert_eq!(page("").unwrap(), "benches/hidden-effects.md");
        assert_eq!(page("--resume --jobs 1 --longest 250").unwrap(), "benches/hidden-effects.md");
        assert_eq!(page("--set 2 --fresh").unwrap(), "benches/hidden-effects-set-2.md");
        for selection in
            ["--kind beam", "--set 2 --filter backlash", "--cases 3", "--list", "--table x.md", "--data d"]
        {
            assert_eq!(page(selection), None);
        }
    }
}
