//! Names, units and parameters.

use crate::guard::{Failure, Status, guarded, object, place};
use crate::object::{Kind, Object, Row};
use std::ffi::{CStr, c_char, c_int};
use std::ptr;

/// The kind that a number from C stands for: one that the caller made up must not become an invalid
/// enumeration.
fn kind(number: c_int) -> Option<Kind> {
    [Kind::Input, Kind::Output, Kind::Parameter].into_iter().find(|kind| *kind as c_int == number)
}

fn known_kind(number: c_int) -> Result<Kind, Failure> {
    kind(number).ok_or_else(|| Failure::refused(format!("kind is {number}; it must be 0, 1 or 2")))
}

/// # Safety
/// `model` is NULL or a model.
unsafe fn row<'a>(model: *const Object, number: c_int, index: usize) -> Option<&'a Row> {
    // SAFETY: the caller's promise.
    unsafe { model.as_ref() }?.names.of(kind(number)?).get(index)
}

/// The number of variables of a kind (`stickslip_kind`); 0 for NULL and unknown kinds.
///
/// # Safety
/// `model` is NULL or a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_variable_count(model: *const Object, kind: c_int) -> usize {
    // SAFETY: the caller's promise.
    let model = unsafe { model.as_ref() };
    model.zip(self::kind(kind)).map_or(0, |(model, kind)| model.names.of(kind).len())
}

/// The name of a variable, as "displacement"; it lives as long as the model. NULL where there is no such
/// variable.
///
/// # Safety
/// `model` is NULL or a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_variable_name(
    model: *const Object,
    kind: c_int,
    index: usize,
) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { row(model, kind, index) }.map_or(ptr::null(), |row| row.name.as_ptr())
}

/// The unit of a variable, as "N/m", SI without prefixes; it lives as long as the model. NULL where there
/// is no such variable.
///
/// # Safety
/// `model` is NULL or a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_variable_unit(
    model: *const Object,
    kind: c_int,
    index: usize,
) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { row(model, kind, index) }.map_or(ptr::null(), |row| row.unit.as_ptr())
}

/// Writes to `*index` which variable of a kind is called `name`.
///
/// # Safety
/// `model` is NULL or a model, `name` NULL or a text, `index` NULL or a place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_variable_find(
    model: *const Object,
    kind: c_int,
    name: *const c_char,
    index: *mut usize,
) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (model, index) = unsafe { (object(model, "model")?, place(index, "index")?) };
        if name.is_null() {
            return Err(Failure::refused("name is NULL"));
        }
        // SAFETY: the caller's promise.
        let name = unsafe { CStr::from_ptr(name) };
        let rows = model.names.of(known_kind(kind)?);
        let found = rows.iter().position(|row| *row.name == *name);
        *index = found.ok_or_else(|| {
            let known: Vec<_> = rows.iter().map(|row| row.name.to_string_lossy()).collect();
            let name = name.to_string_lossy();
            Failure::refused(format!("there is no `{name}` among {}", known.join(", ")))
        })?;
        Ok(())
    })
}

/// Sets a parameter for the next start.
///
/// # Safety
/// `model` is NULL or a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_set_parameter(model: *mut Object, index: usize, value: f64) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { object(model, "model")? };
        known_parameter(model, index)?;
        model.lock()?.set_parameter(index, value)
    })
}

/// Writes a parameter, as the next start will have it, to `*value`.
///
/// # Safety
/// `model` is NULL or a model, `value` NULL or a place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_parameter(model: *const Object, index: usize, value: *mut f64) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (model, value) = unsafe { (object(model, "model")?, place(value, "value")?) };
        known_parameter(model, index)?;
        *value = model.lock()?.parameter(index);
        Ok(())
    })
}

fn known_parameter(model: &Object, index: usize) -> Result<(), Failure> {
    let count = model.names.of(Kind::Parameter).len();
    if index < count {
        return Ok(());
    }
    Err(Failure::refused(format!("index is {index}; the model has {count} parameters")))
}
