//! FMI 2.0 and FMI 3.0, co-simulation and model exchange: the shared library inside every FMU.
//!
//! The library is generic. At the first instance of a model it reads `resources/model.toml`, rebuilds the
//! description of the model and compares its GUID with the importer's. All else is translation
//! between the C interface and [`stickslip::fmi::Instance`]:
//!
//! - `models`: the models that were read, each once.
//! - `calls`: which function of FMI 2.0 is legal in which state, one table.
//! - `guard`: what every function does first and last: handle, call table, panics, messages.
//! - `exports`: the 44 functions of FMI 2.0.
//! - `fmi3`: the 75 functions of FMI 3.0, and their table.
//!
//! The library holds no state of a simulation outside its instances, writes nothing to standard output or
//! error, and never calls the importer's memory functions.

mod calls;
mod exports;
mod ffi;
mod fmi3;
mod guard;
mod location;
mod log;
mod models;
#[cfg(test)]
mod tests;
