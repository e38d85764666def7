//! Creation, initialization, logging, and the end.

use crate::calls::{Call, Function};
use crate::ffi::{
    self, Boolean, CO_SIMULATION, CallbackFunctions, FmiString, Handle, MODEL_EXCHANGE, Real, Status,
};
use crate::guard::{Component, Failure, catch, install_hook, seldom};
use crate::log::{Category, Log};
use crate::models;
use std::ffi::{CStr, c_char, c_int};
use stickslip::fmi::{Instance, Setup};

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: FmiString,
    fmu_type: c_int,
    guid: FmiString,
    resource_location: FmiString,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    logging_on: Boolean,
) -> Handle {
    install_hook();
    // SAFETY: strings and callbacks are the importer's promise.
    let (log, name, guid, location) = unsafe {
        let name = ffi::text(instance_name);
        (Log::new(functions, name, logging_on != 0), name, ffi::text(guid), ffi::text(resource_location))
    };
    let (status, category, message) = match catch(|| instantiate(name, fmu_type, guid, location)) {
        Ok(Ok(instance)) => {
            let component = Box::new(Component::new::<Function>(instance, log));
            if component.log.wants_events() {
                let name = component.instance.description().name;
                component.log.event(&format!("{}: a {name} is ready", Function::Instantiate.name()));
            }
            return Box::into_raw(component).cast();
        }
        Ok(Err(message)) => (Status::Error, Category::StatusError, message),
        Err(message) => (Status::Fatal, Category::StatusFatal, message),
    };
    log.send(status, category, &format!("{}: {message}", Function::Instantiate.name()));
    std::ptr::null_mut()
}

fn instantiate(
    name: Option<&CStr>,
    fmu_type: c_int,
    guid: Option<&CStr>,
    location: Option<&CStr>,
) -> Result<Instance, String> {
    if name.is_none_or(CStr::is_empty) {
        return Err("the instance name is missing".to_owned());
    }
    let guid = guid.ok_or("the GUID is missing")?;
    let location = location.ok_or("fmuResourceLocation is missing")?;
    let template = models::template(guid, location, "GUID")?;
    let instance = match fmu_type {
        CO_SIMULATION => template.instance(),
        MODEL_EXCHANGE => template.continuous_instance(),
        other => {
            return Err(format!(
                "fmuType is {other}; {MODEL_EXCHANGE} is model exchange, {CO_SIMULATION} co-simulation"
            ));
        }
    };
    instance.map_err(|error| error.to_string())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(handle: Handle) {
    // SAFETY: the importer's promise. A NULL handle is ignored, as the standard says.
    unsafe { Component::free(handle, Function::FreeInstance) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    handle: Handle,
    logging_on: Boolean,
    count: usize,
    categories: *const FmiString,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { set_debug_logging(handle, Function::SetDebugLogging, logging_on != 0, (categories, count)) }
}

/// What the importer wants to hear, of either version.
///
/// # Safety
/// As C functions are: pointers are NULL or valid.
pub unsafe fn set_debug_logging<C: Call>(
    handle: Handle,
    function: C,
    logging_on: bool,
    (categories, count): (*const FmiString, usize),
) -> Status {
    let body = |component: &mut Component| {
        // SAFETY: the importer's promise.
        let pointers = unsafe { ffi::slice(categories, count, "categories")? };
        // SAFETY: the importer's promise.
        let texts: Option<Vec<&CStr>> =
            pointers.iter().map(|pointer| unsafe { ffi::text(*pointer) }).collect();
        let texts = texts.ok_or_else(|| Failure::error("one of the categories is NULL"))?;
        component.log.configure(logging_on, &texts).map_err(Failure::error)
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    handle: Handle,
    tolerance_defined: Boolean,
    tolerance: Real,
    start_time: Real,
    stop_time_defined: Boolean,
    stop_time: Real,
) -> Status {
    let setup = Setup {
        tolerance: (tolerance_defined != 0).then_some(tolerance),
        start: start_time,
        stop: (stop_time_defined != 0).then_some(stop_time),
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::SetupExperiment, |component| Ok(component.instance.set_up(setup)?)) }
}

/// A function without arguments, which is also an event.
///
/// # Safety
/// As [`guarded`].
pub unsafe fn transition<C: Call>(
    handle: Handle,
    function: C,
    change: impl FnOnce(&mut Instance) -> Result<(), stickslip::fmi::Error>,
) -> Status {
    let body = |component: &mut Component| {
        change(&mut component.instance)?;
        component.log.event(function.name());
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::EnterInitializationMode, Instance::enter_initialization) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::ExitInitializationMode, Instance::exit_initialization) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::Terminate, Instance::terminate) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(handle: Handle) -> Status {
    let body = |component: &mut Component| {
        component.instance.reset();
        component.status_of_stage();
        component.log.event(Function::Reset.name());
        Ok(())
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::Reset, body) }
}
