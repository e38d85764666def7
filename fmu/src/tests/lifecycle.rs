//! Creation, logging, threads, many instances, many resets.

use super::fixture::*;
use crate::exports::lifecycle::*;
use crate::exports::stepping::*;
use crate::exports::values::{fmi2GetReal, fmi2SetReal};
use crate::ffi::{CO_SIMULATION, CallbackFunctions, Handle, Status};
use std::ffi::{CStr, CString, c_int};
use std::ptr::{null, null_mut};

fn text(pointer: *const std::ffi::c_char) -> String {
    unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned()
}

#[test]
fn version_and_platform_are_those_of_fmi_2() {
    assert_eq!(text(fmi2GetVersion()), "2.0");
    assert_eq!(text(fmi2GetTypesPlatform()), "default");
}

#[test]
fn what_cannot_be_instantiated_gives_null_and_one_message() {
    let importer = Importer::new(JENKINS);
    let uri = importer.resources.uri();
    let elsewhere = c"file:///no/such/folder";
    let broken = Resources::new("schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = 3\n");
    let broken_uri = broken.uri();
    let (name, guid, uri) = (c"one".as_ptr(), importer.guid.as_ptr(), uri.as_ptr());
    let wrong = c"{00000000-0000-0000-0000-000000000000}".as_ptr();
    let cases = [
        (null(), CO_SIMULATION, guid, uri, "instance name"),
        (c"".as_ptr(), CO_SIMULATION, guid, uri, "instance name"),
        (name, 2, guid, uri, "fmuType is 2"),
        (name, 77, guid, uri, "fmuType is 77"),
        (name, CO_SIMULATION, null(), uri, "GUID is missing"),
        (name, CO_SIMULATION, wrong, uri, "GUID is {00000000"),
        (name, CO_SIMULATION, guid, null(), "fmuResourceLocation is missing"),
        (name, CO_SIMULATION, guid, elsewhere.as_ptr(), "model.toml cannot be read"),
        (name, CO_SIMULATION, guid, c"http://x".as_ptr(), "not a file URI"),
        (name, CO_SIMULATION, guid, broken_uri.as_ptr(), "line 4"),
    ];
    for (name, fmu_type, guid, uri, expected) in cases {
        let before = importer.count();
        let handle = unsafe { fmi2Instantiate(name, fmu_type, guid, uri, &importer.callbacks, 0, 0) };
        assert!(handle.is_null(), "{expected}");
        assert_eq!(importer.count(), before + 1, "{expected}");
        let (status, category, message) = importer.last();
        assert_eq!((status, category.as_str()), (3, "logStatusError"));
        assert!(message.starts_with("fmi2Instantiate: ") && message.contains(expected), "{message}");
    }
}

#[test]
fn a_model_file_changed_after_export_is_refused() {
    let importer = Importer::new(JENKINS);
    let changed = Resources::new(&JENKINS.replace("0.5", "0.6"));
    let uri = changed.uri();
    let handle = unsafe {
        let (name, guid) = (c"one".as_ptr(), importer.guid.as_ptr());
        fmi2Instantiate(name, CO_SIMULATION, guid, uri.as_ptr(), &importer.callbacks, 0, 0)
    };
    assert!(handle.is_null());
    assert!(importer.last().2.contains("GUID"));
}

#[test]
fn callbacks_may_be_null_one_by_one_or_all() {
    let importer = Importer::new(JENKINS);
    let uri = importer.resources.uri();
    let without_logger = CallbackFunctions { logger: None, ..importer.callbacks };
    for callbacks in [null(), &raw const without_logger] {
        unsafe {
            let (name, guid) = (c"one".as_ptr(), importer.guid.as_ptr());
            let handle = fmi2Instantiate(name, CO_SIMULATION, guid, uri.as_ptr(), callbacks, 0, 1);
            assert!(!handle.is_null());
            assert_eq!(fmi2DoStep(handle, 0.0, 1.0, 1), Status::Error);
            assert_eq!(fmi2SetReal(handle, &DISPLACEMENT, 1, &f64::NAN), Status::Error);
            fmi2FreeInstance(handle);
        }
    }
}

#[test]
fn the_guid_is_compared_as_a_number_not_as_text() {
    let mut importer = Importer::new(JENKINS);
    let upper = importer.guid.to_str().unwrap().to_uppercase();
    importer.guid = CString::new(upper.trim_matches(['{', '}'])).unwrap();
    let _ = importer.component();
}

#[test]
fn null_and_foreign_handles_are_errors() {
    let mut foreign = [0x5a_u64; 64];
    for handle in [null_mut(), (&raw mut foreign).cast()] {
        let handle: Handle = handle;
        unsafe {
            assert_eq!(fmi2DoStep(handle, 0.0, 1.0, 1), Status::Error);
            assert_eq!(fmi2GetReal(handle, null(), 0, null_mut()), Status::Error);
            assert_eq!(fmi2Reset(handle), Status::Error);
            fmi2FreeInstance(handle);
        }
    }
    assert_eq!(foreign, [0x5a; 64]);
}

#[test]
fn events_are_logged_only_when_wanted_and_failures_by_default() {
    let importer = Importer::new(JENKINS);
    let quiet = importer.running();
    assert_eq!(importer.count(), 0);
    assert_eq!(quiet.do_step(0.0, 0.0), Status::Error);
    assert_eq!(importer.count(), 1);

    // Any nonzero number is true.
    let handle = importer.instantiate(-7);
    unsafe { fmi2FreeInstance(handle) };
    let messages = importer.messages.lock().unwrap();
    let events: Vec<&str> = messages[1..].iter().map(|(_, category, _)| category.as_str()).collect();
    assert_eq!(events, ["logEvents", "logEvents"]);
}

#[test]
fn log_categories_are_respected() {
    let importer = Importer::new(JENKINS);
    let running = importer.component();
    let configure = |on: c_int, categories: &[&CStr]| {
        let pointers: Vec<_> = categories.iter().map(|category| category.as_ptr()).collect();
        unsafe { fmi2SetDebugLogging(running.handle, on, pointers.len(), pointers.as_ptr()) }
    };
    let heard = |action: &dyn Fn()| {
        let before = importer.count();
        action();
        importer.count() - before
    };
    let fail = || assert_eq!(running.do_step(0.0, 1.0), Status::Error);
    let event = || assert_eq!(unsafe { fmi2Reset(running.handle) }, Status::Ok);

    for (on, categories, failures, events) in [
        (1, &[c"logEvents"][..], 0, 1),
        (1, &[c"logStatusError"], 1, 0),
        (1, &[c"logAll"], 1, 1),
        (0, &[c"logEvents"], 1, 0),
        (1, &[], 1, 1),
        (0, &[], 0, 0),
    ] {
        assert_eq!(configure(on, categories), Status::Ok);
        assert_eq!((heard(&fail), heard(&event)), (failures, events), "{on} {categories:?}");
    }
    configure(1, &[]);
    assert_eq!(configure(1, &[c"logEvents", c"logWeather"]), Status::Error);
    assert!(running.error().contains("logWeather"));
    assert_eq!(heard(&fail), 1, "a refused configuration changes nothing");
    assert_eq!(unsafe { fmi2SetDebugLogging(running.handle, 1, 2, null()) }, Status::Error);
    assert_eq!(unsafe { fmi2SetDebugLogging(running.handle, 1, 1, &null()) }, Status::Error);
}

#[test]
fn experiments_with_impossible_numbers_are_refused_and_change_nothing() {
    let importer = Importer::new(JENKINS);
    let running = importer.component();
    let before = running.bytes();
    for (tolerance, start, stop, argument) in [
        (f64::NAN, 0.0, 1.0, "tolerance"),
        (0.0, 0.0, 1.0, "tolerance"),
        (1e-6, f64::INFINITY, 1.0, "startTime"),
        (1e-6, 2.0, 1.0, "stopTime"),
        (1e-6, 0.0, f64::NAN, "stopTime"),
    ] {
        let status = unsafe { fmi2SetupExperiment(running.handle, 1, tolerance, start, 1, stop) };
        assert_eq!(status, Status::Error);
        assert!(running.error().contains(argument));
        assert_eq!(running.bytes(), before);
    }
    // What is not defined is not looked at.
    assert_eq!(unsafe { fmi2SetupExperiment(running.handle, 0, f64::NAN, 1.0, 0, f64::NAN) }, Status::Ok);
}

#[test]
fn a_component_may_move_from_thread_to_thread() {
    struct Moved(Handle);
    unsafe impl Send for Moved {}
    let importer = Importer::new(JENKINS);
    let uri = importer.resources.uri();
    let guid = importer.guid.clone();
    let create = move || unsafe {
        let (name, guid) = (c"one".as_ptr(), guid.as_ptr());
        Moved(fmi2Instantiate(name, CO_SIMULATION, guid, uri.as_ptr(), null(), 0, 0))
    };
    let moved = std::thread::spawn(create).join().unwrap();
    let step = |moved: Moved| unsafe {
        assert_eq!(fmi2EnterInitializationMode(moved.0), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(moved.0), Status::Ok);
        assert_eq!(fmi2SetReal(moved.0, &DISPLACEMENT, 1, &40e-6), Status::Ok);
        assert_eq!(fmi2DoStep(moved.0, 0.0, 1.0, 1), Status::Ok);
        let mut force = 0.0;
        assert_eq!(fmi2GetReal(moved.0, &FORCE, 1, &mut force), Status::Ok);
        assert_eq!(force, 50.0);
        moved
    };
    let moved = std::thread::spawn(move || step(moved)).join().unwrap();
    let free = |moved: Moved| unsafe { fmi2FreeInstance(moved.0) };
    std::thread::spawn(move || free(moved)).join().unwrap();
}

#[test]
fn a_thousand_instances_do_not_touch_each_other() {
    let importer = Importer::new(JENKINS);
    let all: Vec<Running<'_>> = (0..1000).map(|_| importer.running()).collect();
    for (index, running) in all.iter().enumerate() {
        running.set(DISPLACEMENT, 1e-9 * index as f64);
        assert_eq!(running.do_step(0.0, 1e-3), Status::Ok);
    }
    for (index, running) in all.iter().enumerate() {
        assert_eq!(running.get(FORCE), 2e6 * (1e-9 * index as f64));
    }
}

#[test]
fn a_reset_forgets_values_parameters_and_history() {
    let importer = Importer::new(JENKINS);
    let running = importer.component();
    let fresh = running.bytes();
    assert_eq!(running.set(FRICTION_COEFFICIENT, 0.1), Status::Ok);
    running.initialize();
    running.set(DISPLACEMENT, 1e-4);
    running.do_step(0.0, 1.0);
    assert_eq!(running.get(FORCE), 10.0);
    assert_eq!(unsafe { fmi2Reset(running.handle) }, Status::Ok);
    assert_eq!(running.bytes(), fresh);
    running.initialize();
    assert_eq!(running.get(FORCE), 0.0);
    running.set(DISPLACEMENT, 1e-4);
    running.do_step(0.0, 1.0);
    assert_eq!(running.get(FORCE), 50.0);
}

/// The model that a GUID names is given to whoever asks for it again, and to nobody else.
#[test]
fn a_model_is_read_once_and_another_at_the_same_place_is_not_taken_for_it() {
    let importer = Importer::new(JENKINS);
    let uri = importer.resources.uri();
    let instantiate = |guid: &CStr| unsafe {
        let name = c"one".as_ptr();
        fmi2Instantiate(name, CO_SIMULATION, guid.as_ptr(), uri.as_ptr(), &importer.callbacks, 0, 0)
    };
    let first = instantiate(&importer.guid);
    assert!(!first.is_null());
    let file = crate::location::directory(uri.to_bytes()).unwrap().join("model.toml");
    std::fs::write(&file, VALANIS).unwrap();
    let second = instantiate(&importer.guid);
    assert!(!second.is_null(), "read a second time");
    assert!(instantiate(c"{00000000-0000-0000-0000-000000000000}").is_null());
    // The file is another model now, under a GUID of its own.
    let other = CString::new(stickslip::fmi::Instance::new(VALANIS).unwrap().guid().to_string()).unwrap();
    let third = instantiate(&other);
    let name = |handle: Handle| {
        let component = handle.cast::<crate::guard::Component>();
        unsafe { (*component).instance.description().name }
    };
    assert_eq!([first, second, third].map(name), ["JenkinsContact", "JenkinsContact", "ValanisContact"]);
    // Parameters of one instance are none of another's.
    unsafe {
        assert_eq!(fmi2SetReal(first, &FRICTION_COEFFICIENT, 1, &0.1), Status::Ok);
        let mut value = 0.0;
        let fourth = instantiate(&importer.guid);
        for handle in [second, fourth] {
            assert_eq!(fmi2EnterInitializationMode(handle), Status::Ok);
            assert_eq!(fmi2GetReal(handle, &FRICTION_COEFFICIENT, 1, &mut value), Status::Ok);
            assert_eq!(value, 0.5);
        }
        [first, second, third, fourth].into_iter().for_each(|handle| fmi2FreeInstance(handle));
    }
}
