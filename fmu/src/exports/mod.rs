//! The 44 functions of FMI 2.0.
//!
//! Each translates its arguments and leaves the rest to [`crate::guard::guarded`]. They are unsafe as
//! C functions are: pointers must be NULL or valid for the lengths given.
#![allow(clippy::missing_safety_doc, non_snake_case)]

pub mod lifecycle;
pub mod model_exchange;
pub mod states;
pub mod stepping;
pub mod values;
