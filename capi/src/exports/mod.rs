//! The functions: `variables` (names, units, parameters), `running` (create, start, step, tangent), `states`.

mod running;
mod states;
mod variables;

pub use running::*;
pub use states::*;
pub use variables::*;

use crate::guard;
use std::ffi::{CStr, c_char};

/// The version of the library, as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn stickslip_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => panic!("a version has no zero"),
        };
    VERSION.as_ptr()
}

/// Why the last call of this thread that failed did so: what, where, and what is allowed. "" before any failed.
/// The text lives until the next call of this thread that fails.
#[unsafe(no_mangle)]
pub extern "C" fn stickslip_error_text() -> *const c_char {
    guard::text()
}
