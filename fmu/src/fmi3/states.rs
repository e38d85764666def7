//! Saved states, which are those of FMI 2.0.

use super::calls::Function;
use crate::exports::states::{deserialize, free, restore, save, serialize, serialized_size};
use crate::ffi::{Byte, Handle, StateHandle, Status};

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(handle: Handle, state: *mut StateHandle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { save(handle, Function::GetFMUState, state) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(handle: Handle, state: StateHandle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { restore(handle, Function::SetFMUState, state) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(handle: Handle, state: *mut StateHandle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { free(handle, Function::FreeFMUState, state) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    handle: Handle,
    state: StateHandle,
    size: *mut usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { serialized_size(handle, Function::SerializedFMUStateSize, state, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    handle: Handle,
    state: StateHandle,
    bytes: *mut Byte,
    size: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { serialize(handle, Function::SerializeFMUState, state, bytes, size) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    handle: Handle,
    bytes: *const Byte,
    size: usize,
    state: *mut StateHandle,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { deserialize(handle, Function::DeserializeFMUState, bytes, size, state) }
}
