//! Functions of model exchange: the importer integrates.

use super::calls::Function;
use super::failure;
use crate::exports::lifecycle::transition;
use crate::exports::model_exchange::filled;
use crate::ffi::{self, Bool, Handle, Status};
use crate::guard::{Component, seldom};
use stickslip::fmi::{Description, Error, Instance};

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::EnterEventMode, Instance::enter_event) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    handle: Handle,
    needs_update: *mut Bool,
    terminate_simulation: *mut Bool,
    nominals_changed: *mut Bool,
    values_changed: *mut Bool,
    next_event_time_defined: *mut Bool,
    next_event_time: *mut f64,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (flags, time) = unsafe {
            let flags = [
                ffi::place(needs_update, "discreteStatesNeedUpdate")?,
                ffi::place(terminate_simulation, "terminateSimulation")?,
                ffi::place(nominals_changed, "nominalsOfContinuousStatesChanged")?,
                ffi::place(values_changed, "valuesOfContinuousStatesChanged")?,
                ffi::place(next_event_time_defined, "nextEventTimeDefined")?,
            ];
            (flags, ffi::place(next_event_time, "nextEventTime")?)
        };
        component.instance.new_discrete_states()?;
        // Memories go on in one turn; no state jumps, and no event is known ahead.
        flags.into_iter().for_each(|flag| *flag = 0);
        *time = 0.0;
        Ok(())
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::UpdateDiscreteStates, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::EnterContinuousTimeMode, Instance::enter_continuous_time) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    handle: Handle,
    _no_set_state_prior_to_current_point: Bool,
    enter_event_mode: *mut Bool,
    terminate_simulation: *mut Bool,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (enter_event_mode, terminate) = unsafe {
            (
                ffi::place(enter_event_mode, "enterEventMode")?,
                ffi::place(terminate_simulation, "terminateSimulation")?,
            )
        };
        *enter_event_mode = component.instance.completed_step()?.into();
        *terminate = 0;
        Ok(())
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::CompletedIntegratorStep, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(handle: Handle, time: f64) -> Status {
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::SetTime, |component| Ok(component.instance.set_time(time)?)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(handle: Handle, states: *const f64, count: usize) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let states = unsafe { ffi::slice(states, count, "continuousStates")? };
        component.instance.set_continuous_states(states).map_err(failure)
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::SetContinuousStates, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(
    handle: Handle,
    derivatives: *mut f64,
    count: usize,
) -> Status {
    let into = (derivatives, count, "derivatives");
    // SAFETY: the importer's promise.
    unsafe { filled(handle, Function::GetContinuousStateDerivatives, into, Instance::state_derivatives) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetEventIndicators(
    handle: Handle,
    indicators: *mut f64,
    count: usize,
) -> Status {
    let into = (indicators, count, "eventIndicators");
    // SAFETY: the importer's promise.
    unsafe { filled(handle, Function::GetEventIndicators, into, Instance::event_indicators) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStates(handle: Handle, states: *mut f64, count: usize) -> Status {
    let into = (states, count, "continuousStates");
    // SAFETY: the importer's promise.
    unsafe { filled(handle, Function::GetContinuousStates, into, Instance::continuous_states) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(
    handle: Handle,
    nominals: *mut f64,
    count: usize,
) -> Status {
    let into = (nominals, count, "nominals");
    let read = |instance: &mut Instance, values: &mut [f64]| instance.nominals(values);
    // SAFETY: the importer's promise.
    unsafe { filled(handle, Function::GetNominalsOfContinuousStates, into, read) }
}

/// Writes a number of the description.
unsafe fn number(
    handle: Handle,
    function: Function,
    (number, name): (*mut usize, &str),
    of: fn(&Description) -> usize,
) -> Status {
    let body = |component: &mut Component| {
        if !component.instance.is_continuous() {
            return Err(Error::Interface.into());
        }
        // SAFETY: the caller's promise.
        let number = unsafe { ffi::place(number, name)? };
        *number = of(component.instance.description());
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(handle: Handle, count: *mut usize) -> Status {
    let (function, into) = (Function::GetNumberOfEventIndicators, (count, "nEventIndicators"));
    // SAFETY: the importer's promise.
    unsafe { number(handle, function, into, |description| description.continuous.indicators) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(handle: Handle, count: *mut usize) -> Status {
    let (function, into) = (Function::GetNumberOfContinuousStates, (count, "nContinuousStates"));
    // SAFETY: the importer's promise.
    unsafe { number(handle, function, into, |description| description.states().len()) }
}
