//! Types, arrays, time and indicators, derivatives.

use super::fixture::{Importer, Running};
use crate::ffi::Status;
use crate::fmi3::lifecycle::fmi3EnterInitializationMode;
use crate::fmi3::model_exchange::*;
use crate::fmi3::partial::*;
use crate::fmi3::stepping::fmi3GetOutputDerivatives;
use crate::fmi3::values::*;
use crate::tests::fixture::*;
use std::ptr::{null, null_mut};

const BEAM: &str = include_str!("../../../../modelDescription/FrictionalBeam.toml");

/// The value reference of a variable, in the table or beyond.
fn reference(running: &Running<'_>, name: &str) -> u32 {
    let description = running.component().instance.description();
    let beyond = || description.further().iter().position(|other| other.name == name);
    let place = description.reference(name);
    place.unwrap_or_else(|| (description.variables.len() + beyond().expect(name)) as u32)
}

fn get(running: &Running<'_>, references: &[u32], count: usize) -> Vec<f64> {
    let mut values = vec![f64::NAN; count];
    let (handle, into) = (running.handle, values.as_mut_ptr());
    let status = unsafe { fmi3GetFloat64(handle, references.as_ptr(), references.len(), into, count) };
    assert_eq!(status, Status::Ok, "{:?}", running.importer.last());
    values
}

/// A beam in motion.
fn beam(importer: &Importer) -> Running<'_> {
    let running = importer.slave();
    running.initialize();
    for step in 0..20 {
        running.set(0, 50.0 * f64::from(step));
        assert_eq!(running.do_step(1e-4 * f64::from(step), 1e-4), Status::Ok);
    }
    running
}

#[test]
fn the_slip_state_is_an_enumeration_and_nothing_else_is() {
    let importer = Importer::new(JENKINS);
    let running = importer.slave();
    running.initialize();
    running.set(DISPLACEMENT, 1e-3);
    running.do_step(0.0, 1.0);
    let mut state = -1;
    assert_eq!(unsafe { fmi3GetInt64(running.handle, &SLIP_STATE, 1, &mut state, 1) }, Status::Ok);
    assert_eq!(state, 1);
    let saved = running.bytes();
    let refused = |status: Status, expected: &str| {
        assert_eq!(status, Status::Error, "{expected}");
        assert!(importer.last().2.contains(expected), "{:?}", importer.last());
        assert_eq!(running.set_bytes(&saved), Status::Ok);
    };
    let (handle, unknown) = (running.handle, 1000);
    unsafe {
        let (mut real, mut int, mut flag) = (0.0, 0, 0);
        refused(
            fmi3GetFloat64(handle, &SLIP_STATE, 1, &mut real, 1),
            "slip_state is Enumeration, not Float64",
        );
        refused(fmi3GetInt64(handle, &FORCE, 1, &mut state, 1), "force is Float64, not Int64");
        refused(fmi3GetInt32(handle, &SLIP_STATE, 1, &mut int, 1), "slip_state is Enumeration, not Int32");
        refused(fmi3GetBoolean(handle, &FORCE, 1, &mut flag, 1), "force is Float64, not Boolean");
        refused(fmi3SetInt64(handle, &SLIP_STATE, 1, &0, 1), "slip_state cannot be set: it is an output");
        refused(
            fmi3GetFloat64(handle, &unknown, 1, &mut real, 1),
            "no variable has the value reference 1000",
        );
        refused(
            fmi3GetString(handle, &unknown, 1, null_mut(), 1),
            "no variable has the value reference 1000",
        );
        refused(fmi3GetFloat64(handle, &FORCE, 1, null_mut(), 1), "values is NULL");
        refused(fmi3GetFloat64(handle, null(), 1, &mut real, 1), "valueReferences is NULL");
        refused(fmi3GetFloat64(handle, &FORCE, 1, &mut real, 0), "1 value references, but 0 values");
        refused(fmi3SetFloat64(handle, &FORCE, 1, &1.0, 1), "force cannot be set: it is an output");
        let time = reference(&running, "time");
        refused(fmi3SetFloat64(handle, &time, 1, &1.0, 1), "time cannot be set");
        refused(fmi3GetInt64(handle, &time, 1, &mut state, 1), "time is Float64, not Int64");
    }
}

#[test]
fn refused_values_are_discarded_and_change_nothing() {
    let importer = Importer::new(JENKINS);
    let running = importer.slave();
    let before = running.bytes();
    for (reference, value, name) in [
        (DISPLACEMENT, f64::NAN, "displacement"),
        (NORMAL_LOAD, f64::INFINITY, "normal_load"),
        (TANGENTIAL_STIFFNESS, -1.0, "tangential_stiffness"),
    ] {
        let (references, values) = ([DISPLACEMENT, reference], [1.0, value]);
        let status = unsafe { fmi3SetFloat64(running.handle, references.as_ptr(), 2, values.as_ptr(), 2) };
        assert_eq!(status, Status::Discard);
        assert!(importer.last().2.contains(name), "{:?}", importer.last());
        assert_eq!(running.bytes(), before);
    }
}

#[test]
fn start_values_are_read_before_the_initialization() {
    let importer = Importer::new(JENKINS);
    let running = importer.slave();
    assert_eq!(get(&running, &[NORMAL_LOAD, TANGENTIAL_STIFFNESS], 2), [100.0, 2e6]);
    assert_eq!(unsafe { fmi3EnterInitializationMode(running.handle, 1, 1e-8, 2.0, 1, 3.0) }, Status::Ok);
    assert_eq!(get(&running, &[reference(&running, "time")], 1), [2.0]);
}

#[test]
fn an_array_has_the_values_of_its_sensors_and_their_derivatives() {
    let importer = Importer::new(BEAM);
    let running = beam(&importer);
    let names = ["displacement:x=0.55", "displacement:x=0.3", "displacement:x=0.1"];
    let single = names.map(|name| reference(&running, name));
    let array = reference(&running, "displacements");
    let expected = get(&running, &single, 3);
    assert!(expected.iter().all(|value| *value != 0.0));
    // Between scalars it takes its own place.
    let mixed = get(&running, &[single[2], array, 0], 5);
    assert_eq!(mixed, [expected[2], expected[0], expected[1], expected[2], 950.0]);
    let rates = |references: &[u32]| {
        let mut rates = [f64::NAN; 3];
        let orders = vec![1; references.len()];
        let (handle, into) = (running.handle, rates.as_mut_ptr());
        let status = unsafe {
            fmi3GetOutputDerivatives(handle, references.as_ptr(), references.len(), orders.as_ptr(), into, 3)
        };
        assert_eq!(status, Status::Ok, "{:?}", importer.last());
        rates
    };
    assert_eq!(rates(&[array]), rates(&single));
    let velocities = get(&running, &[reference(&running, "velocities")], 3);
    for (rate, velocity) in rates(&[array]).into_iter().zip(velocities) {
        assert!((rate - velocity).abs() <= 1e-9 * velocity.abs(), "{rate} {velocity}");
    }
}

#[test]
fn the_adjoint_derivative_is_the_directional_one_transposed() {
    let importer = Importer::new(BEAM);
    let running = beam(&importer);
    let unknowns = [reference(&running, "force"), reference(&running, "accelerations")];
    let (knowns, seed) = ([0, 1], [0.7, -1.3, 0.2, 2.1]);
    let mut forward = [[f64::NAN; 4]; 2];
    let mut back = [f64::NAN; 2];
    unsafe {
        for (known, column) in knowns.iter().zip(&mut forward) {
            let (handle, into) = (running.handle, column.as_mut_ptr());
            let status =
                fmi3GetDirectionalDerivative(handle, unknowns.as_ptr(), 2, known, 1, &1.0, 1, into, 4);
            assert_eq!(status, Status::Ok, "{:?}", importer.last());
        }
        let (handle, into) = (running.handle, back.as_mut_ptr());
        let (unknowns, knowns) = (unknowns.as_ptr(), knowns.as_ptr());
        let status = fmi3GetAdjointDerivative(handle, unknowns, 2, knowns, 2, seed.as_ptr(), 4, into, 2);
        assert_eq!(status, Status::Ok, "{:?}", importer.last());
    }
    for (column, back) in forward.iter().zip(back) {
        let expected: f64 = column.iter().zip(seed).map(|(one, seed)| one * seed).sum();
        assert!(expected != 0.0 && (back - expected).abs() <= 1e-12 * expected.abs(), "{back} {expected}");
    }
}

#[test]
fn indicators_are_variables_too_in_both_interfaces() {
    let importer = Importer::new(JENKINS);
    let names = ["reversal", "slip", "lift_off"].map(|name| format!("event_indicator:{name}"));
    let running = importer.continuous();
    running.initialize();
    let references = names.clone().map(|name| reference(&running, &name));
    unsafe { assert_eq!(fmi3EnterContinuousTimeMode(running.handle), Status::Ok) };
    running.set(DISPLACEMENT, 1e-3);
    running.set(VELOCITY, 0.25);
    let mut indicators = [f64::NAN; 3];
    let status = unsafe { fmi3GetEventIndicators(running.handle, indicators.as_mut_ptr(), 3) };
    assert_eq!(status, Status::Ok);
    assert_eq!(get(&running, &references, 3), indicators);
    assert_eq!(indicators, [0.25, -1.0, 100.0]);
    // A slave shows the same at the end of its step, and is not changed by it.
    let slave = importer.slave();
    slave.initialize();
    slave.set(DISPLACEMENT, 1e-3);
    slave.set(VELOCITY, 0.25);
    slave.do_step(0.0, 1e-3);
    let before = slave.bytes();
    assert_eq!(get(&slave, &references, 3), indicators);
    assert_eq!(slave.bytes(), before);
    let (mut count, mut states) = (0, 9);
    unsafe {
        assert_eq!(fmi3GetNumberOfEventIndicators(running.handle, &mut count), Status::Ok);
        assert_eq!(fmi3GetNumberOfContinuousStates(running.handle, &mut states), Status::Ok);
    }
    assert_eq!((count, states), (3, 0));
}
