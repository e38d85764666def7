//! Steps, their status, and derivatives.

use crate::calls::Function;
use crate::ffi::{
    self, Boolean, DO_STEP_STATUS, FALSE, FmiString, Handle, Integer, LAST_SUCCESSFUL_TIME, PENDING_STATUS,
    Real, Status, TERMINATED, TRUE, ValueReference,
};
use crate::guard::{Component, Failure, guarded};
use std::ffi::c_int;
use stickslip::slave::{Error, Stage};

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
        Ok(outcome?)
    };
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::DoStep, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { guarded(handle, Function::CancelStep, |_| Ok(())) }
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
    unsafe { guarded(handle, function, body) }
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

/// What the model description says this FMU does not have.
unsafe fn not_provided(handle: Handle, function: Function, capability: &str) -> Status {
    let body = |_: &mut Component| {
        Err(Failure::error(format!("not provided: the model description has {capability}")))
    };
    // SAFETY: the caller's promise.
    unsafe { guarded(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    handle: Handle,
    _references: *const ValueReference,
    _count: usize,
    _orders: *const Integer,
    _values: *const Real,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { not_provided(handle, Function::SetRealInputDerivatives, "canInterpolateInputs=\"false\"") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    handle: Handle,
    _references: *const ValueReference,
    _count: usize,
    _orders: *const Integer,
    _values: *mut Real,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { not_provided(handle, Function::GetRealOutputDerivatives, "maxOutputDerivativeOrder=\"0\"") }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    handle: Handle,
    _unknown: *const ValueReference,
    _unknown_count: usize,
    _known: *const ValueReference,
    _known_count: usize,
    _known_change: *const Real,
    _unknown_change: *mut Real,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe {
        not_provided(handle, Function::GetDirectionalDerivative, "providesDirectionalDerivative=\"false\"")
    }
}
