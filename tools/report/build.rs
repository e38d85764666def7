//! Takes plotly.js out of the source of the crate that carries it. That crate, with thirty others below it, need not be
//! compiled for a file: cargo says where it lies, and fetches it where it does not lie yet.

use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../Cargo.lock");
    let script = source_of("plotly").join("resource/plotly.min.js");
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    if let Err(error) = std::fs::copy(&script, folder.join("plotly.min.js")) {
        panic!("{} cannot be copied: {error}", script.display());
    }
}

/// The folder of the source of `package`, one of the workspace's dependencies.
fn source_of(package: &str) -> PathBuf {
    let cargo = std::env::var_os("CARGO").expect("cargo sets CARGO");
    let output = Command::new(cargo).args(["metadata", "--format-version", "1", "--locked"]).output();
    let output = output.unwrap_or_else(|error| panic!("cargo cannot be run: {error}"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "`cargo fetch` is needed first, with the network:\n{said}");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo writes JSON");
    let packages = metadata["packages"].as_array().into_iter().flatten();
    let manifest = packages
        .filter(|found| found["name"] == package)
        .find_map(|found| found["manifest_path"].as_str())
        .unwrap_or_else(|| panic!("`{package}` is no dependency any more"));
    Path::new(manifest).parent().expect("a manifest lies in a folder").to_path_buf()
}
