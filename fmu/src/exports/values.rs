//! Reading and setting variables.

use crate::calls::Function;
use crate::ffi::{self, Boolean, FmiString, Handle, Integer, Real, Status, ValueReference};
use crate::guard::{Component, Failure, guarded, seldom};

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *mut Real,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) =
            unsafe { (ffi::slice(references, count, "vr")?, ffi::slice_mut(values, count, "value")?) };
        Ok(component.instance.get_real(references, values)?)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::GetReal, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *const Real,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) =
            unsafe { (ffi::slice(references, count, "vr")?, ffi::slice(values, count, "value")?) };
        Ok(component.instance.set_real(references, values)?)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::SetReal, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *mut Integer,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) =
            unsafe { (ffi::slice(references, count, "vr")?, ffi::slice_mut(values, count, "value")?) };
        Ok(component.instance.get_integer(references, values)?)
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::GetInteger, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *const Integer,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) =
            unsafe { (ffi::slice(references, count, "vr")?, ffi::slice(values, count, "value")?) };
        Ok(component.instance.set_integer(references, values)?)
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::SetInteger, body) }
}

/// No model has Boolean or String variables: only an empty list of them can be read or set.
unsafe fn none_of_type(
    handle: Handle,
    function: Function,
    references: *const ValueReference,
    count: usize,
    type_name: &'static str,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the caller's promise.
        match unsafe { ffi::slice(references, count, "vr")? } {
            [] => Ok(()),
            [first, ..] => Err(Failure::from(component.instance.no_variable_of_type(*first, type_name))),
        }
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _values: *mut Boolean,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::GetBoolean, references, count, "Boolean") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _values: *const Boolean,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::SetBoolean, references, count, "Boolean") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _values: *mut FmiString,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::GetString, references, count, "String") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _values: *const FmiString,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::SetString, references, count, "String") }
}
