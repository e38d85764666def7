//! Steps, their status, and derivatives.

use crate::calls::Function;
use crate::ffi::{
    self, Boolean, DO_STEP_STATUS, FALSE, FmiString, Handle, Integer, LAST_SUCCESSFUL_TIME, PENDING_STATUS,
    Real, Status, TERMINATED, TRUE, ValueReference,
};
use crate::guard::{Component, Failure, guarded, seldom};
use std::ffi::c_int;
use stickslip::fmi::{Error, Stage};

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    handle: Handle,
    current_communication_point: Real,
    communication_step_size: Real,
    _no_set_state_prior_to_current_point: Boolean,
) -> Status {
    let body = |component: &mut Component| {
        let outcome = component.instance.do_step(current_communication_point, communication_step_size);
        component.last_step = match &outcome {
            Ok(()) => Status::Ok,
            Err(Error::Step { .. }) => Status::Discard,
            Err(_) => Status::Error,
        };
        outcome?;
        warned_once(component)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::DoStep, body) }
}

/// The first warning of an instance; more of the same would fill the importer's log.
#[inline(always)]
pub fn warned_once(component: &mut Component) -> Result<(), Failure> {
    if component.warned {
        return Ok(());
    }
    let Some(warning) = component.instance.warning() else { return Ok(()) };
    component.warned = true;
    component.last_step = Status::Warning;
    Err(Failure::warning(warning))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::CancelStep, |_| Ok(())) }
}

/// A status that is not kept: steps are synchronous.
fn unavailable(kind: c_int) -> Failure {
    let name = match kind {
        DO_STEP_STATUS => "fmi2DoStepStatus",
        PENDING_STATUS => "fmi2PendingStatus",
        LAST_SUCCESSFUL_TIME => "fmi2LastSuccessfulTime",
        TERMINATED => "fmi2Terminated",
        _ => return Failure::error(format!("{kind} is no fmi2StatusKind")),
    };
    Failure::discard(format!("{name} is not of this type, or there is none: steps are synchronous"))
}

/// Writes the status `kind`, if it is `expected`.
unsafe fn status<T>(
    handle: Handle,
    function: Function,
    (kind, expected): (c_int, Option<c_int>),
    value: *mut T,
    read: impl FnOnce(&Component) -> T,
) -> Status {
    let body = |component: &mut Component| {
        if Some(kind) != expected {
            return Err(unavailable(kind));
        }
        // SAFETY: the caller's promise.
        unsafe { *ffi::place(value, "value")? = read(component) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(handle: Handle, kind: c_int, value: *mut c_int) -> Status {
    let kinds = (kind, Some(DO_STEP_STATUS));
    // SAFETY: the importer's promise.
    unsafe { status(handle, Function::GetStatus, kinds, value, |component| component.last_step as c_int) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(handle: Handle, kind: c_int, value: *mut Real) -> Status {
    let kinds = (kind, Some(LAST_SUCCESSFUL_TIME));
    // SAFETY: the importer's promise.
    unsafe { status(handle, Function::GetRealStatus, kinds, value, |component| component.instance.time()) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(handle: Handle, kind: c_int, value: *mut Integer) -> Status {
    // SAFETY: the importer's promise.
    unsafe { status(handle, Function::GetIntegerStatus, (kind, None), value, |_| 0) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(handle: Handle, kind: c_int, value: *mut Boolean) -> Status {
    let terminated = |component: &Component| match component.instance.stage() {
        Stage::Terminated => TRUE,
        _ => FALSE,
    };
    // SAFETY: the importer's promise.
    unsafe { status(handle, Function::GetBooleanStatus, (kind, Some(TERMINATED)), value, terminated) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(handle: Handle, kind: c_int, value: *mut FmiString) -> Status {
    // SAFETY: the importer's promise.
    unsafe { status(handle, Function::GetStringStatus, (kind, None), value, |_| c"".as_ptr()) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    orders: *const Integer,
    values: *const Real,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, orders, values) = unsafe {
            (
                ffi::slice(references, count, "vr")?,
                ffi::slice(orders, count, "order")?,
                ffi::slice(values, count, "value")?,
            )
        };
        Ok(component.instance.set_input_derivatives(references, orders, values)?)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::SetRealInputDerivatives, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    orders: *const Integer,
    values: *mut Real,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, orders, values) = unsafe {
            (
                ffi::slice(references, count, "vr")?,
                ffi::slice(orders, count, "order")?,
                ffi::slice_mut(values, count, "value")?,
            )
        };
        Ok(component.instance.output_derivatives(references, orders, values)?)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::GetRealOutputDerivatives, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    handle: Handle,
    unknowns: *const ValueReference,
    unknown_count: usize,
    knowns: *const ValueReference,
    known_count: usize,
    direction: *const Real,
    change: *mut Real,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (unknowns, knowns, direction, change) = unsafe {
            (
                ffi::slice(unknowns, unknown_count, "vUnknown_ref")?,
                ffi::slice(knowns, known_count, "vKnown_ref")?,
                ffi::slice(direction, known_count, "dvKnown")?,
                ffi::slice_mut(change, unknown_count, "dvUnknown")?,
            )
        };
        Ok(component.instance.directional_derivative(unknowns, knowns, direction, change)?)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::GetDirectionalDerivative, body) }
}
