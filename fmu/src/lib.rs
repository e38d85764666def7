//! FMI 2.0 co-simulation: the shared library inside every FMU.
//!
//! The library is generic. At `fmi2Instantiate` it reads `resources/model.toml`, rebuilds the
//! description of the model and compares its GUID with the importer's. All else is translation
//! between the C interface and [`stickslip::fmi::Instance`]:
//!
//! - `calls`: which function is legal in which state, one table.
//! - `guard`: what every function does first and last: handle, call table, panics, messages.
//! - `exports`: the 44 functions.
//!
//! The library holds no model state outside its instances, writes nothing to standard output or
//! error, and never calls the importer's memory functions.

mod calls;
mod exports;
mod ffi;
mod guard;
mod location;
mod log;
#[cfg(test)]
mod tests;
