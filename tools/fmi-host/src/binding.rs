//! The C side of FMI 2.0 co-simulation, and what FMI 3.0 has in common with it.
#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_uint, c_void};

use crate::log::Log;

pub type Handle = *mut c_void;
pub type StateHandle = *mut c_void;

pub const CO_SIMULATION: c_int = 1;
/// `fmi2LastSuccessfulTime` of `fmi2StatusKind`.
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated` of `fmi2StatusKind`.
pub const TERMINATED: c_int = 3;

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
    /// No status of FMI.
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

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
    #[cfg(unix)]
    fn _exit(status: c_int) -> !;
    #[cfg(unix)]
    fn atexit(function: extern "C" fn()) -> c_int;
}

/// Has `function`, which must not unwind, called when this process ends by `exit`.
#[cfg(unix)]
pub fn at_exit(function: extern "C" fn()) {
    // SAFETY: allowed at any time.
    unsafe { atexit(function) };
}

/// Ends this process without running anything more in it, what an FMU has registered included.
#[cfg(unix)]
pub fn end_at_once() -> ! {
    // SAFETY: allowed at any time.
    unsafe { _exit(1) }
}

/// `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Debug)]
pub struct Callbacks {
    logger: *const c_void,
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    step_finished: *const c_void,
    environment: *const Log,
}

impl Callbacks {
    /// The logger writes to `log`, which must be alive wherever the FMU may call.
    pub fn new(log: &Log) -> Self {
        Self {
            logger: crate::log::callback(),
            allocate: calloc,
            free,
            step_finished: std::ptr::null(),
            environment: log,
        }
    }
}

macro_rules! functions {
    (
        struct $functions:ident
        required { $($name:ident: fn($($argument:ty),*) $(-> $result:ty)?;)* }
        optional { $($other:ident: fn($($other_argument:ty),*);)* }
    ) => {
        /// The functions, by their names in C. Those that only some abilities need may be missing.
        #[derive(Debug)]
        pub struct $functions {
            $(pub $name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            $(pub $other: Option<unsafe extern "C" fn($($other_argument),*) -> c_int>,)*
        }

        impl $functions {
            /// # Safety
            /// The library's functions have the signatures of the standard's headers and are not called
            /// after it is unloaded.
            pub unsafe fn bind(library: &libloading::Library) -> Result<Self, libloading::Error> {
                // SAFETY: the caller's promise.
                unsafe {
                    Ok(Self {
                        $($name: *library.get(stringify!($name).as_bytes())?,)*
                        $($other: library.get(stringify!($other).as_bytes()).ok().map(|symbol| *symbol),)*
                    })
                }
            }
        }
    };
}
pub(crate) use functions;

functions! {
    struct Functions
    required {
        fmi2Instantiate: fn(*const c_char, c_int, *const c_char, *const c_char, *const Callbacks, c_int, c_int) -> Handle;
        fmi2FreeInstance: fn(Handle);
        fmi2SetupExperiment: fn(Handle, c_int, f64, f64, c_int, f64) -> c_int;
        fmi2EnterInitializationMode: fn(Handle) -> c_int;
        fmi2ExitInitializationMode: fn(Handle) -> c_int;
        fmi2Terminate: fn(Handle) -> c_int;
        fmi2GetReal: fn(Handle, *const c_uint, usize, *mut f64) -> c_int;
        fmi2SetReal: fn(Handle, *const c_uint, usize, *const f64) -> c_int;
        fmi2DoStep: fn(Handle, f64, f64, c_int) -> c_int;
    }
    optional {
        fmi2Reset: fn(Handle);
        fmi2SetDebugLogging: fn(Handle, c_int, usize, *const *const c_char);
        fmi2GetInteger: fn(Handle, *const c_uint, usize, *mut c_int);
        fmi2SetInteger: fn(Handle, *const c_uint, usize, *const c_int);
        fmi2GetBoolean: fn(Handle, *const c_uint, usize, *mut c_int);
        fmi2SetBoolean: fn(Handle, *const c_uint, usize, *const c_int);
        fmi2GetString: fn(Handle, *const c_uint, usize, *mut *const c_char);
        fmi2SetString: fn(Handle, *const c_uint, usize, *const *const c_char);
        fmi2SetRealInputDerivatives: fn(Handle, *const c_uint, usize, *const c_int, *const f64);
        fmi2GetRealOutputDerivatives: fn(Handle, *const c_uint, usize, *const c_int, *mut f64);
        fmi2GetDirectionalDerivative: fn(Handle, *const c_uint, usize, *const c_uint, usize, *const f64, *mut f64);
        fmi2GetRealStatus: fn(Handle, c_int, *mut f64);
        fmi2GetBooleanStatus: fn(Handle, c_int, *mut c_int);
        fmi2GetFMUstate: fn(Handle, *mut StateHandle);
        fmi2SetFMUstate: fn(Handle, StateHandle);
        fmi2FreeFMUstate: fn(Handle, *mut StateHandle);
        fmi2SerializedFMUstateSize: fn(Handle, StateHandle, *mut usize);
        fmi2SerializeFMUstate: fn(Handle, StateHandle, *mut c_char, usize);
        fmi2DeSerializeFMUstate: fn(Handle, *const c_char, usize, *mut StateHandle);
    }
}
