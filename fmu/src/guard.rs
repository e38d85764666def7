//! What every function does first and last: the handle, the call table, panics, and messages.
//!
//! # Panics
//! Unwinding into C is undefined, so every export catches, and the panic's text goes to the importer's
//! logger. Left alone, the standard library's panic hook would also print to standard error. The
//! library therefore installs a hook of its own, once, which only notes the place. That surprises
//! nobody: a `cdylib` links its own copy of the standard library, whose hook sees the panics of this
//! library and no others, and this library runs only inside its exports. (The importer's hook, should
//! it be written in Rust, is another one and untouched.) The unit tests are different: there the test
//! harness shares the hook, so a thread is silent only while it is inside an export.
//!
//! The thread-local cells need no destructor, so that the library can be unloaded at any time.

use crate::calls::{Call, State};
use crate::ffi::{Handle, Status};
use crate::fmi3::intermediate::Intermediate;
use crate::log::{Category, Log};
use std::cell::Cell;
use std::fmt;
use std::panic::{self, AssertUnwindSafe, Location};
use std::sync::Once;
use stickslip::fmi::{Error, Instance, Stage};

const FREED: u64 = u64::from_le_bytes(*b"fmufreed");

/// What an `fmi2Component` or an `fmi3Instance` points to.
pub struct Component {
    /// Tells a component from other memory, and from one of another version ([`Call::MAGIC`]).
    magic: u64,
    pub instance: Instance,
    pub log: Log,
    pub last_step: Status,
    /// A warning of the instance was passed on.
    pub warned: bool,
    /// What the importer is asked for within a step; FMI 3.0 only.
    pub intermediate: Option<Box<Intermediate>>,
    pub aside: Aside,
}

/// What is no stage of the instance: one byte to look at before each call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aside {
    /// The stage of the instance counts.
    No,
    /// The importer is asked for inputs.
    Intermediate,
    /// A call panicked.
    Poisoned,
}

/// Why a call fails.
#[derive(Debug)]
pub struct Failure {
    pub status: Status,
    pub message: String,
}

impl Failure {
    /// The call failed, the instance is as before.
    pub fn error(message: impl Into<String>) -> Self {
        Self { status: Status::Error, message: message.into() }
    }

    /// The call did what it should, with results that are not what they seem.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { status: Status::Warning, message: message.into() }
    }

    /// The call cannot deliver, which is no fault of the importer.
    pub fn discard(message: impl Into<String>) -> Self {
        Self { status: Status::Discard, message: message.into() }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Step { .. } | Error::Derivative(_) => Self::discard(error.to_string()),
            _ => Self::error(error.to_string()),
        }
    }
}

impl Component {
    /// Of the version of FMI whose functions are `C`.
    pub fn new<C: Call>(instance: Instance, log: Log) -> Self {
        Self {
            magic: C::MAGIC,
            instance,
            log,
            last_step: Status::Ok,
            warned: false,
            intermediate: None,
            aside: Aside::No,
        }
    }

    /// After a jump to another state: the status of the step that led there.
    pub fn status_of_stage(&mut self) {
        self.last_step = match self.instance.stage() {
            Stage::StepFailed => Status::Discard,
            _ => Status::Ok,
        };
    }

    /// The component behind `handle`, unless it is visibly none.
    ///
    /// # Safety
    /// `handle` is NULL or points to readable memory; if that is a component, nobody else uses it now.
    pub unsafe fn from_handle<'a, C: Call>(handle: Handle) -> Option<&'a mut Self> {
        let component = handle.cast::<Self>();
        if component.is_null() || !component.is_aligned() {
            return None;
        }
        // SAFETY: readable by the caller's promise; only a matching number makes it a reference.
        unsafe { ((&raw const (*component).magic).read() == C::MAGIC).then(|| &mut *component) }
    }

    #[inline]
    pub fn state(&self) -> State {
        match self.aside {
            Aside::No => State::Stage(self.instance.stage()),
            Aside::Intermediate => State::Intermediate,
            Aside::Poisoned => State::Poisoned,
        }
    }

    #[cold]
    fn report<C: Call>(&mut self, function: C, failure: &Failure) -> Status {
        if failure.status == Status::Error && self.aside != Aside::Poisoned {
            C::failed(self);
        }
        let category = match failure.status {
            Status::Discard => Category::StatusDiscard,
            Status::Warning => Category::StatusWarning,
            Status::Fatal => Category::StatusFatal,
            _ => Category::StatusError,
        };
        self.log.send(failure.status, category, &format!("{}: {}", function.name(), failure.message));
        failure.status
    }

    /// Frees the component of `handle`, if it is one.
    ///
    /// # Safety
    /// As [`guarded`]; the handle is not used afterwards.
    pub unsafe fn free<C: Call>(handle: Handle, function: C) {
        // SAFETY: the caller's promise.
        let Some(component) = (unsafe { Self::from_handle::<C>(handle) }) else { return };
        let state = component.state();
        if !function.is_legal_in(state) {
            // The step that called the importer still needs it.
            refuse(component, function, state);
            return;
        }
        component.log.event(function.name());
        component.magic = FREED;
        let component: *mut Self = component;
        // SAFETY: made by `Box::into_raw` in `fmi2Instantiate`, and no longer a component for anyone else.
        let _ = catch(|| drop(unsafe { Box::from_raw(component) }));
    }
}

/// Runs `body` on the component of `handle` if the call table allows `function` now.
///
/// # Safety
/// `handle` is NULL or points to readable memory; if that is a component, nobody else uses it now.
#[inline]
pub unsafe fn guarded<C: Call>(
    handle: Handle,
    function: C,
    body: impl FnOnce(&mut Component) -> Result<(), Failure>,
) -> Status {
    // SAFETY: the caller's promise.
    let Some(component) = (unsafe { Component::from_handle::<C>(handle) }) else {
        return Status::Error;
    };
    let state = component.state();
    if !function.is_legal_in(state) {
        return refuse(component, function, state);
    }
    match catch(|| body(component)) {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(failure)) => component.report(function, &failure),
        Err(message) => {
            component.aside = Aside::Poisoned;
            component.report(function, &Failure { status: Status::Fatal, message })
        }
    }
}

/// As [`guarded`], for functions of which the time does not count: out of line, what all have in common is there once, and
/// not in each of them. Every FMU carries it.
///
/// # Safety
/// As [`guarded`].
pub unsafe fn seldom<C: Call>(
    handle: Handle,
    function: C,
    body: impl FnOnce(&mut Component) -> Result<(), Failure>,
) -> Status {
    let mut body = Some(body);
    let mut once = |component: &mut Component| body.take().map_or(Ok(()), |body| body(component));
    // SAFETY: the caller's promise.
    unsafe { out_of_line(handle, function, &mut once) }
}

/// # Safety
/// As [`guarded`].
#[inline(never)]
unsafe fn out_of_line<C: Call>(
    handle: Handle,
    function: C,
    body: &mut dyn FnMut(&mut Component) -> Result<(), Failure>,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { guarded(handle, function, |component| body(component)) }
}

#[cold]
fn refuse<C: Call>(component: &mut Component, function: C, state: State) -> Status {
    let status = if state == State::Poisoned { Status::Fatal } else { Status::Error };
    component.report(function, &Failure { status, message: function.refusal(state) })
}

thread_local! {
    /// This thread is inside an exported function.
    #[cfg(test)]
    static INSIDE: Cell<bool> = const { Cell::new(false) };
    /// Where the last panic inside came from.
    static PANICKED_AT: Cell<Option<Place>> = const { Cell::new(None) };
}

/// The end of a file's name and a line, without memory on the heap: see the module's last sentence.
#[derive(Clone, Copy)]
struct Place {
    file: [u8; 64],
    length: usize,
    line: u32,
}

impl Place {
    fn new(location: &Location<'_>) -> Self {
        let name = location.file().as_bytes();
        let mut file = [0; 64];
        let length = name.len().min(file.len());
        file[..length].copy_from_slice(&name[name.len() - length..]);
        Self { file, length, line: location.line() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, " at {}:{}", String::from_utf8_lossy(&self.file[..self.length]), self.line)
    }
}

/// The result of `body`, or the text of its panic.
#[inline]
pub fn catch<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    #[cfg(test)]
    let outside = INSIDE.replace(true);
    // A component whose call panicked is never used again, so that no broken invariant is seen.
    let outcome = panic::catch_unwind(AssertUnwindSafe(body));
    #[cfg(test)]
    INSIDE.set(outside);
    outcome.map_err(|payload| panic_text(&*payload))
}

#[cold]
fn panic_text(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    let place = PANICKED_AT.take().map(|place| place.to_string()).unwrap_or_default();
    format!("internal error{place}: {text}")
}

/// Keeps panics inside the exported functions off standard error.
pub fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        #[cfg(test)]
        stickslip_fuzz::catch_panics();
        #[cfg(test)]
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |information| {
            #[cfg(test)]
            if !INSIDE.get() {
                return previous(information);
            }
            PANICKED_AT.set(information.location().map(Place::new));
        }));
    });
}
