//! The types of `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`, those of FMI 3.0 that differ, and slices from C arrays.
//!
//! Enumerations cross the boundary as `c_int`: a number the importer made up must not become an
//! invalid Rust enumeration.

use crate::guard::Failure;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};

pub type Handle = *mut c_void;
pub type StateHandle = *mut c_void;
pub type ValueReference = c_uint;
pub type Real = f64;
pub type Integer = c_int;
pub type Boolean = c_int;
pub type FmiString = *const c_char;
pub type Byte = c_char;

pub const TRUE: Boolean = 1;
pub const FALSE: Boolean = 0;

/// `fmi2Status`, of which `fmi3Status` has all but the last.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
// Every value of the C enumeration, used or not.
#[allow(dead_code)]
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
    Pending = 5,
}

/// `fmi2ModelExchange` of `fmi2Type`.
pub const MODEL_EXCHANGE: c_int = 0;
/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;

/// `fmi2StatusKind`.
pub const DO_STEP_STATUS: c_int = 0;
pub const PENDING_STATUS: c_int = 1;
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
pub const TERMINATED: c_int = 3;

/// `fmi2CallbackLogger`: variadic, always called with `"%s"` and one string.
pub type Logger = unsafe extern "C" fn(
    environment: *mut c_void,
    instance_name: FmiString,
    status: c_int,
    category: FmiString,
    message: FmiString,
    ...
);

/// `fmi2CallbackFunctions`. The pointers of any member may be NULL.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    pub logger: Option<Logger>,
    pub allocate_memory: *const c_void,
    pub free_memory: *const c_void,
    pub step_finished: *const c_void,
    pub component_environment: *mut c_void,
}

/// `fmi3Boolean`, a C `bool`: as a number, since the importer may pass any byte.
pub type Bool = u8;

/// `fmi3LogMessageCallback`.
pub type LogMessage =
    unsafe extern "C" fn(environment: *mut c_void, status: c_int, category: FmiString, message: FmiString);

/// `fmi3IntermediateUpdateCallback`.
pub type IntermediateUpdate = unsafe extern "C" fn(
    environment: *mut c_void,
    time: f64,
    set_requested: Bool,
    get_allowed: Bool,
    step_finished: Bool,
    can_return_early: Bool,
    early_return_requested: *mut Bool,
    early_return_time: *mut f64,
);

/// The C array `name` of `length` elements; an empty one may be NULL.
///
/// # Safety
/// A non-NULL `pointer` must point to `length` elements that outlive `'a`.
#[inline(always)]
pub unsafe fn slice<'a, T>(pointer: *const T, length: usize, name: &str) -> Result<&'a [T], Failure> {
    if length == 0 {
        return Ok(&[]);
    }
    check_array(pointer, length, name)?;
    // SAFETY: not NULL, aligned, of a possible size; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// As [`slice`], to write.
///
/// # Safety
/// As [`slice`], and nothing else refers to the array during `'a`.
#[inline(always)]
pub unsafe fn slice_mut<'a, T>(pointer: *mut T, length: usize, name: &str) -> Result<&'a mut [T], Failure> {
    if length == 0 {
        return Ok(&mut []);
    }
    check_array(pointer, length, name)?;
    // SAFETY: not NULL, aligned, of a possible size; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

/// The place `name` points to.
///
/// # Safety
/// As [`slice_mut`] with one element.
pub unsafe fn place<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Failure> {
    check_array(pointer, 1, name)?;
    // SAFETY: not NULL and aligned; the rest is the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// The text behind a C string; `None` for NULL.
///
/// # Safety
/// A non-NULL `pointer` must point to a NUL-terminated string that outlives `'a`.
pub unsafe fn text<'a>(pointer: FmiString) -> Option<&'a CStr> {
    // SAFETY: not NULL; the rest is the caller's promise.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

#[inline(always)]
fn check_array<T>(pointer: *const T, length: usize, name: &str) -> Result<(), Failure> {
    let possible = length <= isize::MAX as usize / size_of::<T>().max(1);
    if !pointer.is_null() && pointer.is_aligned() && possible {
        return Ok(());
    }
    Err(wrong_array(pointer.is_null(), possible, length, name))
}

#[cold]
fn wrong_array(null: bool, possible: bool, length: usize, name: &str) -> Failure {
    Failure::error(match (null, possible) {
        (true, _) => format!("{name} is NULL"),
        (false, true) => format!("{name} is not aligned"),
        (false, false) => format!("{name} cannot have {length} elements"),
    })
}
