//! What is set, what is read, what is refused.

use super::fixture::*;
use crate::exports::lifecycle::*;
use crate::exports::states::{fmi2FreeFMUstate, fmi2GetFMUstate, fmi2SetFMUstate};
use crate::exports::stepping::*;
use crate::exports::values::*;
use crate::ffi::{LAST_SUCCESSFUL_TIME, Status, TERMINATED};
use std::ptr::{null, null_mut};

#[test]
fn a_contact_follows_the_law_through_stick_slip_and_separation() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    let mut time = 0.0;
    for (displacement, load, force, slip) in [
        (10e-6, 100.0, 20.0, 0),
        (40e-6, 100.0, 50.0, 1),
        (30e-6, 100.0, 30.0, 0),
        (30e-6, -1.0, 0.0, 2),
        (30e-6, 100.0, 0.0, 0),
    ] {
        running.set(DISPLACEMENT, displacement);
        running.set(NORMAL_LOAD, load);
        assert_eq!(running.do_step(time, 0.25), Status::Ok);
        time += 0.25;
        assert!((running.get(FORCE) - force).abs() < 1e-9, "{} != {force}", running.get(FORCE));
        assert_eq!(running.slip_state(), slip);
    }
    // 15 µm of slip at 50 N; the 30 N in the spring are lost as the contact opens.
    assert!(running.get(DISSIPATED_ENERGY) >= 50.0 * 15e-6);
}

#[test]
fn outputs_follow_inputs_and_parameters_in_initialization_without_a_trace() {
    let importer = Importer::new(JENKINS);
    let running = importer.component();
    unsafe { fmi2EnterInitializationMode(running.handle) };
    running.set(DISPLACEMENT, 1e-3);
    assert_eq!(running.get(FORCE), 50.0);
    running.set(DISPLACEMENT, 10e-6);
    assert_eq!(running.get(FORCE), 20.0);
    assert_eq!(running.get(DISSIPATED_ENERGY), 0.0);
    running.set(TANGENTIAL_STIFFNESS, 1e6);
    assert_eq!(running.get(FORCE), 10.0);
    assert_eq!(unsafe { fmi2ExitInitializationMode(running.handle) }, Status::Ok);
    assert_eq!(running.get(FORCE), 10.0);
}

#[test]
fn outputs_stay_until_the_next_step() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    running.set(DISPLACEMENT, 10e-6);
    assert_eq!(running.get(FORCE), 0.0);
    assert_eq!(running.get(DISPLACEMENT), 10e-6);
    running.do_step(0.0, 1.0);
    assert_eq!(running.get(FORCE), 20.0);
}

#[test]
fn refused_values_name_the_variable_and_change_nothing() {
    let importer = Importer::new(VALANIS);
    let running = importer.component();
    let before = running.bytes();
    for (reference, value, name) in [
        (DISPLACEMENT, f64::NAN, "displacement"),
        (VELOCITY, f64::INFINITY, "velocity"),
        (NORMAL_LOAD, f64::NEG_INFINITY, "normal_load"),
        (DISPLACEMENT, 1e40, "displacement"),
        (FORCE, 1.0, "force"),
        (TANGENTIAL_STIFFNESS, 0.0, "tangential_stiffness"),
        (FRICTION_COEFFICIENT, -1.0, "friction_coefficient"),
        (9, 1.0, "smoothness"),
        (10, -1.0, "residual_stiffness"),
        (SLIP_STATE, 1.0, "slip_state"),
        (11, 1.0, "value reference 11"),
        (u32::MAX, 1.0, "value reference 4294967295"),
    ] {
        // With a legal value in front, to see that all or none are set.
        let (references, values) = ([DISPLACEMENT, reference], [5e-6, value]);
        let status = unsafe { fmi2SetReal(running.handle, references.as_ptr(), 2, values.as_ptr()) };
        assert_eq!(status, Status::Error, "{name} = {value}");
        assert!(running.error().contains(name), "{}", running.error());
        assert_eq!(running.bytes(), before, "{name}");
    }
    // Zero smoothness is legal although the interval is called open.
    assert_eq!(running.set(9, 0.0), Status::Ok);
}

#[test]
fn parameters_that_make_no_model_are_named_and_can_be_corrected() {
    let importer = Importer::new(VALANIS);
    let running = importer.component();
    assert_eq!(running.set(10, 3e6), Status::Ok);
    unsafe {
        assert_eq!(fmi2EnterInitializationMode(running.handle), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(running.handle), Status::Error);
        assert!(running.error().contains("residual_stiffness"), "{}", running.error());
        assert_eq!(fmi2GetReal(running.handle, &FORCE, 1, &mut 0.0), Status::Error);
        assert_eq!(running.set(10, 1e5), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(running.handle), Status::Ok);
    }
}

#[test]
fn fixed_parameters_are_settled_when_the_initialization_ends() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    assert_eq!(running.set(FRICTION_COEFFICIENT, 0.4), Status::Error);
    assert!(running.error().contains("friction_coefficient"));
    assert_eq!(running.get(FRICTION_COEFFICIENT), 0.5);
}

#[test]
fn values_of_another_type_are_refused_by_name() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    let (mut real, mut integer, mut text) = (0.0, 0, null());
    unsafe {
        let handle = running.handle;
        for status in [
            fmi2GetReal(handle, &SLIP_STATE, 1, &mut real),
            fmi2SetReal(handle, &SLIP_STATE, 1, &real),
            fmi2SetInteger(handle, &SLIP_STATE, 1, &integer),
            fmi2GetBoolean(handle, &SLIP_STATE, 1, &mut integer),
            fmi2GetString(handle, &SLIP_STATE, 1, &mut text),
        ] {
            assert_eq!(status, Status::Error);
            assert!(running.error().contains("slip_state"), "{}", running.error());
        }
        for status in [
            fmi2GetInteger(handle, &FORCE, 1, &mut integer),
            fmi2SetInteger(handle, &FORCE, 1, &integer),
            fmi2SetBoolean(handle, &FORCE, 1, &integer),
            fmi2SetString(handle, &FORCE, 1, &text),
        ] {
            assert_eq!(status, Status::Error);
            assert!(running.error().contains("force"), "{}", running.error());
        }
        assert_eq!(fmi2GetBoolean(handle, &99, 1, &mut integer), Status::Error);
        assert!(running.error().contains("99"));
    }
}

#[test]
fn null_arrays_are_refused_unless_empty() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    unsafe {
        let handle = running.handle;
        assert_eq!(fmi2GetReal(handle, null(), 0, null_mut()), Status::Ok);
        assert_eq!(fmi2SetReal(handle, null(), 0, null()), Status::Ok);
        assert_eq!(fmi2GetReal(handle, null(), 1, &mut 0.0), Status::Error);
        assert_eq!(fmi2GetReal(handle, &FORCE, 1, null_mut()), Status::Error);
        assert_eq!(fmi2GetReal(handle, &FORCE, usize::MAX, &mut 0.0), Status::Error);
    }
}

#[test]
fn impossible_steps_are_refused_and_change_nothing() {
    let importer = Importer::new(JENKINS);
    let running = importer.component();
    unsafe {
        assert_eq!(fmi2SetupExperiment(running.handle, 1, 1e-6, 1.0, -1, 2.0), Status::Ok);
        fmi2EnterInitializationMode(running.handle);
        fmi2ExitInitializationMode(running.handle);
    }
    running.set(DISPLACEMENT, 10e-6);
    let before = running.bytes();
    for (time, step, argument) in [
        (1.0, 0.0, "communicationStepSize"),
        (1.0, -0.1, "communicationStepSize"),
        (1.0, f64::NAN, "communicationStepSize"),
        (1.0, f64::INFINITY, "communicationStepSize"),
        (f64::NAN, 0.1, "currentCommunicationPoint"),
        (1.5, 0.1, "currentCommunicationPoint"),
        (0.0, 0.1, "currentCommunicationPoint"),
        (1.0, 1.5, "stop time"),
    ] {
        assert_eq!(running.do_step(time, step), Status::Error, "{time} {step}");
        assert!(running.error().contains(argument), "{}", running.error());
        assert_eq!(running.bytes(), before);
    }
    // Any positive step, each different.
    assert_eq!(running.do_step(1.0, 1e-9), Status::Ok);
    assert_eq!(running.do_step(1.0 + 1e-9, 0.25), Status::Ok);
    assert_eq!(running.do_step(1.25 + 1e-9, 0.75 - 1e-9), Status::Ok);
    assert_eq!(running.get(FORCE), 20.0);
}

#[test]
fn after_a_jump_to_another_state_the_status_is_that_of_the_step_that_led_there() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    let status = || {
        let mut status = -1;
        assert_eq!(unsafe { fmi2GetStatus(running.handle, 0, &mut status) }, Status::Ok);
        status
    };
    running.do_step(0.0, 0.5);
    let mut saved = null_mut();
    assert_eq!(unsafe { fmi2GetFMUstate(running.handle, &mut saved) }, Status::Ok);
    assert_eq!((running.do_step(0.5, -1.0), status()), (Status::Error, Status::Error as i32));
    assert_eq!(unsafe { fmi2SetFMUstate(running.handle, saved) }, Status::Ok);
    assert_eq!(status(), Status::Ok as i32);
    assert_eq!((running.do_step(0.5, -1.0), status()), (Status::Error, Status::Error as i32));
    unsafe {
        assert_eq!(fmi2FreeFMUstate(running.handle, &mut saved), Status::Ok);
        assert_eq!(fmi2Reset(running.handle), Status::Ok);
        fmi2EnterInitializationMode(running.handle);
        fmi2ExitInitializationMode(running.handle);
    }
    assert_eq!(status(), Status::Ok as i32);
}

#[test]
fn the_status_functions_report_the_last_step() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    running.do_step(0.0, 0.5);
    let (mut time, mut status, mut terminated) = (0.0, -1, -1);
    unsafe {
        let handle = running.handle;
        assert_eq!(fmi2GetRealStatus(handle, LAST_SUCCESSFUL_TIME, &mut time), Status::Ok);
        assert_eq!(fmi2GetStatus(handle, 0, &mut status), Status::Ok);
        assert_eq!(fmi2GetBooleanStatus(handle, TERMINATED, &mut terminated), Status::Ok);
        assert_eq!((time, status, terminated), (0.5, 0, 0));
        assert_eq!(fmi2GetIntegerStatus(handle, 0, &mut status), Status::Discard);
        assert_eq!(fmi2GetRealStatus(handle, 99, &mut time), Status::Error);
        assert_eq!(fmi2GetRealStatus(handle, LAST_SUCCESSFUL_TIME, null_mut()), Status::Error);
        fmi2Terminate(handle);
        assert_eq!(fmi2GetBooleanStatus(handle, TERMINATED, &mut terminated), Status::Ok);
        assert_eq!(terminated, 1);
    }
}
