//! A panic stays inside, reaches the logger and not standard error, and poisons the instance.

use super::fixture::{Importer, JENKINS};
use crate::calls::Function;
use crate::ffi::Status;
use crate::guard::guarded;

#[test]
fn a_panic_is_fatal_is_logged_and_poisons_only_its_instance() {
    let importer = Importer::new(JENKINS);
    let (broken, whole) = (importer.running(), importer.running());
    let status = unsafe { guarded(broken.handle, Function::DoStep, |_| panic!("index {}", 7)) };
    assert_eq!(status, Status::Fatal);
    let (status, category, message) = importer.last();
    assert_eq!((status, category.as_str()), (4, "logStatusFatal"));
    assert!(message.starts_with("fmi2DoStep: internal error at "), "{message}");
    assert!(message.contains("panics.rs") && message.ends_with("index 7"), "{message}");
    assert_eq!(broken.do_step(0.0, 1.0), Status::Fatal);
    assert_eq!(whole.do_step(0.0, 1.0), Status::Ok);
}

/// Runs in a process of its own, started by the test below.
#[test]
fn child_that_panics_inside_and_outside() {
    if std::env::var_os("STICKSLIP_PANICKING_CHILD").is_none() {
        return;
    }
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    unsafe { guarded(running.handle, Function::DoStep, |_| panic!("kept to ourselves")) };
    let _ = std::panic::catch_unwind(|| panic!("heard by all"));
}

#[test]
fn only_panics_outside_reach_standard_error() {
    let program = std::env::current_exe().unwrap();
    let output = std::process::Command::new(program)
        .args(["--exact", "tests::panics::child_that_panics_inside_and_outside", "--nocapture"])
        .env("STICKSLIP_PANICKING_CHILD", "1")
        .output()
        .unwrap();
    assert!(output.status.success());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("heard by all") && !errors.contains("kept to ourselves"), "{errors}");
}
