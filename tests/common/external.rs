//! What is not everywhere: measurements with a licence of their own, a browser. A test that lacks it says so, and
//! `cargo xtask test` counts it as skipped.
#![allow(dead_code, reason = "each program uses a part")]

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A folder of the external data, which are in `STICKSLIP_DATA` or else in `../shared/data` beside the repository. Where
/// it is not, the test has been reported as skipped and has to return.
pub fn data(name: &str) -> Option<PathBuf> {
    let repository =
        Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().find(|up| up.join("Cargo.lock").is_file());
    let beside = || repository.expect("a workspace").join("../shared/data");
    let folder = std::env::var_os("STICKSLIP_DATA").map_or_else(beside, PathBuf::from).join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    skip(&format!("there is no {} (set STICKSLIP_DATA)", folder.display()));
    None
}

/// Reports the test that calls as skipped; once in a test, which then returns. One write to the standard error itself,
/// since the test harness hides what a passing test prints with macros.
pub fn skip(reason: &str) {
    let thread = std::thread::current();
    let line = format!("skipped: {}: {reason}\n", thread.name().unwrap_or("a test"));
    let _ = std::io::stderr().write_all(line.as_bytes());
}
