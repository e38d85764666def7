//! Creation, initialization, logging, and the end.

use super::calls::Function;
use super::intermediate::Intermediate;
use crate::calls::Call;
use crate::exports::lifecycle::{set_debug_logging, transition};
use crate::ffi::{self, Bool, FmiString, Handle, IntermediateUpdate, LogMessage, Status, ValueReference};
use crate::guard::{Component, catch, install_hook, seldom};
use crate::log::{Category, Log};
use crate::models;
use std::ffi::{CStr, c_char, c_void};
use stickslip::fmi::{Instance, Setup, Template};

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// What all ways to instantiate have in common.
struct Request {
    function: Function,
    name: FmiString,
    token: FmiString,
    path: FmiString,
    logging_on: Bool,
    environment: *mut c_void,
    logger: Option<LogMessage>,
}

impl Request {
    /// A component of what `make` makes of the model; NULL and a message if it fails.
    ///
    /// # Safety
    /// Strings and the logger are NULL or valid.
    unsafe fn instantiate(self, make: impl FnOnce(&Template) -> Result<Made, String>) -> Handle {
        install_hook();
        // SAFETY: the caller's promise.
        let (mut log, name, token, path) = unsafe {
            let log = Log::of_fmi3(self.logger, self.environment, self.logging_on != 0);
            (log, ffi::text(self.name), ffi::text(self.token), ffi::text(self.path))
        };
        let (status, category, message) = match catch(|| make(&template(name, token, path)?)) {
            Ok(Ok((instance, intermediate))) => {
                let mut component = Box::new(Component::new::<Function>(instance, log));
                component.intermediate = intermediate;
                if component.log.wants_events() {
                    let name = component.instance.description().name;
                    component.log.event(&format!("{}: a {name} is ready", self.function.name()));
                }
                return Box::into_raw(component).cast();
            }
            Ok(Err(message)) => (Status::Error, Category::StatusError, message),
            Err(message) => (Status::Fatal, Category::StatusFatal, message),
        };
        // Why it failed is told in any case: there will be no other call to tell it by.
        log.enable();
        log.send(status, category, &format!("{}: {message}", self.function.name()));
        std::ptr::null_mut()
    }
}

/// An instance, and what its importer is asked for within a step.
type Made = (Instance, Option<Box<Intermediate>>);

fn template(name: Option<&CStr>, token: Option<&CStr>, path: Option<&CStr>) -> Result<Template, String> {
    if name.is_none_or(|name| name.to_bytes().iter().all(u8::is_ascii_whitespace)) {
        return Err("the instance name is missing".to_owned());
    }
    let token = token.ok_or("the instantiationToken is missing")?;
    let path = path.ok_or("the resourcePath is missing: the model is read from there")?;
    models::template(token, path, "instantiationToken")
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: FmiString,
    token: FmiString,
    path: FmiString,
    _visible: Bool,
    logging_on: Bool,
    environment: *mut c_void,
    logger: Option<LogMessage>,
) -> Handle {
    let function = Function::InstantiateModelExchange;
    let request = Request { function, name, token, path, logging_on, environment, logger };
    let make = |template: &Template| {
        let instance = template.continuous_instance().map_err(|error| error.to_string())?;
        Ok((instance, None))
    };
    // SAFETY: the importer's promise.
    unsafe { request.instantiate(make) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    name: FmiString,
    token: FmiString,
    path: FmiString,
    _visible: Bool,
    logging_on: Bool,
    event_mode_used: Bool,
    _early_return_allowed: Bool,
    required: *const ValueReference,
    required_count: usize,
    environment: *mut c_void,
    logger: Option<LogMessage>,
    intermediate_update: Option<IntermediateUpdate>,
) -> Handle {
    let function = Function::InstantiateCoSimulation;
    let request = Request { function, name, token, path, logging_on, environment, logger };
    let make = |template: &Template| {
        if event_mode_used != 0 {
            return Err("eventModeUsed is true, but hasEventMode is false".to_owned());
        }
        // SAFETY: the importer's promise.
        let required = unsafe { ffi::slice(required, required_count, "requiredIntermediateVariables") };
        let required = required.map_err(|failure| failure.message)?;
        let intermediate = Intermediate::new(template, required, intermediate_update, environment)?;
        let instance = template.instance().map_err(|error| error.to_string())?;
        Ok((instance, intermediate))
    };
    // SAFETY: the importer's promise.
    unsafe { request.instantiate(make) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    name: FmiString,
    token: FmiString,
    path: FmiString,
    _visible: Bool,
    logging_on: Bool,
    environment: *mut c_void,
    logger: Option<LogMessage>,
    _clock_update: *const c_void,
    _lock_preemption: *const c_void,
    _unlock_preemption: *const c_void,
) -> Handle {
    let function = Function::InstantiateScheduledExecution;
    let request = Request { function, name, token, path, logging_on, environment, logger };
    // SAFETY: the importer's promise.
    unsafe {
        request.instantiate(|_| Err("this FMU is for co-simulation and model exchange only".to_owned()))
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(handle: Handle) {
    // SAFETY: the importer's promise. A NULL handle is ignored, as the standard says.
    unsafe { Component::free(handle, Function::FreeInstance) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    handle: Handle,
    logging_on: Bool,
    count: usize,
    categories: *const FmiString,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { set_debug_logging(handle, Function::SetDebugLogging, logging_on != 0, (categories, count)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    handle: Handle,
    tolerance_defined: Bool,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: Bool,
    stop_time: f64,
) -> Status {
    let setup = Setup {
        tolerance: (tolerance_defined != 0).then_some(tolerance),
        start: start_time,
        stop: (stop_time_defined != 0).then_some(stop_time),
    };
    let enter = |instance: &mut Instance| {
        instance.set_up(setup)?;
        instance.enter_initialization()
    };
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::EnterInitializationMode, enter) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::ExitInitializationMode, Instance::exit_initialization) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(handle: Handle) -> Status {
    // SAFETY: the importer's promise.
    unsafe { transition(handle, Function::Terminate, Instance::terminate) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(handle: Handle) -> Status {
    let body = |component: &mut Component| {
        component.instance.reset();
        component.status_of_stage();
        component.log.event(Function::Reset.name());
        Ok(())
    };
    // SAFETY: the importer's promise.
    unsafe { seldom(handle, Function::Reset, body) }
}
