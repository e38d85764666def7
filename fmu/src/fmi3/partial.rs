//! Partial derivatives of outputs: along a direction of inputs, and back from weights of outputs.

use super::calls::Function;
use super::failure;
use crate::ffi::{self, Handle, Status, ValueReference};
use crate::guard::{Component, Failure, seldom};
use stickslip::fmi::{Error, Instance};

/// Arrays of C with their lengths.
struct Arguments {
    unknowns: (*const ValueReference, usize),
    knowns: (*const ValueReference, usize),
    seed: (*const f64, usize),
    sensitivity: (*mut f64, usize),
}

/// Instance, rows of unknowns and of knowns, seed, and where the sensitivity goes.
type Derivative = fn(&mut Instance, &[u32], &[u32], &[f64], &mut [f64]) -> Result<(), Error>;

/// # Safety
/// As [`guarded`]; arrays are NULL or valid.
unsafe fn differentiate(handle: Handle, function: Function, arguments: Arguments, by: Derivative) -> Status {
    let body = |component: &mut Component| {
        let Arguments { unknowns, knowns, seed, sensitivity } = arguments;
        // SAFETY: the caller's promise.
        let (unknowns, knowns, seed, sensitivity) = unsafe {
            (
                ffi::slice(unknowns.0, unknowns.1, "unknowns")?,
                ffi::slice(knowns.0, knowns.1, "knowns")?,
                ffi::slice(seed.0, seed.1, "seed")?,
                ffi::slice_mut(sensitivity.0, sensitivity.1, "sensitivity")?,
            )
        };
        let instance = &mut component.instance;
        if instance.is_continuous() {
            return Err(Failure::error("no partial derivatives in model exchange, as the description says"));
        }
        let rows = (instance.rows_of(unknowns).map_err(failure)?, instance.rows_of(knowns).map_err(failure)?);
        by(instance, &rows.0, &rows.1, seed, sensitivity).map_err(failure)
    };
    // SAFETY: the caller's promise.
    unsafe { seldom(handle, function, body) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    handle: Handle,
    unknowns: *const ValueReference,
    unknown_count: usize,
    knowns: *const ValueReference,
    known_count: usize,
    seed: *const f64,
    seed_count: usize,
    sensitivity: *mut f64,
    sensitivity_count: usize,
) -> Status {
    let arguments = Arguments {
        unknowns: (unknowns, unknown_count),
        knowns: (knowns, known_count),
        seed: (seed, seed_count),
        sensitivity: (sensitivity, sensitivity_count),
    };
    let by = Instance::directional_derivative;
    // SAFETY: the importer's promise.
    unsafe { differentiate(handle, Function::GetDirectionalDerivative, arguments, by) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    handle: Handle,
    unknowns: *const ValueReference,
    unknown_count: usize,
    knowns: *const ValueReference,
    known_count: usize,
    seed: *const f64,
    seed_count: usize,
    sensitivity: *mut f64,
    sensitivity_count: usize,
) -> Status {
    let arguments = Arguments {
        unknowns: (unknowns, unknown_count),
        knowns: (knowns, known_count),
        seed: (seed, seed_count),
        sensitivity: (sensitivity, sensitivity_count),
    };
    // SAFETY: the importer's promise.
    unsafe { differentiate(handle, Function::GetAdjointDerivative, arguments, Instance::adjoint_derivative) }
}
