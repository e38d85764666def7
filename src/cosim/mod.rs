//! Master algorithms for co-simulation, over anything that is a [`Slave`]: no input or output, no FMI.

mod slave;

pub use slave::{Abilities, Causality, Kind, Setup, Severity, Slave, SlaveError, Stepped, Variable};
