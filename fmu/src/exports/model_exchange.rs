//! Functions of model exchange: the importer integrates.

use crate::calls::{Call, Function};
use crate::exports::lifecycle::transition;
use crate::ffi::{self, Boolean, FALSE, Handle, Real, Status, TRUE};
use crate::guard::{Component, Failure, seldom};
use stickslip::fmi::{Error, Instance};

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Debug)]
pub struct EventInfo {
    pub new_discrete_states_needed: Boolean,
    pub terminate_simulation: Boolean,
    pub nominals_of_continuous_states_changed: Boolean,
    pub values_of_continuous_states_changed: Boolean,
    pub next_event_time_defined: Boolean,
    pub next_event_time: Real,
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::EnterEventMode, Instance::enter_event) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(handle: Handle, event_info: *mut EventInfo) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let information = unsafe { ffi::place(event_info, "fmi2EventInfo")? };
        component.instance.new_discrete_states()?;
        // Memories go on in one turn; no state jumps, and no event is known ahead.
        *information = EventInfo {
            new_discrete_states_needed: FALSE,
            terminate_simulation: FALSE,
            nominals_of_continuous_states_changed: FALSE,
            values_of_continuous_states_changed: FALSE,
            next_event_time_defined: FALSE,
            next_event_time: 0.0,
        };
        Ok(())
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::NewDiscreteStates, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::EnterContinuousTimeMode, Instance::enter_continuous_time) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    handle: Handle,
    _no_set_state_prior_to_current_point: Boolean,
    enter_event_mode: *mut Boolean,
    terminate: *mut Boolean,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (enter_event_mode, terminate) = unsafe {
            (ffi::place(enter_event_mode, "enterEventMode")?, ffi::place(terminate, "terminateSimulation")?)
        };
        *enter_event_mode = if component.instance.completed_step()? { TRUE } else { FALSE };
        *terminate = FALSE;
        Ok(())
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::CompletedIntegratorStep, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(handle: Handle, time: Real) -> Status {
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::SetTime, |component| Ok(component.instance.set_time(time)?)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    handle: Handle,
    states: *const Real,
    count: usize,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let states = unsafe { ffi::slice(states, count, "x")? };
        Ok(component.instance.set_continuous_states(states)?)
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::SetContinuousStates, body) }
}

/// Fills the array `values`, called `name`, by `read`.
///
/// # Safety
/// As [`guarded`]; the array is NULL or valid.
pub unsafe fn filled<C: Call>(
    handle: Handle,
    function: C,
    (values, count, name): (*mut Real, usize, &str),
    read: impl FnOnce(&mut Instance, &mut [Real]) -> Result<(), Error>,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the caller's promise.
        let values = unsafe { ffi::slice_mut(values, count, name)? };
        read(&mut component.instance, values).map_err(Failure::from)
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(handle: Handle, derivatives: *mut Real, count: usize) -> Status {
    let into = (derivatives, count, "derivatives");
    // SAFETY: the importer's promise.
    unsafe { filled(handle, Function::GetDerivatives, into, Instance::state_derivatives) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    handle: Handle,
    indicators: *mut Real,
    count: usize,
) -> Status {
    let into = (indicators, count, "eventIndicators");
    // SAFETY: the importer's promise.
    unsafe { filled(handle, Function::GetEventIndicators, into, Instance::event_indicators) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(handle: Handle, states: *mut Real, count: usize) -> Status {
    let into = (states, count, "x");
    // SAFETY: the importer's promise.
    unsafe { filled(handle, Function::GetContinuousStates, into, Instance::continuous_states) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    handle: Handle,
    nominals: *mut Real,
    count: usize,
) -> Status {
    let into = (nominals, count, "x_nominal");
    // SAFETY: the importer's promise.
    unsafe {
        filled(handle, Function::GetNominalsOfContinuousStates, into, |instance, values| {
            instance.nominals(values)
        })
    }
}
