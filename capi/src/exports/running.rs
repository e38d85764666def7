//! A model from its text to its end.

use crate::guard::{Failure, Status, array, array_mut, guarded, object, place};
use crate::object::{Kind, Object};
use std::ffi::{CStr, c_char};

/// Makes a model of `model_toml`, the text of a model file (UTF-8, ends with 0), and writes it to `*model`.
/// It has to be started next.
///
/// # Safety
/// `model_toml` is NULL or a text, `model` NULL or a place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_create(model_toml: *const c_char, model: *mut *mut Object) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { place(model, "model")? };
        if model_toml.is_null() {
            return Err(Failure::refused("model_toml is NULL"));
        }
        // SAFETY: the caller's promise.
        let text = unsafe { CStr::from_ptr(model_toml) }.to_str();
        let text = text.map_err(|error| Failure::refused(format!("model_toml is not UTF-8: {error}")))?;
        *model = Box::into_raw(Box::new(Object::new(text)?));
        Ok(())
    })
}

/// Makes a second model that goes on as the first one would, and writes it to `*copy`. The two have nothing
/// in common afterwards.
///
/// # Safety
/// `model` is NULL or a model, `copy` NULL or a place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_copy(model: *const Object, copy: *mut *mut Object) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (model, copy) = unsafe { (object(model, "model")?, place(copy, "copy")?) };
        *copy = Box::into_raw(Box::new(model.copy()?));
        Ok(())
    })
}

/// Frees a model; NULL is ignored. Names and units of its variables end with the last copy that shares
/// them.
///
/// # Safety
/// `model` is NULL or a model that no thread uses now or later.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_free(model: *mut Object) {
    if !model.is_null() {
        // SAFETY: made by `Box::into_raw`; the caller's promise.
        let _ = guarded(|| {
            drop(unsafe { Box::from_raw(model) });
            Ok(())
        });
    }
}

/// Begins, or begins anew, at time 0 with the parameters as they were set: builds the model and writes the
/// outputs at the start. A contact comes unstressed from displacement 0. `inputs` has a number for each
/// input; NULL leaves them at the values the model file gives. `outputs` has room for each output, or is
/// NULL. `tolerance` is the relative tolerance of the integration inside; 0 is 1e-6.
///
/// # Safety
/// `model` is NULL or a model; the arrays are NULL or as long as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_start(
    model: *mut Object,
    inputs: *const f64,
    tolerance: f64,
    outputs: *mut f64,
) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { object(model, "model")? };
        // SAFETY: the caller's promise.
        let inputs = unsafe { array(inputs, model.names.of(Kind::Input).len()) };
        // SAFETY: the caller's promise.
        let outputs = unsafe { array_mut(outputs, model.names.of(Kind::Output).len()) };
        let mut running = model.lock()?;
        running.start(inputs, tolerance)?;
        outputs.map_or(Ok(()), |outputs| running.outputs(outputs))
    })
}

/// One step of `step` seconds, above 0. `inputs` has a number for each input, NULL leaves them as they are;
/// of a contact, an oscillator and a pin rig they are those reached at the end of the step, on a straight
/// line, of a beam they are held. `outputs`, with room for each output, receives those at the end; it may
/// be NULL. Where the step fails or is refused the model is as before it.
///
/// # Safety
/// `model` is NULL or a model; the arrays are NULL or as long as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_step(
    model: *mut Object,
    inputs: *const f64,
    step: f64,
    outputs: *mut f64,
) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { object(model, "model")? };
        // SAFETY: the caller's promise.
        let inputs = unsafe { array(inputs, model.names.of(Kind::Input).len()) };
        // SAFETY: the caller's promise.
        let outputs = unsafe { array_mut(outputs, model.names.of(Kind::Output).len()) };
        let mut running = model.lock()?;
        running.step(inputs, step)?;
        outputs.map_or(Ok(()), |outputs| running.outputs(outputs))
    })
}

/// Writes the derivatives of the outputs at the end of the last step by the inputs given to that step (of a
/// pin rig from differences, elsewhere exact): `tangent[i * inputs + j]` is that of output `i` by input
/// `j`, in SI units. A whole number (`slip_state`) has 0. Before the first step they are those of the
/// outputs at the start.
///
/// # Safety
/// `model` is NULL or a model; `tangent` is NULL or has room for outputs times inputs numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_tangent(model: *mut Object, tangent: *mut f64) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { object(model, "model")? };
        let length = model.names.of(Kind::Input).len() * model.names.of(Kind::Output).len();
        // SAFETY: the caller's promise.
        let tangent = unsafe { array_mut(tangent, length) };
        let tangent = tangent.ok_or_else(|| Failure::refused("tangent is NULL"))?;
        model.lock()?.tangent(tangent)
    })
}

/// Writes the end of the last step, in seconds since the start, to `*time`.
///
/// # Safety
/// `model` is NULL or a model, `time` NULL or a place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stickslip_time(model: *const Object, time: *mut f64) -> Status {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (model, time) = unsafe { (object(model, "model")?, place(time, "time")?) };
        *time = model.lock()?.time();
        Ok(())
    })
}
