//! Imports co-simulation FMUs of FMI 2.0 and 3.0, ours and others'.
//!
//! [`Fmu::open`] unpacks an archive, reads its description and checks that it can run here. An instance of it is a slave
//! for the master (`stickslip::cosim::Slave`): [`FmuSlave`] in this process, or [`IsolatedSlave`] in one of its own, which
//! a crash does not leave. [`Library`] and [`Slave`] are the bare functions of FMI 2.0, [`Library3`] and [`Slave3`] those of 3.0.
//!
//! The library of an FMU is code of others: in this process it can do anything, and nothing here can prevent that.

mod binding;
mod component;
mod description;
#[cfg(all(target_os = "linux", target_endian = "little"))]
mod elf;
mod exit;
mod fmi3;
mod import;
mod isolate;
mod log;
mod slave;
mod words;

pub use binding::Status;
pub use component::{Error, Library, Slave, State};
pub use description::{
    CoSimulation, Experiment, FmiVersion, ModelDescription, Passed, ScalarVariable, TypeOfVariable,
    Variability,
};
pub use exit::ExitWatch;
pub use fmi3::{Format, Library3, Slave3};
pub use import::{Fmu, ImportError, ImportProblem, platforms};
pub use isolate::{IsolatedSlave, serve};
pub use log::{Log, Message};
pub use slave::FmuSlave;
