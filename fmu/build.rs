//! Strips the library where the linker is GNU's or LLVM's: cargo keeps the symbols of a library, and every FMU carries them.
//! A library for Windows would also carry the second of its linking: without it the same sources give the same bytes.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let of_target = |name: &str| env::var(format!("CARGO_CFG_TARGET_{name}")).unwrap_or_default();
    match (of_target("OS").as_str(), of_target("ENV").as_str()) {
        ("linux", _) => println!("cargo::rustc-cdylib-link-arg=-Wl,--strip-all"),
        ("windows", "gnu") => println!("cargo::rustc-cdylib-link-arg=-Wl,--no-insert-timestamp"),
        _ => {}
    }
}
