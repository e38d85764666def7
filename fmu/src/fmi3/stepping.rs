//! Steps, and derivatives of outputs with respect to time.

use super::calls::Function;
use super::failure;
use super::intermediate::{ASKED, Moment};
use crate::exports::stepping::warned_once;
use crate::ffi::{self, Bool, Handle, Status, ValueReference};
use crate::guard::{Aside, Component, Failure, guarded, seldom};
use stickslip::fmi::Error;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    handle: Handle,
    time: f64,
    step: f64,
    _no_set_state_prior_to_current_point: Bool,
    event_handling_needed: *mut Bool,
    terminate_simulation: *mut Bool,
    early_return: *mut Bool,
    last_successful_time: *mut f64,
) -> Status {
    // SAFETY: the importer's promise.
    let asked = unsafe { ask(handle, time, step) };
    if asked != Status::Ok {
        return asked;
    }
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (event, terminate, early, last) = unsafe {
            (
                ffi::place(event_handling_needed, "eventHandlingNeeded")?,
                ffi::place(terminate_simulation, "terminateSimulation")?,
                ffi::place(early_return, "earlyReturn")?,
                ffi::place(last_successful_time, "lastSuccessfulTime")?,
            )
        };
        (*event, *terminate, *early) = (0, 0, 0);
        let outcome = go(component, time, step);
        *last = component.instance.time();
        component.last_step = match &outcome {
            Ok(()) => Status::Ok,
            Err(Error::Step { .. }) => Status::Discard,
            Err(_) => Status::Error,
        };
        outcome.map_err(failure)?;
        warned_once(component)
    };
    // SAFETY: the importer's promise.
    let status = unsafe { guarded(handle, Function::DoStep, body) };
    if super::is_success(status) {
        // SAFETY: the importer's promise.
        unsafe { update(handle, Moment::Finished, time, step) };
    }
    status
}

fn go(component: &mut Component, time: f64, step: f64) -> Result<(), Error> {
    if let Some(intermediate) = component.intermediate.as_deref().filter(|told| told.asks()) {
        intermediate.set_derivatives(&mut component.instance, step)?;
    }
    component.instance.do_step(time, step)
}

/// Asks the importer for inputs within the step, if it has said that it can tell them.
///
/// # Safety
/// As [`guarded`].
unsafe fn ask(handle: Handle, time: f64, step: f64) -> Status {
    // SAFETY: the caller's promise.
    let component = unsafe { Component::from_handle::<Function>(handle) };
    let told = component.and_then(|component| component.intermediate.as_ref());
    if !told.is_some_and(|told| told.asks()) {
        return Status::Ok;
    }
    // Before anything is asked: it must be a step.
    let check = |component: &mut Component| component.instance.check_step(time, step).map_err(failure);
    // SAFETY: the caller's promise.
    let status = unsafe { seldom(handle, Function::DoStep, check) };
    if status == Status::Ok {
        for part in 0..ASKED {
            // SAFETY: the caller's promise.
            unsafe { update(handle, Moment::Asks(part), time, step) };
        }
    }
    status
}

/// Calls the importer's function, if there is one; no reference to the component is alive meanwhile.
///
/// # Safety
/// As [`guarded`].
unsafe fn update(handle: Handle, moment: Moment, time: f64, step: f64) {
    // SAFETY: the caller's promise.
    let component = || unsafe { Component::from_handle::<Function>(handle) };
    let call = component().and_then(|component| {
        let call = component.intermediate.as_mut()?.begin(moment);
        component.aside = Aside::Intermediate;
        Some(call)
    });
    let Some(call) = call else { return };
    // SAFETY: the importer's function; the reference from which `call` was copied has ended.
    unsafe { call.call(time, step) };
    if let Some(component) = component() {
        if component.aside == Aside::Intermediate {
            component.aside = Aside::No;
        }
        if let Some(told) = component.intermediate.as_mut() {
            told.end();
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    handle: Handle,
    references: *const ValueReference,
    count: usize,
    orders: *const i32,
    values: *mut f64,
    value_count: usize,
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let (references, orders, values) = unsafe {
            (
                ffi::slice(references, count, "valueReferences")?,
                ffi::slice(orders, count, "orders")?,
                ffi::slice_mut(values, value_count, "values")?,
            )
        };
        if let Some(intermediate) = component.intermediate.as_ref().filter(|told| told.is_under_way()) {
            intermediate.check_get(references)?;
        }
        if component.instance.is_continuous() {
            return Err(Failure::error("a function of co-simulation, which this instance is not for"));
        }
        let mut all = Vec::with_capacity(value_count);
        for (reference, order) in references.iter().zip(orders) {
            let size = component.instance.size(*reference).map_err(failure)?;
            all.extend(std::iter::repeat_n(*order, size));
        }
        let rows = component.instance.rows_of(references).map_err(failure)?;
        component.instance.output_derivatives(&rows, &all, values).map_err(failure)
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::GetOutputDerivatives, body) }
}
