//! The committed header is the one that the functions make.

use crate::tools::folder;

fn header() -> String {
    let configuration = cbindgen::Config::from_file(folder().join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(configuration);
    // A file brings its modules along.
    for file in ["guard.rs", "object.rs", "exports/mod.rs"] {
        builder = builder.with_src(folder().join("src").join(file));
    }
    let mut text = Vec::new();
    builder.generate().unwrap().write(&mut text);
    String::from_utf8(text).unwrap()
}

/// `STICKSLIP_GOLDEN=write cargo test -p stickslip-capi header` writes it again.
#[test]
fn the_committed_header_is_fresh() {
    let (file, header) = (folder().join("include/stickslip.h"), header());
    if std::env::var_os("STICKSLIP_GOLDEN").is_some_and(|value| value == "write") {
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        return std::fs::write(&file, header).unwrap();
    }
    let committed = std::fs::read_to_string(&file).unwrap_or_default().replace("\r\n", "\n");
    assert_eq!(committed, header, "stickslip.h is stale: run `cargo xtask golden` and review the difference");
}

#[test]
#[cfg(target_os = "linux")]
fn every_exported_function_is_declared_once_in_the_header_and_no_other() {
    let Some(nm) = crate::tools::program(&["nm"]) else { return crate::external::skip("there is no nm") };
    let library = crate::tools::libraries().join("libstickslip_c.so");
    let listed =
        std::process::Command::new(nm).args(["--dynamic", "--defined-only"]).arg(library).output().unwrap();
    let listed = String::from_utf8(listed.stdout).unwrap();
    let mut exported: Vec<&str> = listed.lines().filter_map(|line| line.split_whitespace().last()).collect();
    exported.sort_unstable();
    let header = header();
    let mut declared: Vec<&str> = header
        .split(|c: char| !c.is_alphanumeric() && c != '_' && c != '(')
        .filter_map(|word| word.split_once('('))
        .map(|(name, _)| name)
        .filter(|name| name.starts_with("stickslip_"))
        .collect();
    declared.sort_unstable();
    assert_eq!(exported, declared);
}
