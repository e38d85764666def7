//! The C side of FMI 2.0 co-simulation.
#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr;

pub type Handle = *mut c_void;
pub type StateHandle = *mut c_void;

pub const CO_SIMULATION: c_int = 1;

/// What a function returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// All well.
    Ok,
    /// Something to know.
    Warning,
    /// Not done, and the simulation can go on otherwise, e.g. with a smaller step.
    Discard,
    /// The instance cannot go on, unless a saved state is set.
    Error,
    /// No instance of the FMU can go on.
    Fatal,
    /// Not finished.
    Pending,
    /// No status of FMI 2.0.
    Unknown(i32),
}

impl Status {
    #[inline]
    pub(crate) fn from_number(number: c_int) -> Self {
        match number {
            0 => Self::Ok,
            1 => Self::Warning,
            2 => Self::Discard,
            3 => Self::Error,
            4 => Self::Fatal,
            5 => Self::Pending,
            other => Self::Unknown(other),
        }
    }
}

/// `fmi2CallbackFunctions` with NULL everywhere: FMUs of this project need none.
#[repr(C)]
#[derive(Debug)]
pub struct Callbacks {
    functions: [*const c_void; 4],
    environment: *mut c_void,
}

impl Callbacks {
    pub fn none() -> Self {
        Self { functions: [ptr::null(); 4], environment: ptr::null_mut() }
    }
}

macro_rules! functions {
    ($($name:ident: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions, by their names in C.
        #[derive(Debug)]
        pub struct Functions {
            $(pub $name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// # Safety
            /// The library's functions have the signatures of the FMI 2.0 headers and are not called
            /// after it is unloaded.
            pub unsafe fn bind(library: &libloading::Library) -> Result<Self, libloading::Error> {
                // SAFETY: the caller's promise.
                unsafe { Ok(Self { $($name: *library.get(stringify!($name).as_bytes())?,)* }) }
            }
        }
    };
}

functions! {
    fmi2Instantiate: fn(*const c_char, c_int, *const c_char, *const c_char, *const Callbacks, c_int, c_int) -> Handle;
    fmi2FreeInstance: fn(Handle);
    fmi2SetupExperiment: fn(Handle, c_int, f64, f64, c_int, f64) -> c_int;
    fmi2EnterInitializationMode: fn(Handle) -> c_int;
    fmi2ExitInitializationMode: fn(Handle) -> c_int;
    fmi2Terminate: fn(Handle) -> c_int;
    fmi2Reset: fn(Handle) -> c_int;
    fmi2GetReal: fn(Handle, *const c_uint, usize, *mut f64) -> c_int;
    fmi2GetInteger: fn(Handle, *const c_uint, usize, *mut c_int) -> c_int;
    fmi2SetReal: fn(Handle, *const c_uint, usize, *const f64) -> c_int;
    fmi2DoStep: fn(Handle, f64, f64, c_int) -> c_int;
    fmi2GetFMUstate: fn(Handle, *mut StateHandle) -> c_int;
    fmi2SetFMUstate: fn(Handle, StateHandle) -> c_int;
    fmi2FreeFMUstate: fn(Handle, *mut StateHandle) -> c_int;
    fmi2SerializedFMUstateSize: fn(Handle, StateHandle, *mut usize) -> c_int;
    fmi2SerializeFMUstate: fn(Handle, StateHandle, *mut c_char, usize) -> c_int;
    fmi2DeSerializeFMUstate: fn(Handle, *const c_char, usize, *mut StateHandle) -> c_int;
}
