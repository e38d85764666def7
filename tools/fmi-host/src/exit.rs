//! The end of this process by an FMU in it, which may call `exit` as any code may.

use std::sync::{Mutex, PoisonError};

/// Asked where the process ends while a watch is kept: whether that is as it should be.
type Expected = fn() -> bool;

static WATCHED: Mutex<Option<Expected>> = Mutex::new(None);

/// While this is there, an FMU that calls `exit(0)` does not end the program as if all were done.
#[derive(Debug)]
pub struct ExitWatch(());

impl ExitWatch {
    /// Where the process ends by `exit`, `expected` tells whether it should; if not, it says what is to be said, and the
    /// process ends at once, with the exit code 1.
    pub fn new(expected: Expected) -> Self {
        #[cfg(unix)]
        {
            static ONCE: std::sync::Once = std::sync::Once::new();
            ONCE.call_once(|| crate::binding::at_exit(exiting));
        }
        *WATCHED.lock().unwrap_or_else(PoisonError::into_inner) = Some(expected);
        Self(())
    }
}

impl Drop for ExitWatch {
    fn drop(&mut self) {
        *WATCHED.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

#[cfg(unix)]
extern "C" fn exiting() {
    // The lock is not held while the program speaks.
    let expected = WATCHED.lock().unwrap_or_else(PoisonError::into_inner).take();
    if expected.is_some_and(|expected| !expected()) {
        crate::binding::end_at_once();
    }
}
