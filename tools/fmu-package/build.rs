//! Builds the shared library that every FMU carries, in the size-optimised `fmu` profile. The crate then embeds it, so
//! that writing an FMU needs no compiler.
//!
//! It is built for the target of this build; where `STICKSLIP_FMU_TARGETS` lists targets, for each of these by cargo-zigbuild,
//! whose linker knows other systems and the age of the C library (`cargo xtask dist` does so). The bytes are the same wherever
//! the sources and the registry lie.

use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The date that FMUs of this version carry, 2026-11-21, in seconds since 1970.
const DATE: &str = "1795219200";
/// Targets, as cargo-zigbuild names them: an architecture, a system, and the oldest C library.
const TARGETS: &str = "STICKSLIP_FMU_TARGETS";

/// What is inlined unasked is a ninth of the library, and hardly a step is faster for it: those of contacts ask
/// (`inline(always)`), and loops are unrolled and vectorized all the same, which `opt-level = "s"` would not do. In the
/// compiler's measure, where 225 is usual.
const INLINING: [&str; 2] = ["-Cllvm-args=-inline-threshold=40", "-Cllvm-args=-inlinehint-threshold=80"];

fn main() {
    let workspace = PathBuf::from(variable("CARGO_MANIFEST_DIR")).join("../..");
    for path in ["src", "fmu/src", "fmu/build.rs", "fmu/Cargo.toml", "Cargo.toml", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={}", workspace.join(path).display());
    }
    println!("cargo::rerun-if-env-changed={TARGETS}");
    let own = variable("TARGET");
    let listed = env::var(TARGETS).unwrap_or_default();
    let mut targets: Vec<&str> = listed.split_whitespace().collect();
    let subcommand = if targets.is_empty() { "build" } else { "zigbuild" };
    if targets.is_empty() {
        targets.push(&own);
    }
    // That of this platform stands first.
    let own = platform(&own);
    targets.sort_by_key(|target| platform(target) != own);
    assert_eq!(platform(targets[0]), own, "{TARGETS} lacks a library for this platform");

    let mut libraries = String::from("[\n");
    for target in &targets {
        let library = build(&workspace, subcommand, target);
        let (platform, extension) = (platform(target), names(target).1);
        let _ = writeln!(
            libraries,
            "Library {{ platform: {platform:?}, extension: {extension:?}, bytes: include_bytes!({library:?}) }},"
        );
    }
    libraries.push(']');
    let file = PathBuf::from(variable("OUT_DIR")).join("libraries.rs");
    fs::write(&file, libraries).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("cargo sets {name}"))
}

/// Builds the library for `target`; where it lies.
fn build(workspace: &Path, subcommand: &str, target: &str) -> PathBuf {
    // A target directory of its own: the outer cargo holds the lock of the workspace's.
    let target_directory = PathBuf::from(variable("OUT_DIR")).join("library");
    let mut cargo = Command::new(variable("CARGO"));
    cargo.current_dir(workspace).args([subcommand, "--package", "stickslip-fmu", "--profile", "fmu"]);
    // Everything needed was fetched for the outer build, which depends on the same crates.
    cargo.args(["--locked", "--offline", "--target", target, "--target-dir"]).arg(&target_directory);
    // Flags and wrappers of the outer build (clippy, coverage) are not for the library.
    for name in [
        "RUSTFLAGS",
        "RUSTC_WORKSPACE_WRAPPER",
        "CARGO_BUILD_TARGET",
        "CARGO_TARGET_DIR",
        "CARGO_BUILD_TARGET_DIR",
        "CARGO_BUILD_BUILD_DIR",
        "CARGO_MAKEFLAGS",
        "MAKEFLAGS",
    ] {
        cargo.env_remove(name);
    }
    let flags = remapped(workspace).into_iter().chain(INLINING.map(str::to_owned));
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags.collect::<Vec<_>>().join("\u{1f}"));
    // A library for Windows carries the second of its linking, which the linker takes from here.
    cargo.env("SOURCE_DATE_EPOCH", DATE);
    let output = cargo.output().unwrap_or_else(|error| panic!("cargo cannot be run: {error}"));
    assert!(
        output.status.success(),
        "the FMU library does not build for {target}:\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let (prefix, extension) = names(target);
    let library =
        target_directory.join(triple(target)).join("fmu").join(format!("{prefix}stickslip_fmu.{extension}"));
    assert!(library.is_file(), "{} was not built", library.display());
    library
}

/// Compiler flags that keep the folders of this machine out of the library: a panic names its file.
fn remapped(workspace: &Path) -> Vec<String> {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| env::home_dir().map(|home| home.join(".cargo")));
    let registries = home.and_then(|home| fs::read_dir(home.join("registry/src")).ok());
    let registries = registries.into_iter().flatten().flatten().map(|folder| folder.path());
    let workspace = workspace.canonicalize().into_iter();
    let flag = |(folder, name): (PathBuf, &str)| format!("--remap-path-prefix={}={name}", folder.display());
    let folders =
        registries.map(|folder| (folder, "crates")).chain(workspace.map(|folder| (folder, "stickslip")));
    folders.map(flag).collect()
}

/// A target without the age of its C library.
fn triple(target: &str) -> &str {
    target.split('.').next().unwrap_or(target)
}

/// What the file name of a library begins and ends with.
fn names(target: &str) -> (&'static str, &'static str) {
    match system(target) {
        "windows" => ("", "dll"),
        "macos" => ("lib", "dylib"),
        _ => ("lib", "so"),
    }
}

fn system(target: &str) -> &str {
    match triple(target).split('-').nth(2) {
        Some("darwin") => "macos",
        Some(other) => other,
        None => "",
    }
}

/// The folder in `binaries/`: as FMI 2.0 names it where it does, as FMI 3.0 elsewhere.
fn platform(target: &str) -> String {
    let architecture = target.split('-').next().unwrap_or_default();
    match (system(target), architecture) {
        ("linux", "x86_64") => "linux64".to_owned(),
        ("linux", "i586" | "i686") => "linux32".to_owned(),
        ("windows", "x86_64") => "win64".to_owned(),
        ("windows", "i586" | "i686") => "win32".to_owned(),
        ("macos", "x86_64") => "darwin64".to_owned(),
        ("macos", other) => format!("{other}-darwin"),
        (system, architecture) => format!("{architecture}-{system}"),
    }
}
