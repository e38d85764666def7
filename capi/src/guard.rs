//! What every function does first and last.
//!
//! Unwinding into C is undefined, so that every export catches. The standard library's panic hook would also print to
//! standard error; the hook installed here keeps panics inside the exports silent and passes all others on, since a
//! static library may share the hook with other Rust code.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::ffi::{CString, c_char};
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;
use stickslip::fmi::Error;

/// What a call came to.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Refused: an argument is wrong. The model is as before.
    Refused = 1,
    /// The step, the start or the tangent cannot be computed. The model is as before: a smaller step may succeed.
    Failed = 2,
    /// An internal error. Nothing can be done with the model but to free it.
    Broken = 3,
}

/// Why a call fails, with its text.
#[derive(Debug)]
pub struct Failure(pub Status, pub String);

impl Failure {
    /// An argument is wrong.
    pub fn refused(message: impl Into<String>) -> Self {
        Self(Status::Refused, message.into())
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Step { .. } | Error::Derivative(_) => Self(Status::Failed, error.to_string()),
            _ => Self::refused(error.to_string()),
        }
    }
}

thread_local! {
    /// The text of the last call of this thread that failed.
    static TEXT: RefCell<Option<CString>> = const { RefCell::new(None) };
    /// This thread is inside an exported function.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
    /// Where the last panic inside came from.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// The text of the last call of this thread that failed; it lives until the next one that fails.
pub fn text() -> *const c_char {
    TEXT.with_borrow(|text| text.as_deref().unwrap_or_default().as_ptr())
}

/// Runs the body of an export.
pub fn guarded(body: impl FnOnce() -> Result<(), Failure>) -> Status {
    install_hook();
    let outside = INSIDE.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(body));
    INSIDE.set(outside);
    match outcome {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(Failure(status, message))) => report(status, message),
        Err(payload) => report(Status::Broken, panic_text(&*payload)),
    }
}

#[cold]
fn report(status: Status, message: String) -> Status {
    // A text from a model file may hold anything.
    let message = CString::new(message.replace('\0', "\\0")).unwrap_or_default();
    TEXT.set(Some(message));
    status
}

#[cold]
fn panic_text(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    format!("internal error{}: {text}", PLACE.take())
}

fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        #[cfg(test)]
        stickslip_fuzz::catch_panics();
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |information| {
            if !INSIDE.get() {
                return previous(information);
            }
            let place = information.location().map(|at| format!(" at {}:{}", at.file(), at.line()));
            PLACE.set(place.unwrap_or_default());
        }));
    });
}

/// What `pointer` points to.
///
/// # Safety
/// NULL, or a live object that nobody changes without a lock while the call runs.
pub unsafe fn object<'a, T>(pointer: *const T, what: &str) -> Result<&'a T, Failure> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_ref() }.ok_or_else(|| Failure::refused(format!("{what} is NULL")))
}

/// Where a result goes.
///
/// # Safety
/// NULL, or memory for a `T` that nobody else uses while the call runs.
pub unsafe fn place<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T, Failure> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_mut() }.ok_or_else(|| Failure::refused(format!("{what} is NULL")))
}

/// The array at `pointer`; nothing where that is NULL.
///
/// # Safety
/// NULL, or `length` values that nobody changes while the call runs.
pub unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Option<&'a [T]> {
    // SAFETY: the caller's promise.
    (!pointer.is_null()).then(|| unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// The array at `pointer` to write to; nothing where that is NULL.
///
/// # Safety
/// NULL, or `length` values that nobody else uses while the call runs.
pub unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize) -> Option<&'a mut [T]> {
    // SAFETY: the caller's promise.
    (!pointer.is_null()).then(|| unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}
