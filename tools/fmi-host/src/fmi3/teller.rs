//! Inputs told within a step: the FMU says when, and is given the values there of the cubics that were set.

use std::ffi::{c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use super::binding::{Bool, SetFloat64};
use crate::binding::Handle;
use crate::log::{Log, note};

/// An input over a step.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    pub reference: u32,
    /// At the beginning of the step.
    pub value: f64,
    /// The first three with respect to time (1/s, 1/s², 1/s³).
    pub derivatives: [f64; 3],
}

impl Course {
    /// Its value at `time` (s) from the beginning.
    fn at(&self, time: f64) -> f64 {
        let [first, second, third] = self.derivatives;
        self.value + time * (first + time * (second / 2.0 + time * third / 6.0))
    }
}

/// What a component is told while it steps.
#[derive(Debug)]
pub struct Teller {
    pub handle: Handle,
    pub set: SetFloat64,
    /// Beginning of the step (s).
    pub begin: f64,
    pub courses: Vec<Course>,
}

/// What the callbacks of a component are given.
#[derive(Debug)]
pub struct Environment {
    pub log: Arc<Log>,
    pub teller: Mutex<Option<Teller>>,
}

// SAFETY: the handle is used by the thread that steps the component, and only while it does.
unsafe impl Send for Environment {}
// SAFETY: see above; the teller is behind a lock.
unsafe impl Sync for Environment {}

/// `fmi3LogMessageCallback`.
///
/// # Safety
/// `environment` is NULL or points to a live [`Environment`]; the strings are NULL or end with zero.
pub unsafe extern "C" fn log_message(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    if environment.is_null() {
        return;
    }
    // SAFETY: the caller's promise.
    let environment = unsafe { &*environment.cast::<Environment>() };
    // SAFETY: the caller's promise; the log is alive.
    unsafe { note(ptr::from_ref(&*environment.log).cast(), status, category, message) }
}

/// `fmi3IntermediateUpdateCallback`.
///
/// # Safety
/// As [`log_message`]; called by a component within its step.
pub unsafe extern "C" fn intermediate_update(
    environment: *mut c_void,
    time: f64,
    set_requested: Bool,
    _get_allowed: Bool,
    _step_finished: Bool,
    _can_return_early: Bool,
    early_return_requested: *mut Bool,
    _early_return_time: *mut f64,
) {
    if environment.is_null() {
        return;
    }
    // SAFETY: the caller's promise.
    let environment = unsafe { &*environment.cast::<Environment>() };
    if !early_return_requested.is_null() {
        // SAFETY: FMI: it points to a Boolean.
        unsafe { *early_return_requested = 0 };
    }
    if set_requested == 0 {
        return;
    }
    // Nothing may unwind into the FMU.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        let teller = environment.teller.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(teller) = teller.as_ref() else { return };
        for course in &teller.courses {
            let value = course.at(time - teller.begin);
            // SAFETY: the component itself asks for it, in the state of FMI that is meant for that. What it objects to
            // it says in its log, and when the step is done.
            unsafe { (teller.set)(teller.handle, &course.reference, 1, &value, 1) };
        }
    }));
}
