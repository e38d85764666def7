//! Saved states: hysteresis memory, time, parameters and the state of the call table, all of it.

use crate::calls::{Call, Function};
use crate::ffi::{self, Byte, Handle, StateHandle, Status};
use crate::guard::{Component, Failure, guarded, seldom};
use stickslip::fmi::{Snapshot, SnapshotError};

const SAVED: u64 = u64::from_le_bytes(*b"stkslipS");
const FREED: u64 = u64::from_le_bytes(*b"stateFRE");

/// What an `fmi2FMUstate` or an `fmi3FMUState` points to.
struct Saved {
    /// Tells a saved state from other memory.
    magic: u64,
    snapshot: Snapshot,
}

impl Saved {
    fn into_handle(snapshot: Snapshot) -> StateHandle {
        Box::into_raw(Box::new(Self { magic: SAVED, snapshot })).cast()
    }

    /// # Safety
    /// `handle` is NULL or points to readable memory; if that is a saved state, nobody else uses it now.
    unsafe fn from_handle<'a>(handle: StateHandle) -> Result<&'a mut Self, Failure> {
        let saved = handle.cast::<Self>();
        if saved.is_null() {
            return Err(Failure::error("FMUstate is NULL"));
        }
        // SAFETY: readable by the caller's promise; only a matching number makes it a reference.
        let known = saved.is_aligned() && unsafe { (&raw const (*saved).magic).read() } == SAVED;
        if !known {
            return Err(Failure::error("FMUstate is not a saved state"));
        }
        // SAFETY: the number matches.
        Ok(unsafe { &mut *saved })
    }
}

/// Saves the state of the component into a new handle, or one made before.
///
/// # Safety
/// As C functions are: pointers are NULL or valid.
pub unsafe fn save<C: Call>(handle: Handle, function: C, state: *mut StateHandle) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the caller's promise.
        let state = unsafe { ffi::place(state, "FMUstate")? };
        if state.is_null() {
            *state = Saved::into_handle(component.instance.snapshot());
        } else {
            // SAFETY: the caller's promise. The memory of an older state is used again.
            let saved = unsafe { Saved::from_handle(*state)? };
            component.instance.save(&mut saved.snapshot);
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { guarded(handle, function, body) }
}

/// Puts the component into a saved state.
///
/// # Safety
/// As C functions are: pointers are NULL or valid.
pub unsafe fn restore<C: Call>(handle: Handle, function: C, state: StateHandle) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the caller's promise.
        let saved = unsafe { Saved::from_handle(state)? };
        component.instance.restore(&saved.snapshot)?;
        component.status_of_stage();
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { guarded(handle, function, body) }
}

/// Frees a saved state.
///
/// # Safety
/// As C functions are: pointers are NULL or valid.
pub unsafe fn free<C: Call>(handle: Handle, function: C, state: *mut StateHandle) -> Status {
    let body = |_: &mut Component| {
        // SAFETY: the caller's promise. NULL is ignored, as the standard says.
        let Some(state) = (unsafe { state.as_mut() }).filter(|state| !state.is_null()) else {
            return Ok(());
        };
        // SAFETY: the caller's promise.
        let saved = unsafe { Saved::from_handle(*state)? };
        saved.magic = FREED;
        // SAFETY: made by `Box::into_raw`, and no longer a saved state for anyone else.
        drop(unsafe { Box::from_raw(saved) });
        *state = std::ptr::null_mut();
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

/// Bytes of a saved state.
///
/// # Safety
/// As C functions are: pointers are NULL or valid.
pub unsafe fn serialized_size<C: Call>(
    handle: Handle,
    function: C,
    state: StateHandle,
    size: *mut usize,
) -> Status {
    let body = |_: &mut Component| {
        // SAFETY: the caller's promise.
        let (saved, size) = unsafe { (Saved::from_handle(state)?, ffi::place(size, "size")?) };
        *size = saved.snapshot.byte_len();
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

/// Writes a saved state as bytes.
///
/// # Safety
/// As C functions are: pointers are NULL or valid.
pub unsafe fn serialize<C: Call>(
    handle: Handle,
    function: C,
    state: StateHandle,
    bytes: *mut Byte,
    size: usize,
) -> Status {
    let body = |_: &mut Component| {
        // SAFETY: the caller's promise.
        let saved = unsafe { Saved::from_handle(state)? };
        let found = saved.snapshot.to_bytes();
        if size != found.len() {
            return Err(Failure::error(format!("size is {size}; the state has {} bytes", found.len())));
        }
        // SAFETY: the caller's promise.
        let target = unsafe { ffi::slice_mut(bytes.cast::<u8>(), size, "serializedState")? };
        target.copy_from_slice(&found);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

/// Makes a saved state of bytes.
///
/// # Safety
/// As C functions are: pointers are NULL or valid.
pub unsafe fn deserialize<C: Call>(
    handle: Handle,
    function: C,
    bytes: *const Byte,
    size: usize,
    state: *mut StateHandle,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the caller's promise.
        let (bytes, state) = unsafe {
            (ffi::slice(bytes.cast::<u8>(), size, "serializedState")?, ffi::place(state, "FMUstate")?)
        };
        let snapshot = Snapshot::from_bytes(bytes).map_err(|error| Failure::error(error.to_string()))?;
        let (found, expected) = (snapshot.guid(), component.instance.guid());
        if found != expected {
            let error = SnapshotError::OtherModel { found, expected };
            return Err(Failure::error(error.to_string()));
        }
        if state.is_null() {
            *state = Saved::into_handle(snapshot);
        } else {
            // SAFETY: the caller's promise.
            unsafe { Saved::from_handle(*state)? }.snapshot = snapshot;
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(handle: Handle, state: *mut StateHandle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { save(handle, Function::GetFMUstate, state) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(handle: Handle, state: StateHandle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { restore(handle, Function::SetFMUstate, state) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(handle: Handle, state: *mut StateHandle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { free(handle, Function::FreeFMUstate, state) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    handle: Handle,
    state: StateHandle,
    size: *mut usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { serialized_size(handle, Function::SerializedFMUstateSize, state, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    handle: Handle,
    state: StateHandle,
    bytes: *mut Byte,
    size: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { serialize(handle, Function::SerializeFMUstate, state, bytes, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    handle: Handle,
    bytes: *const Byte,
    size: usize,
    state: *mut StateHandle,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { deserialize(handle, Function::DeSerializeFMUstate, bytes, size, state) }
}
