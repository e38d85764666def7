//! The C side of FMI 3.0 co-simulation.
#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_uint, c_void};

use crate::binding::{Handle, StateHandle, functions};

/// `fmi3Boolean`, a C `bool`.
pub type Bool = u8;

/// `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// `fmi3IntermediateUpdateCallback`: environment, time, whether inputs are asked for, whether outputs may be read,
/// whether the step is finished, whether it may return early, and what it is told of that.
pub type IntermediateUpdate =
    unsafe extern "C" fn(*mut c_void, f64, Bool, Bool, Bool, Bool, *mut Bool, *mut f64);

/// `fmi3SetFloat64`.
pub type SetFloat64 = unsafe extern "C" fn(Handle, *const c_uint, usize, *const f64, usize) -> c_int;

functions! {
    struct Functions3
    required {
        fmi3InstantiateCoSimulation: fn(*const c_char, *const c_char, *const c_char, Bool, Bool, Bool, Bool,
            *const c_uint, usize, *mut c_void, LogMessage, IntermediateUpdate) -> Handle;
        fmi3FreeInstance: fn(Handle);
        fmi3EnterInitializationMode: fn(Handle, Bool, f64, f64, Bool, f64) -> c_int;
        fmi3ExitInitializationMode: fn(Handle) -> c_int;
        fmi3Terminate: fn(Handle) -> c_int;
        fmi3GetFloat64: fn(Handle, *const c_uint, usize, *mut f64, usize) -> c_int;
        fmi3SetFloat64: fn(Handle, *const c_uint, usize, *const f64, usize) -> c_int;
        fmi3DoStep: fn(Handle, f64, f64, Bool, *mut Bool, *mut Bool, *mut Bool, *mut f64) -> c_int;
    }
    optional {
        fmi3GetFloat32: fn(Handle, *const c_uint, usize, *mut f32, usize);
        fmi3SetFloat32: fn(Handle, *const c_uint, usize, *const f32, usize);
        fmi3GetInt8: fn(Handle, *const c_uint, usize, *mut i8, usize);
        fmi3SetInt8: fn(Handle, *const c_uint, usize, *const i8, usize);
        fmi3GetUInt8: fn(Handle, *const c_uint, usize, *mut u8, usize);
        fmi3SetUInt8: fn(Handle, *const c_uint, usize, *const u8, usize);
        fmi3GetInt16: fn(Handle, *const c_uint, usize, *mut i16, usize);
        fmi3SetInt16: fn(Handle, *const c_uint, usize, *const i16, usize);
        fmi3GetUInt16: fn(Handle, *const c_uint, usize, *mut u16, usize);
        fmi3SetUInt16: fn(Handle, *const c_uint, usize, *const u16, usize);
        fmi3GetInt32: fn(Handle, *const c_uint, usize, *mut i32, usize);
        fmi3SetInt32: fn(Handle, *const c_uint, usize, *const i32, usize);
        fmi3GetUInt32: fn(Handle, *const c_uint, usize, *mut u32, usize);
        fmi3SetUInt32: fn(Handle, *const c_uint, usize, *const u32, usize);
        fmi3GetInt64: fn(Handle, *const c_uint, usize, *mut i64, usize);
        fmi3SetInt64: fn(Handle, *const c_uint, usize, *const i64, usize);
        fmi3GetUInt64: fn(Handle, *const c_uint, usize, *mut u64, usize);
        fmi3SetUInt64: fn(Handle, *const c_uint, usize, *const u64, usize);
        fmi3GetBoolean: fn(Handle, *const c_uint, usize, *mut Bool, usize);
        fmi3SetBoolean: fn(Handle, *const c_uint, usize, *const Bool, usize);
        fmi3GetString: fn(Handle, *const c_uint, usize, *mut *const c_char, usize);
        fmi3SetString: fn(Handle, *const c_uint, usize, *const *const c_char, usize);
        fmi3GetOutputDerivatives: fn(Handle, *const c_uint, usize, *const i32, *mut f64, usize);
        fmi3GetDirectionalDerivative:
            fn(Handle, *const c_uint, usize, *const c_uint, usize, *const f64, usize, *mut f64, usize);
        fmi3GetFMUState: fn(Handle, *mut StateHandle);
        fmi3SetFMUState: fn(Handle, StateHandle);
        fmi3FreeFMUState: fn(Handle, *mut StateHandle);
        fmi3SerializedFMUStateSize: fn(Handle, StateHandle, *mut usize);
        fmi3SerializeFMUState: fn(Handle, StateHandle, *mut u8, usize);
        fmi3DeserializeFMUState: fn(Handle, *const u8, usize, *mut StateHandle);
    }
}
