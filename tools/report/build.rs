//! Takes plotly.js out of the source of the crate that carries it. That crate, with thirty others below it, need not be
//! compiled for a file: cargo says where it lies, and fetches it where it does not lie yet. It is cut to what the pages
//! draw and packed, since every page carries it.

#[path = "build/bundle.rs"]
mod bundle;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use base64::prelude::{BASE64_STANDARD, Engine};
use flate2::Compression;
use flate2::write::ZlibEncoder;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rerun-if-changed=../../Cargo.lock");
    let script = source_of("plotly").join("resource/plotly.min.js");
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let text = std::fs::read_to_string(&script);
    let text = text.unwrap_or_else(|error| panic!("{} cannot be read: {error}", script.display()));
    let target = folder.join("plotly.packed");
    if let Err(error) = std::fs::write(&target, packed(&bundle::cut(&text))) {
        panic!("{} cannot be written: {error}", target.display());
    }
}

/// The licence at the head of `script` as it is, and all of it as the page's script unpacks it.
fn packed(script: &str) -> String {
    let (licence, _) = script.split_once("*/").expect("plotly.js begins with its licence");
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(script.as_bytes()).expect("memory takes everything");
    let bytes = encoder.finish().expect("memory takes everything");
    format!("{licence}*/\n{}", BASE64_STANDARD.encode(bytes))
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
