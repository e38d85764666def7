//! The functions of FMI 3.0, for co-simulation and model exchange, beside those of FMI 2.0.
//!
//! In: what an importer of FMI 3.0 calls. Out: the same instances as those of FMI 2.0; only the interface differs.
//!
//! - `calls`: which function is legal in which state. After an error an instance is terminated, as the standard says;
//!   a value that is refused is `fmi3Discard`, and changes nothing.
//! - `lifecycle`, `values`, `states`, `model_exchange`: as in FMI 2.0.
//! - `stepping`: steps, `intermediate`: inputs at times within a step, which make them cubics; `partial`: derivatives.
//! - `absent`: clocks, structural parameters, event mode of co-simulation, other types: none of it, and each says so.
#![allow(clippy::missing_safety_doc, non_snake_case)]

pub mod absent;
pub mod calls;
pub mod intermediate;
pub mod lifecycle;
pub mod model_exchange;
pub mod partial;
pub mod states;
pub mod stepping;
pub mod values;

use crate::ffi::Status;
use crate::guard::Failure;
use stickslip::fmi::Error;

/// A failure in the words of FMI 3.0.
pub fn failure(error: Error) -> Failure {
    match error {
        Error::WrongType { name, is, asked } => {
            let (is, asked) = (type_name(is), type_name(asked));
            Failure::error(format!("{name} is {is}, not {asked}"))
        }
        // The call had no effect, and the importer may try another value.
        Error::Value { .. } | Error::DerivativeValue { .. } => Failure::discard(error.to_string()),
        other => Failure::from(other),
    }
}

/// FMI 3.0's name of a type that FMI 2.0 calls `name`.
fn type_name(name: &'static str) -> &'static str {
    match name {
        "Real" => "Float64",
        "Integer" => "Enumeration",
        other => other,
    }
}

/// Whether a status lets the simulation go on.
pub fn is_success(status: Status) -> bool {
    matches!(status, Status::Ok | Status::Warning)
}
