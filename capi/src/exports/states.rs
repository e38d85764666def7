//! Saved states: all that a model remembers, hysteresis included. A model that is restored goes on bit by bit as the one
//! that was saved.

use crate::guard::{Failure, Status, array, array_mut, guarded, object, place};
use crate::object::{Object, State};
use stickslip::fmi::Snapshot;

/// Saves the whole state of a model to `*state`. Where that is NULL a new state is made, otherwise the one
/// there is used again, without new memory where it is of the same model.
///
/// # Safety
/// `model` is NULL or a model; `state` is NULL or a place with NULL or a state that no other thread uses
/// now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_save(model: *const Object, state: *mut *mut State) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (model, state) = unsafe { (object(model, "model")?, place(state, "state")?) };
        let running = model.lock()?;
        // SAFETY: the caller's promise.
        match unsafe { state.as_mut() } {
            Some(State(old)) => running.save(old),
            None => *state = Box::into_raw(Box::new(State(running.saved()))),
        }
        Ok(())
    })
}

/// Makes a model go on where `state` was saved, by this model or another of the same model file. Parameters
/// set for the next start stay as they are.
///
/// # Safety
/// `model` is NULL or a model; `state` is NULL or a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_restore(model: *mut Object, state: *const State) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (model, state) = unsafe { (object(model, "model")?, object(state, "state")?) };
        model.lock()?.restore(&state.0)
    })
}

/// Frees a state; NULL is ignored.
///
/// # Safety
/// `state` is NULL or a state that no thread uses now or later.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_state_free(state: *mut State) {
    if !state.is_null() {
        // SAFETY: made by `Box::into_raw`; the caller's promise.
        drop(unsafe { Box::from_raw(state) });
    }
}

/// Number of bytes that `stickslip_state_write` writes; 0 for NULL.
///
/// # Safety
/// `state` is NULL or a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_state_size(state: *const State) -> usize {
    // SAFETY: the caller's promise.
    unsafe { state.as_ref() }.map_or(0, |state| state.0.byte_len())
}

/// Writes a state as bytes, the same on every platform, for a file or another process. `size` is what
/// `stickslip_state_size` tells.
///
/// # Safety
/// `state` is NULL or a state; `bytes` is NULL or has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_state_write(state: *const State, bytes: *mut u8, size: usize) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (state, bytes) = unsafe { (object(state, "state")?, array_mut(bytes, size)) };
        let found = state.0.to_bytes();
        let bytes = bytes.ok_or_else(|| Failure::refused("bytes is NULL"))?;
        if bytes.len() != found.len() {
            let needed = found.len();
            return Err(Failure::refused(format!("size is {size}; the state has {needed} bytes")));
        }
        bytes.copy_from_slice(&found);
        Ok(())
    })
}

/// Reads a state of `model` from bytes and writes a new state to `*state`. Bytes that are no state, changed
/// ones and those of another model are refused.
///
/// # Safety
/// `model` is NULL or a model; `bytes` is NULL or has `size` bytes; `state` is NULL or a place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_state_read(
    model: *const Object,
    bytes: *const u8,
    size: usize,
    state: *mut *mut State,
) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (model, state) = unsafe { (object(model, "model")?, place(state, "state")?) };
        // SAFETY: the caller's promise.
        let bytes = unsafe { array(bytes, size) };
        let bytes = bytes.ok_or_else(|| Failure::refused("bytes is NULL"))?;
        let read = Snapshot::from_bytes(bytes).map_err(|error| Failure::refused(error.to_string()))?;
        model.lock()?.check_model(&read)?;
        *state = Box::into_raw(Box::new(State(read)));
        Ok(())
    })
}
