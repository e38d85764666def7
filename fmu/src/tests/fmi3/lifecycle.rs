//! Creation, errors and what comes after them, logging.

use super::fixture::{Importer, Running};
use crate::calls::State;
use crate::exports::lifecycle::{fmi2FreeInstance, fmi2Reset};
use crate::ffi::Status;
use crate::fmi3::calls::Function;
use crate::fmi3::lifecycle::*;
use crate::fmi3::stepping::fmi3DoStep;
use crate::guard::guarded;
use crate::tests::fixture::{DISPLACEMENT, FORCE, Importer as Importer2, JENKINS};
use std::ffi::CStr;
use std::ptr::{null, null_mut};
use stickslip::fmi::Stage;

#[test]
fn what_cannot_be_instantiated_gives_null_and_says_why() {
    let importer = Importer::new(JENKINS);
    let (path, token, name) = (importer.resources.path(), importer.token.as_ptr(), c"one".as_ptr());
    let wrong = c"{00000000-0000-0000-0000-000000000000}".as_ptr();
    let elsewhere = c"/no/such/folder/".as_ptr();
    for (name, token, path, event_mode, required, expected) in [
        (null(), token, path.as_ptr(), 0, &[][..], "instance name"),
        (c" ".as_ptr(), token, path.as_ptr(), 0, &[], "instance name"),
        (name, null(), path.as_ptr(), 0, &[], "instantiationToken is missing"),
        (name, wrong, path.as_ptr(), 0, &[], "instantiationToken is {00000000"),
        (name, token, null(), 0, &[], "resourcePath is missing"),
        (name, token, elsewhere, 0, &[], "model.toml cannot be read"),
        (name, token, path.as_ptr(), 1, &[], "hasEventMode is false"),
        (name, token, path.as_ptr(), 0, &[DISPLACEMENT, 7], "value reference 7 has no intermediateUpdate"),
        (name, token, path.as_ptr(), 0, &[1000], "value reference 1000 has no intermediateUpdate"),
    ] {
        let message = importer.refused(name, token, path, event_mode, required);
        assert!(message.starts_with("fmi3InstantiateCoSimulation: "), "{message}");
        assert!(message.contains(expected), "{message}");
    }
    let scheduled = unsafe {
        fmi3InstantiateScheduledExecution(
            name,
            token,
            path.as_ptr(),
            0,
            0,
            null_mut(),
            None,
            null(),
            null(),
            null(),
        )
    };
    assert!(scheduled.is_null());
    assert_eq!(unsafe { CStr::from_ptr(fmi3GetVersion()) }, c"3.0");
}

#[test]
fn a_logger_may_be_null_and_is_silent_where_logging_is_off() {
    let importer = Importer::new(JENKINS);
    let (path, token) = (importer.resources.path(), importer.token.as_ptr());
    unsafe {
        let handle =
            fmi3InstantiateModelExchange(c"one".as_ptr(), token, path.as_ptr(), 0, 1, null_mut(), None);
        assert!(!handle.is_null());
        assert_eq!(fmi3Terminate(handle), Status::Error);
        fmi3FreeInstance(handle);
    }
    let running = importer.slave();
    unsafe { assert_eq!(fmi3SetDebugLogging(running.handle, 0, 0, null()), Status::Ok) };
    let before = importer.messages.borrow().len();
    assert_eq!(unsafe { fmi3Terminate(running.handle) }, Status::Error);
    assert_eq!(importer.messages.borrow().len(), before);
}

fn stage(running: &Running<'_>) -> State {
    running.component().state()
}

#[test]
fn after_an_error_values_are_read_and_a_saved_state_or_a_reset_lets_it_go_on() {
    let importer = Importer::new(JENKINS);
    let running = importer.slave();
    running.initialize();
    running.set(DISPLACEMENT, 10e-6);
    assert_eq!(running.do_step(0.0, 1e-3), Status::Ok);
    let saved = running.bytes();
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(running.do_step(1e-3, step), Status::Error);
        assert!(importer.last().2.contains("communicationStepSize"), "{:?}", importer.last());
        assert_eq!(stage(&running), State::Stage(Stage::Terminated));
        assert_eq!(running.get(FORCE), 20.0);
        assert_eq!(running.do_step(1e-3, 1e-3), Status::Error);
        assert_eq!(running.set_bytes(&saved), Status::Ok);
    }
    assert_eq!(running.do_step(1e-3, 1e-3), Status::Ok);
    unsafe {
        let (mut event, mut early) = (0, 0);
        let status =
            fmi3DoStep(running.handle, 2e-3, 1e-3, 1, &mut event, null_mut(), &mut early, null_mut());
        assert_eq!(status, Status::Error);
        assert!(importer.last().2.contains("terminateSimulation is NULL"));
        assert_eq!(fmi3Reset(running.handle), Status::Ok);
    }
    running.initialize();
    assert_eq!((running.get(FORCE), running.do_step(0.0, 1e-3)), (0.0, Status::Ok));
}

#[test]
fn an_instance_is_of_one_version() {
    let (importer, older) = (Importer::new(JENKINS), Importer2::new(JENKINS));
    let (running, other) = (importer.slave(), older.component());
    unsafe {
        assert_eq!(fmi2Reset(running.handle), Status::Error);
        assert_eq!(fmi3Reset(other.handle), Status::Error);
        fmi2FreeInstance(running.handle);
        fmi3FreeInstance(other.handle);
        assert_eq!(fmi3Reset(running.handle), Status::Ok);
        assert_eq!(fmi2Reset(other.handle), Status::Ok);
        assert_eq!(fmi3Reset(null_mut()), Status::Error);
    }
}

#[test]
fn a_panic_is_fatal_and_the_instance_can_only_be_freed() {
    let importer = Importer::new(JENKINS);
    let running = importer.slave();
    running.initialize();
    assert_eq!(unsafe { guarded(running.handle, Function::DoStep, |_| panic!("index 7")) }, Status::Fatal);
    let (status, category, message) = importer.last();
    assert_eq!((status, category.as_str()), (4, "logStatusFatal"));
    assert!(
        message.starts_with("fmi3DoStep: internal error at ") && message.ends_with("index 7"),
        "{message}"
    );
    assert_eq!(running.do_step(0.0, 1.0), Status::Fatal);
    assert_eq!(stage(&running), State::Poisoned);
}
