//! Compilers, and what cargo has built beside this test.
#![cfg_attr(not(target_os = "linux"), allow(dead_code))]

use std::path::{Path, PathBuf};
use std::process::Command;

/// The package.
pub fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where cargo has put the shared and the static library: beside this test.
pub fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// What a program that is linked with the static library needs besides, as `rustc --print native-static-libs` tells.
pub const SYSTEM_LIBRARIES: [&str; 6] = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl"];

/// The first of `names` that can be run.
pub fn program(names: &[&str]) -> Option<PathBuf> {
    let folders: Vec<PathBuf> =
        std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).chain([python()]).collect();
    let mut files = names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    files.find(|file| file.is_file())
}

/// The programs of the environment that `cargo xtask test` prepares.
fn python() -> PathBuf {
    libraries().join("../../python/bin")
}

/// The folder with the official FMI 2 headers, which FMPy brings along; or `STICKSLIP_FMI_HEADERS`.
pub fn fmi_headers() -> Option<PathBuf> {
    let given = std::env::var_os("STICKSLIP_FMI_HEADERS").map(PathBuf::from);
    let versions = std::fs::read_dir(python().join("../lib")).into_iter().flatten().flatten();
    let mut installed = versions.map(|version| version.path().join("site-packages/fmpy/c-code"));
    given.into_iter().chain(&mut installed).find(|folder| folder.join("fmi2Functions.h").is_file())
}

/// Runs `command`, which must succeed; what it printed.
pub fn output_of(command: &mut Command) -> String {
    let shown = format!("{command:?}");
    let output = command.output().unwrap_or_else(|error| panic!("{shown}: {error}"));
    let (out, error) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{shown}: {}\n{out}{error}", output.status);
    assert!(error.is_empty(), "{shown} wrote to standard error:\n{error}");
    out.into_owned()
}
