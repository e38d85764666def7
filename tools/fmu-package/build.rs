//! Stub.
fn main() {
    let out = std::path::PathBuf::from(std::env::var("OUT_DIR").unwrap_or_default()).join("empty.so");
    let _ = std::fs::write(&out, b"");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=STICKSLIP_FMU_LIBRARY={}", out.display());
    println!("cargo::rustc-env=STICKSLIP_FMU_PLATFORM=linux64");
    println!("cargo::rustc-env=STICKSLIP_FMU_EXTENSION=so");
}
