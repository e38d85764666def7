//! Derivatives through the C interface.

use super::fixture::*;
use crate::exports::lifecycle::*;
use crate::exports::stepping::*;
use crate::exports::values::fmi2SetReal;
use crate::ffi::Status;
use std::ptr::{null, null_mut};
use stickslip::fmi::Instance;

const BEAM: &str = include_str!("../../../modelDescription/ModalBeam.toml");

fn slope(running: &Running<'_>, reference: u32, order: i32, value: f64) -> Status {
    unsafe { fmi2SetRealInputDerivatives(running.handle, &reference, 1, &order, &value) }
}

fn rate(running: &Running<'_>, reference: u32) -> f64 {
    let mut value = f64::NAN;
    let status = unsafe { fmi2GetRealOutputDerivatives(running.handle, &reference, 1, &1, &mut value) };
    assert_eq!(status, Status::Ok);
    value
}

fn change(running: &Running<'_>, unknown: u32, known: u32) -> f64 {
    let mut value = f64::NAN;
    let status =
        unsafe { fmi2GetDirectionalDerivative(running.handle, &unknown, 1, &known, 1, &1.0, &mut value) };
    assert_eq!(status, Status::Ok);
    value
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{found} {expected}");
}

#[test]
fn a_stuck_and_a_slipping_contact_have_the_derivatives_of_the_law() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    assert_eq!(slope(&running, DISPLACEMENT, 1, 10e-3), Status::Ok);
    running.do_step(0.0, 1e-3);
    near(running.get(FORCE), 20.0);
    near(rate(&running, FORCE), 2e6 * 10e-3);
    near(change(&running, FORCE, DISPLACEMENT), 2e6);
    assert_eq!(change(&running, FORCE, NORMAL_LOAD), 0.0);
    assert_eq!(
        (slope(&running, DISPLACEMENT, 1, 0.1), slope(&running, NORMAL_LOAD, 1, 1e3)),
        (Status::Ok, Status::Ok)
    );
    running.do_step(1e-3, 1e-3);
    near(running.get(FORCE), 0.5 * 101.0);
    near(rate(&running, FORCE), 0.5 * 1e3);
    assert_eq!(change(&running, FORCE, DISPLACEMENT), 0.0);
    near(change(&running, FORCE, NORMAL_LOAD), 0.5);
    near(running.get(DISPLACEMENT), 110e-6);
}

#[test]
fn the_initialization_has_derivatives_with_respect_to_inputs() {
    let importer = Importer::new(JENKINS);
    let running = importer.component();
    unsafe { fmi2EnterInitializationMode(running.handle) };
    running.set(DISPLACEMENT, 1e-6);
    near(change(&running, FORCE, DISPLACEMENT), 2e6);
    running.set(DISPLACEMENT, 1e-3);
    assert_eq!(change(&running, FORCE, DISPLACEMENT), 0.0);
    near(change(&running, FORCE, NORMAL_LOAD), 0.5);
}

#[test]
fn a_beam_has_the_same_derivatives_as_natively() {
    let importer = Importer::new(BEAM);
    let running = importer.running();
    let mut native = Instance::new(BEAM).unwrap();
    native.enter_initialization().unwrap();
    native.exit_initialization().unwrap();
    let outputs: Vec<u32> = (2..13).collect();
    for k in 0..20 {
        let time = f64::from(k) * 1e-4;
        let (values, slopes) =
            ([3.0 * time, 20.0 * (300.0 * time).sin()], [3.0, 6000.0 * (300.0 * time).cos()]);
        native.set_real(&[0, 1], &values).unwrap();
        native.set_input_derivatives(&[0, 1], &[1, 1], &slopes).unwrap();
        native.do_step(time, 1e-4).unwrap();
        unsafe {
            assert_eq!(fmi2SetReal(running.handle, [0, 1].as_ptr(), 2, values.as_ptr()), Status::Ok);
            let orders = [1, 1];
            let set = fmi2SetRealInputDerivatives(
                running.handle,
                [0, 1].as_ptr(),
                2,
                orders.as_ptr(),
                slopes.as_ptr(),
            );
            assert_eq!(set, Status::Ok);
        }
        assert_eq!(running.do_step(time, 1e-4), Status::Ok);
        let mut expected = vec![0.0; outputs.len()];
        native.output_derivatives(&outputs, &vec![1; outputs.len()], &mut expected).unwrap();
        assert_eq!(outputs.iter().map(|output| rate(&running, *output)).collect::<Vec<_>>(), expected);
        native.directional_derivative(&outputs, &[1], &[1.0], &mut expected).unwrap();
        assert_eq!(outputs.iter().map(|output| change(&running, *output, 1)).collect::<Vec<_>>(), expected);
    }
}

#[test]
fn refusals_name_function_and_variable_and_change_nothing() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    let before = running.bytes();
    for (reference, order, value, word) in [
        (DISPLACEMENT, 0, 1.0, "displacement"),
        (DISPLACEMENT, 4, 1.0, "order 4"),
        (DISPLACEMENT, 1, f64::NAN, "displacement"),
        (FORCE, 1, 1.0, "force"),
        (SLIP_STATE, 1, 1.0, "slip_state"),
        (TANGENTIAL_STIFFNESS, 1, 1.0, "tangential_stiffness"),
        (77, 1, 1.0, "77"),
    ] {
        assert_eq!(slope(&running, reference, order, value), Status::Error, "{word}");
        assert!(running.error().starts_with("fmi2SetRealInputDerivatives: "), "{}", running.error());
        assert!(running.error().contains(word), "{}", running.error());
        assert_eq!(running.bytes(), before);
    }
    let mut value = 7.0;
    unsafe {
        let handle = running.handle;
        assert_eq!(fmi2GetRealOutputDerivatives(handle, &FORCE, 1, &2, &mut value), Status::Error);
        assert!(running.error().contains("order 2"));
        assert_eq!(fmi2GetRealOutputDerivatives(handle, &DISPLACEMENT, 1, &1, &mut value), Status::Error);
        assert!(running.error().contains("displacement"));
        let wrong =
            fmi2GetDirectionalDerivative(handle, &FORCE, 1, &FRICTION_COEFFICIENT, 1, &1.0, &mut value);
        assert_eq!(wrong, Status::Error);
        assert!(running.error().contains("friction_coefficient"));
        assert_eq!(fmi2GetRealOutputDerivatives(handle, &FORCE, 1, null(), &mut value), Status::Error);
        assert_eq!(fmi2SetRealInputDerivatives(handle, &DISPLACEMENT, 1, &1, null()), Status::Error);
        assert_eq!(
            fmi2GetDirectionalDerivative(handle, &FORCE, 1, &DISPLACEMENT, 1, null(), &mut value),
            Status::Error
        );
        // Nothing asked, nothing done.
        assert_eq!(fmi2SetRealInputDerivatives(handle, null(), 0, null(), null()), Status::Ok);
        assert_eq!(fmi2GetRealOutputDerivatives(handle, null(), 0, null(), null_mut()), Status::Ok);
        assert_eq!(
            fmi2GetDirectionalDerivative(handle, null(), 0, null(), 0, null(), null_mut()),
            Status::Ok
        );
    }
    assert_eq!(value, 7.0);
    assert_eq!(running.bytes(), before);
}

#[test]
fn pending_derivatives_are_part_of_the_saved_state() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    slope(&running, DISPLACEMENT, 1, 10e-3);
    let bytes = running.bytes();
    running.do_step(0.0, 1e-3);
    let other = importer.component();
    assert_eq!(other.set_bytes(&bytes), Status::Ok);
    assert_eq!(other.do_step(0.0, 1e-3), Status::Ok);
    assert_eq!(other.bytes(), running.bytes());
    unsafe { fmi2Reset(other.handle) };
    other.initialize();
    other.do_step(0.0, 1e-3);
    assert_eq!(other.get(FORCE), 0.0);
}
