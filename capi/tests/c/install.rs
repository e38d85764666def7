//! What `cargo xtask install` leaves in a prefix, found by pkg-config and by CMake.

use crate::external::skip;
use crate::tools::{folder, libraries, output_of, program};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A prefix with the C interface, moved after it was installed: nothing in it names its place.
fn installed(under: &Path) -> PathBuf {
    let (first, moved) = (under.join("first"), under.join("prefix"));
    let mut install = Command::new(env!("CARGO"));
    install.args(["run", "--quiet", "--package", "xtask", "--", "install"]).arg(&first);
    install.arg("--libraries").arg(libraries()).current_dir(folder());
    let done = install.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    std::fs::rename(first, &moved).unwrap();
    moved
}

fn runs(example: &Path) {
    let printed = output_of(Command::new(example).arg(folder().join("examples/friction.toml")));
    assert!(printed.contains("J of work in a cycle"), "{printed}");
}

#[test]
fn the_interface_is_found_by_pkg_config_and_cmake_in_a_prefix_that_was_moved() {
    let Some(compiler) = program(&["cc", "gcc", "clang"]) else { return skip("there is no C compiler") };
    let made = tempfile::tempdir().unwrap();
    let prefix = installed(made.path());
    by_pkg_config(&compiler, &prefix, made.path());
    by_cmake(&prefix, made.path());
}

fn by_pkg_config(compiler: &Path, prefix: &Path, made: &Path) {
    let Some(tool) = program(&["pkg-config", "pkgconf"]) else { return skip("there is no pkg-config") };
    for statically in [false, true] {
        let mut flags = Command::new(&tool);
        flags.args(["--cflags", "--libs", "stickslip"]).env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
        if statically {
            flags.arg("--static");
        }
        let flags = output_of(&mut flags);
        let example = made.join(format!("by-pkg-config-{statically}"));
        let mut compile = Command::new(compiler);
        compile.args(["-std=c11", "-o"]).arg(&example).arg(folder().join("examples/newton.c"));
        let words = flags.split_whitespace();
        compile.args(
            words.map(|word| if statically && word == "-lstickslip" { "-l:libstickslip.a" } else { word }),
        );
        output_of(compile.arg("-lm").arg(format!("-Wl,-rpath,{}", prefix.join("lib").display())));
        runs(&example);
    }
}

fn by_cmake(prefix: &Path, made: &Path) {
    let Some(cmake) = program(&["cmake"]) else {
        return skip("there is no CMake (`cargo xtask test` fetches it)");
    };
    let (source, build) = (folder().join("examples"), made.join("build"));
    let mut configure = Command::new(&cmake);
    configure.arg("-S").arg(&source).arg("-B").arg(&build);
    output_of(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display())));
    output_of(Command::new(&cmake).arg("--build").arg(&build));
    runs(&build.join("newton"));
    runs(&build.join("newton_static"));
}
