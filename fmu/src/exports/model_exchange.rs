//! Functions of model exchange: exported because importers bind all 44 names, and refused in every state.

use crate::calls::Function;
use crate::ffi::{Boolean, Handle, Real, Status};
use crate::guard::guarded;
use std::ffi::c_void;

/// Refused by the call table, with a message.
unsafe fn refused(handle: Handle, function: Function) -> Status {
    // SAFETY: the caller's promise.
    unsafe { guarded(handle, function, |_| Ok(())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::EnterEventMode) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(handle: Handle, _event_info: *mut c_void) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::NewDiscreteStates) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::EnterContinuousTimeMode) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    handle: Handle,
    _no_set_state_prior_to_current_point: Boolean,
    _enter_event_mode: *mut Boolean,
    _terminate: *mut Boolean,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::CompletedIntegratorStep) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(handle: Handle, _time: Real) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::SetTime) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    handle: Handle,
    _states: *const Real,
    _count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::SetContinuousStates) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(
    handle: Handle,
    _derivatives: *mut Real,
    _count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::GetDerivatives) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    handle: Handle,
    _indicators: *mut Real,
    _count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::GetEventIndicators) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(
    handle: Handle,
    _states: *mut Real,
    _count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::GetContinuousStates) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    handle: Handle,
    _nominals: *mut Real,
    _count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { refused(handle, Function::GetNominalsOfContinuousStates) }
}
