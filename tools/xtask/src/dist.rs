//! The program as it is given to others: FMUs that it exports have libraries for three platforms.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::tally::Tally;
use crate::{cargo_command, python_environment, root, run, target};

/// Targets of the libraries, with the oldest C library they run with.
const TARGETS: [&str; 3] =
    ["x86_64-unknown-linux-gnu.2.17", "aarch64-unknown-linux-gnu.2.17", "x86_64-pc-windows-gnu"];

/// Builds the program under `target/dist`, and has the FMUs of all platforms loaded and stepped where that is possible here.
pub fn dist(tally: &mut Tally) -> Result<(), String> {
    let python = tools()?;
    let folder = target().join("dist");
    let build = ["build", "--release", "--locked", "--package", "stickslip-cli"];
    run(with_tools(cargo_command(&build), &python).arg("--target-dir").arg(&folder))?;
    let program = folder.join("release/stickslip").with_extension(std::env::consts::EXE_EXTENSION);
    let mut pytest = Command::new(&python);
    pytest
        .args(["-m", "pytest", "--quiet", "-rs", "tests/platforms"])
        .env("STICKSLIP", &program)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(root());
    tally.watch(pytest)?;
    println!("the program is {}", program.display());
    Ok(())
}

/// Builds the libraries twice, from copies of the sources in two folders, and compares their bytes.
pub fn reproduced() -> Result<(), String> {
    let python = tools()?;
    let folders = ["first", "second one"].map(|name| target().join("reproduced").join(name));
    // All sources first: they must be of one moment.
    folders.iter().try_for_each(|folder| copy_sources(&folder.join("sources")))?;
    let mut found = Vec::new();
    for folder in &folders {
        let build = ["build", "--locked", "--package", "stickslip-fmu-package"];
        let mut command = with_tools(cargo_command(&build), &python);
        command.arg("--target-dir").arg(folder).current_dir(folder.join("sources"));
        eprintln!("$ {command:?}");
        match command.status() {
            Ok(status) if status.success() => found.push(libraries(folder)?),
            other => return Err(format!("the libraries do not build: {other:?}")),
        }
    }
    let (first, second) = (&found[0], &found[1]);
    if first.len() != TARGETS.len() {
        return Err(format!("{} libraries were built, not {}", first.len(), TARGETS.len()));
    }
    for (name, bytes) in first {
        if second.get(name) != Some(bytes) {
            return Err(format!("{} differs from one build to the next", name.display()));
        }
        println!("{}: {} bytes, the same from two folders", name.display(), bytes.len());
    }
    Ok(())
}

/// Python with the linker, and the compiler's libraries for the targets.
fn tools() -> Result<PathBuf, String> {
    let python = python_environment()?;
    run(Command::new(&python)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"])
        .arg(root().join("tests/platforms/requirements.txt")))?;
    let triples = TARGETS.map(|target| target.split('.').next().unwrap_or(target));
    run(Command::new("rustup").args(["target", "add"]).args(triples))?;
    Ok(python)
}

/// `command` with the targets, and with the environment's programs first.
fn with_tools(mut command: Command, python: &Path) -> Command {
    let mut folders: Vec<PathBuf> = python.parent().map(|folder| root().join(folder)).into_iter().collect();
    folders.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    if let Ok(path) = std::env::join_paths(folders) {
        command.env("PATH", path);
    }
    command.env("STICKSLIP_FMU_TARGETS", TARGETS.join(" "));
    command
}

/// Copies what git knows of to `to`.
fn copy_sources(to: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("the sources cannot be copied: {error}");
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(root()).output().map_err(failed)?;
    for name in String::from_utf8_lossy(&listed.stdout).split('\0').filter(|name| !name.is_empty()) {
        let (file, copy) = (root().join(name), to.join(name));
        std::fs::create_dir_all(copy.parent().unwrap_or(to)).map_err(failed)?;
        std::fs::copy(file, copy).map_err(failed)?;
    }
    Ok(())
}

/// The shared libraries below a target directory, by their platforms and names.
fn libraries(folder: &Path) -> Result<BTreeMap<PathBuf, Vec<u8>>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let builds = std::fs::read_dir(folder.join("debug/build")).map_err(failed)?;
    let mut found = BTreeMap::new();
    for build in builds.flatten() {
        let library = build.path().join("out/library");
        for triple in TARGETS.map(|target| target.split('.').next().unwrap_or(target)) {
            for name in ["libstickslip_fmu.so", "stickslip_fmu.dll"] {
                if let Ok(bytes) = std::fs::read(library.join(triple).join("fmu").join(name)) {
                    found.insert(Path::new(triple).join(name), bytes);
                }
            }
        }
    }
    Ok(found)
}
