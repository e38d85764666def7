//! Reading and setting variables: Float64 and, for enumerations, Int64. Of the other types there are none.

use super::calls::Function;
use super::failure;
use crate::ffi::{self, Bool, FmiString, Handle, Status, ValueReference};
use crate::guard::{Component, guarded, seldom};
use stickslip::fmi::Error;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) = unsafe {
            (
                ffi::slice(references, count, "valueReferences")?,
                ffi::slice_mut(values, value_count, "values")?,
            )
        };
        if let Some(intermediate) = component.intermediate.as_ref().filter(|told| told.is_under_way()) {
            intermediate.check_get(references)?;
        }
        component.instance.get_all(references, values).map_err(failure)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::GetFloat64, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) = unsafe {
            (ffi::slice(references, count, "valueReferences")?, ffi::slice(values, value_count, "values")?)
        };
        component.instance.refuse_further(references, None).map_err(failure)?;
        match component.intermediate.as_mut().filter(|told| told.is_under_way()) {
            None => component.instance.set_real(references, values).map_err(failure),
            Some(intermediate) => {
                component.instance.check_inputs(references, values).map_err(failure)?;
                intermediate.tell(references, values)
            }
        }
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::SetFloat64, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt64(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *mut i64,
    value_count: usize,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) = unsafe {
            (
                ffi::slice(references, count, "valueReferences")?,
                ffi::slice_mut(values, value_count, "values")?,
            )
        };
        component.instance.refuse_further(references, Some("Int64")).map_err(failure)?;
        let mut found = vec![0; value_count];
        component.instance.get_integer(references, &mut found).map_err(as_int64)?;
        values.iter_mut().zip(found).for_each(|(value, found)| *value = found.into());
        Ok(())
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::GetInt64, body) }
}

/// A Float64 read as Int64 is told as what was asked.
fn as_int64(error: Error) -> crate::guard::Failure {
    match error {
        Error::WrongType { name, is, .. } => failure(Error::WrongType { name, is, asked: "Int64" }),
        other => failure(other),
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt64(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    values: *const i64,
    value_count: usize,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, values) = unsafe {
            (ffi::slice(references, count, "valueReferences")?, ffi::slice(values, value_count, "values")?)
        };
        component.instance.refuse_further(references, Some("Int64")).map_err(failure)?;
        let values: Vec<i32> = values.iter().map(|value| i32::try_from(*value).unwrap_or(i32::MAX)).collect();
        component.instance.set_integer(references, &values).map_err(as_int64)
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::SetInt64, body) }
}

/// Only an empty list of variables of these types can be read or set.
unsafe fn none_of_type(
    handle: Handle,
    function: Function,
    (references, count): (*const ValueReference, usize),
    type_name: &'static str,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the caller's promise.
        let references = unsafe { ffi::slice(references, count, "valueReferences")? };
        component.instance.refuse_further(references, Some(type_name)).map_err(failure)?;
        match references {
            [] => Ok(()),
            [first, ..] => Err(failure(component.instance.no_variable_of_type(*first, type_name))),
        }
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

/// Functions that read or set variables of types of which there are none.
macro_rules! absent_types {
    ($($get:ident $set:ident $name:literal $of:ty: $get_function:ident $set_function:ident)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            handle: Handle,
            references: *const ValueReference,
            count: usize,
            _values: *mut $of,
            _value_count: usize,
        ) -> Status {
            // SAFETY: the importer's promise.
            unsafe { none_of_type(handle, Function::$get_function, (references, count), $name) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            handle: Handle,
            references: *const ValueReference,
            count: usize,
            _values: *const $of,
            _value_count: usize,
        ) -> Status {
            // SAFETY: the importer's promise.
            unsafe { none_of_type(handle, Function::$set_function, (references, count), $name) }
        }
    )*};
}

absent_types! {
    fmi3GetFloat32 fmi3SetFloat32 "Float32" f32: GetFloat32 SetFloat32
    fmi3GetInt8 fmi3SetInt8 "Int8" i8: GetInt8 SetInt8
    fmi3GetUInt8 fmi3SetUInt8 "UInt8" u8: GetUInt8 SetUInt8
    fmi3GetInt16 fmi3SetInt16 "Int16" i16: GetInt16 SetInt16
    fmi3GetUInt16 fmi3SetUInt16 "UInt16" u16: GetUInt16 SetUInt16
    fmi3GetInt32 fmi3SetInt32 "Int32" i32: GetInt32 SetInt32
    fmi3GetUInt32 fmi3SetUInt32 "UInt32" u32: GetUInt32 SetUInt32
    fmi3GetUInt64 fmi3SetUInt64 "UInt64" u64: GetUInt64 SetUInt64
    fmi3GetBoolean fmi3SetBoolean "Boolean" Bool: GetBoolean SetBoolean
    fmi3GetString fmi3SetString "String" FmiString: GetString SetString
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBinary(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _sizes: *mut usize,
    _values: *mut *const u8,
    _value_count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::GetBinary, (references, count), "Binary") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBinary(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _sizes: *const usize,
    _values: *const *const u8,
    _value_count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::SetBinary, (references, count), "Binary") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetClock(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _values: *mut Bool,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::GetClock, (references, count), "Clock") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetClock(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    _values: *const Bool,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { none_of_type(handle, Function::SetClock, (references, count), "Clock") }
}
