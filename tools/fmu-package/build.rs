//! Builds the shared library that every FMU carries, in the size-optimised `fmu` profile, for the
//! target of this build. The crate then embeds it, so that writing an FMU needs no compiler.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let variable = |name: &str| env::var(name).unwrap_or_else(|_| panic!("cargo sets {name}"));
    let workspace = PathBuf::from(variable("CARGO_MANIFEST_DIR")).join("../..");
    // A target directory of its own: the outer cargo holds the lock of the workspace's.
    let target_directory = PathBuf::from(variable("OUT_DIR")).join("library");
    let target = variable("TARGET");
    for path in ["src", "fmu/src", "fmu/build.rs", "fmu/Cargo.toml", "Cargo.toml", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={}", workspace.join(path).display());
    }

    let mut cargo = Command::new(variable("CARGO"));
    cargo.current_dir(&workspace).args(["build", "--package", "stickslip-fmu", "--profile", "fmu"]);
    // Everything needed was fetched for the outer build, which depends on the same crates.
    cargo.args(["--locked", "--offline", "--target", &target, "--target-dir"]).arg(&target_directory);
    // Flags and wrappers of the outer build (clippy, coverage) are not for the library.
    for name in [
        "RUSTFLAGS",
        "CARGO_ENCODED_RUSTFLAGS",
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
    let output = cargo.output().unwrap_or_else(|error| panic!("cargo cannot be run: {error}"));
    assert!(
        output.status.success(),
        "the FMU library does not build:\n{}",
        String::from_utf8_lossy(&output.stderr)
    );

    let (prefix, extension) = match variable("CARGO_CFG_TARGET_OS").as_str() {
        "windows" => ("", "dll"),
        "macos" => ("lib", "dylib"),
        _ => ("lib", "so"),
    };
    let library =
        target_directory.join(&target).join("fmu").join(format!("{prefix}stickslip_fmu.{extension}"));
    assert!(Path::new(&library).is_file(), "{} was not built", library.display());
    let platform = platform(&variable("CARGO_CFG_TARGET_OS"), &variable("CARGO_CFG_TARGET_ARCH"));
    println!("cargo::rustc-env=STICKSLIP_FMU_LIBRARY={}", library.display());
    println!("cargo::rustc-env=STICKSLIP_FMU_PLATFORM={platform}");
    println!("cargo::rustc-env=STICKSLIP_FMU_EXTENSION={extension}");
}

/// The folder in `binaries/`: as FMI 2.0 names it where it does, as FMI 3.0 elsewhere.
fn platform(system: &str, architecture: &str) -> String {
    match (system, architecture) {
        ("linux", "x86_64") => "linux64".to_owned(),
        ("linux", "x86") => "linux32".to_owned(),
        ("windows", "x86_64") => "win64".to_owned(),
        ("windows", "x86") => "win32".to_owned(),
        ("macos", "x86_64") => "darwin64".to_owned(),
        ("macos", other) => format!("{other}-darwin"),
        (system, architecture) => format!("{architecture}-{system}"),
    }
}
