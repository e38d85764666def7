//! Saving, restoring, bytes.

use super::fixture::*;
use crate::exports::lifecycle::fmi2Terminate;
use crate::exports::states::*;
use crate::ffi::Status;
use std::ptr::null_mut;

/// Puts the right checksum at the end of changed bytes (64-bit FNV-1a).
pub fn seal(bytes: &mut [u8]) {
    let body = bytes.len() - 8;
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in &bytes[..body] {
        hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    }
    bytes[body..].copy_from_slice(&hash.to_le_bytes());
}

/// Forces of ten steps of a growing oscillation from step `first`.
fn forces(running: &Running<'_>, first: i32) -> Vec<u64> {
    let step = |index: i32| {
        let time = f64::from(index) * 1e-3;
        running.set(DISPLACEMENT, 3e-5 * (1.0 + time) * (900.0 * (time + 1e-3)).sin());
        running.set(NORMAL_LOAD, 100.0 + 120.0 * (300.0 * time).cos());
        assert_eq!(running.do_step(time, 1e-3), Status::Ok);
        running.get(FORCE).to_bits()
    };
    (first..first + 10).map(step).collect()
}

#[test]
fn save_step_restore_step_is_bit_identical() {
    for model in [JENKINS, VALANIS] {
        let importer = Importer::new(model);
        let running = importer.running();
        forces(&running, 0);
        let mut state = null_mut();
        unsafe {
            assert_eq!(fmi2GetFMUstate(running.handle, &mut state), Status::Ok);
            let first = forces(&running, 10);
            assert_eq!(fmi2SetFMUstate(running.handle, state), Status::Ok);
            assert_eq!(forces(&running, 10), first);
            // The same memory again, from the new place.
            let place = state;
            assert_eq!(fmi2GetFMUstate(running.handle, &mut state), Status::Ok);
            assert_eq!(state, place);
            let second = forces(&running, 20);
            assert_eq!(fmi2SetFMUstate(running.handle, state), Status::Ok);
            assert_eq!(forces(&running, 20), second);
            assert_eq!(fmi2FreeFMUstate(running.handle, &mut state), Status::Ok);
        }
    }
}

#[test]
fn bytes_carry_parameters_history_and_stage_to_another_instance() {
    let importer = Importer::new(VALANIS);
    let first = importer.component();
    assert_eq!(first.set(FRICTION_COEFFICIENT, 0.31), Status::Ok);
    first.initialize();
    forces(&first, 0);
    let bytes = first.bytes();
    let expected = forces(&first, 10);
    let second = importer.component();
    assert_eq!(second.set_bytes(&bytes), Status::Ok);
    assert_eq!(second.get(FRICTION_COEFFICIENT), 0.31);
    assert_eq!(forces(&second, 10), expected);
    unsafe { fmi2Terminate(first.handle) };
    assert_eq!(first.set_bytes(&bytes), Status::Ok);
    assert_eq!(forces(&first, 10), expected);
}

#[test]
fn every_changed_byte_and_every_other_length_is_refused() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    forces(&running, 0);
    let bytes = running.bytes();
    for index in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[index] ^= 0x10;
        assert_eq!(running.set_bytes(&changed), Status::Error, "byte {index}");
        assert!(running.error().starts_with("fmi2DeSerializeFMUstate: "));
    }
    for length in 0..bytes.len() {
        assert_eq!(running.set_bytes(&bytes[..length]), Status::Error);
    }
    assert_eq!(running.set_bytes(&[&bytes[..], b"\0"].concat()), Status::Error);
    assert_eq!(running.bytes(), bytes);
}

#[test]
fn numbers_that_no_instance_has_are_refused() {
    let importer = Importer::new(VALANIS);
    let running = importer.running();
    forces(&running, 0);
    let bytes = running.bytes();
    let (header, checksum) = (48, 8);
    for number in (header..bytes.len() - checksum).step_by(8) {
        let mut changed = bytes.clone();
        changed[number..number + 8].copy_from_slice(&f64::NAN.to_le_bytes());
        seal(&mut changed);
        assert_eq!(running.set_bytes(&changed), Status::Error, "number {}", (number - header) / 8);
        assert!(running.error().starts_with("fmi2SetFMUstate: "));
    }
    assert_eq!(running.bytes(), bytes);
}

/// Found by random calls: two steps, each of a finite length, to a time that no saved state may have.
#[test]
fn a_step_that_ends_at_no_finite_time_is_refused() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    assert_eq!(running.do_step(0.0, 1e308), Status::Ok);
    assert_eq!(running.do_step(1e308, 1e308), Status::Error);
    assert!(running.error().contains("ends at a finite time"), "{}", running.error());
    assert_eq!(running.set_bytes(&running.bytes()), Status::Ok);
}

#[test]
fn the_state_of_another_model_is_refused() {
    let (jenkins, valanis) = (Importer::new(JENKINS), Importer::new(VALANIS));
    let (one, other) = (jenkins.running(), valanis.running());
    assert_eq!(one.set_bytes(&other.bytes()), Status::Error);
    assert!(one.error().contains("another model"));
    let mut state = null_mut();
    unsafe {
        assert_eq!(fmi2GetFMUstate(other.handle, &mut state), Status::Ok);
        assert_eq!(fmi2SetFMUstate(one.handle, state), Status::Error);
        assert!(one.error().contains("another model"));
        fmi2FreeFMUstate(other.handle, &mut state);
    }
}

#[test]
fn a_state_that_is_no_state_is_refused() {
    let importer = Importer::new(JENKINS);
    let running = importer.running();
    let mut foreign = [0_u64; 16];
    let handle = (&raw mut foreign).cast();
    let mut size = 0;
    unsafe {
        assert_eq!(fmi2SetFMUstate(running.handle, null_mut()), Status::Error);
        assert_eq!(fmi2SetFMUstate(running.handle, handle), Status::Error);
        assert_eq!(fmi2SerializedFMUstateSize(running.handle, handle, &mut size), Status::Error);
        assert_eq!(fmi2FreeFMUstate(running.handle, &mut { handle }), Status::Error);
        assert_eq!(fmi2GetFMUstate(running.handle, &mut { handle }), Status::Error);
        assert_eq!(fmi2GetFMUstate(running.handle, null_mut()), Status::Error);
        // NULL is ignored when freeing, as the standard says.
        assert_eq!(fmi2FreeFMUstate(running.handle, null_mut()), Status::Ok);
        assert_eq!(fmi2FreeFMUstate(running.handle, &mut null_mut()), Status::Ok);
    }
}
