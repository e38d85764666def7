//! The C interface into a prefix: header, both libraries, pkg-config file, CMake package.

use std::fs;
use std::path::{Path, PathBuf};

use crate::{cargo, root, target};

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// What a program that is linked with the static library needs besides (`rustc --print native-static-libs`).
const SYSTEM_LIBRARIES: [&str; 6] = ["gcc_s", "util", "rt", "pthread", "m", "dl"];

/// Installs into the prefix that `arguments` name: `PREFIX`, or `PREFIX --libraries FOLDER` for libraries that are built already.
pub fn install(arguments: &[String]) -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        return Err("the C interface is installed on Linux only".to_owned());
    }
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (prefix, libraries) = match words[..] {
        [prefix] => (Path::new(prefix), built()?),
        [prefix, "--libraries", folder] => (Path::new(prefix), PathBuf::from(folder)),
        _ => return Err("usage: cargo xtask install PREFIX [--libraries FOLDER]".to_owned()),
    };
    let library = prefix.join("lib");
    let source = root().join("capi");
    copy(&source.join("include/stickslip.h"), &prefix.join("include/stickslip.h"))?;
    copy(&libraries.join("libstickslip_c.a"), &library.join("libstickslip.a"))?;
    let shared = format!("libstickslip.so.{VERSION}");
    copy(&libraries.join("libstickslip_c.so"), &library.join(&shared))?;
    link(&shared, &library.join(format!("libstickslip.so.{}", major())))?;
    link(&shared, &library.join("libstickslip.so"))?;
    fill(&source.join("stickslip.pc"), &library.join("pkgconfig/stickslip.pc"), "-l", " ")?;
    for name in ["stickslip-config.cmake", "stickslip-config-version.cmake"] {
        fill(&source.join(name), &library.join("cmake/stickslip").join(name), "", ";")?;
    }
    println!("the C interface is in {}", prefix.display());
    Ok(())
}

/// Builds both libraries; where they are.
fn built() -> Result<PathBuf, String> {
    cargo(&["build", "--locked", "--package", "stickslip-capi", "--profile", "fmu"], &[])?;
    Ok(target().join("fmu"))
}

fn major() -> &'static str {
    env!("CARGO_PKG_VERSION_MAJOR")
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    make_folder_of(to)?;
    fs::copy(from, to).map_err(|error| format!("{}: {error}", from.display())).map(drop)
}

/// A template with what stands between `@` filled in; names of libraries with `before` each, `between` them.
fn fill(from: &Path, to: &Path, before: &str, between: &str) -> Result<(), String> {
    let text = fs::read_to_string(from).map_err(|error| format!("{}: {error}", from.display()))?;
    let libraries = SYSTEM_LIBRARIES.map(|name| format!("{before}{name}")).join(between);
    let text = text.replace("@VERSION@", VERSION).replace("@MAJOR@", major());
    let text =
        text.replace("@MINOR@", env!("CARGO_PKG_VERSION_MINOR")).replace("@SYSTEM_LIBRARIES@", &libraries);
    make_folder_of(to)?;
    fs::write(to, text).map_err(|error| format!("{}: {error}", to.display()))
}

fn make_folder_of(file: &Path) -> Result<(), String> {
    let folder = file.parent().unwrap_or(file);
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))
}

#[cfg(unix)]
fn link(to: &str, at: &Path) -> Result<(), String> {
    if at.is_symlink() {
        fs::remove_file(at).map_err(|error| format!("{}: {error}", at.display()))?;
    }
    std::os::unix::fs::symlink(to, at).map_err(|error| format!("{}: {error}", at.display()))
}

#[cfg(not(unix))]
fn link(_: &str, at: &Path) -> Result<(), String> {
    Err(format!("{}: no links on this system", at.display()))
}
