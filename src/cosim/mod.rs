//! Master algorithms for co-simulation, over anything that is a [`Slave`]: no input or output, no FMI.
//!
//! A [`System`] is slaves with connections. A [`Master`] runs it under [`Settings`] and calls back at each
//! communication point; the result is a [`Report`], with the energy residual of each power connection and with
//! notes on what slaves cannot do.
//!
//! slave/ what can be coupled; system/ what is coupled to what; schedule/ who steps when; step/ one communication step;
//! run/ all of them.
//!
//! # Inputs over a step
//! Plain [`Algorithm::Jacobi`] and [`Algorithm::GaussSeidel`] set an input and let the slave hold it. All
//! else lets inputs run over the step, linearly or, under [`Algorithm::Strong`], as cubics by values and slopes at both
//! ends: for slaves that interpolate by their values at the beginning and derivatives, for others by their [`InputRule`].
//!
//! # Determinism
//! The same system gives the same numbers bit by bit, stepped one by one or at the same time.

mod run;
mod schedule;
mod settings;
mod slave;
mod step;
mod system;

pub use run::{Cause, Failure, Master, Observed, Point, Report, RunError, Unconverged};
pub use settings::{Adaptive, Algorithm, Control, Method, Parallel, Settings, Strong};
pub use slave::{
    Abilities, Causality, Kind, NativeSlave, Setup, Severity, Slave, SlaveError, Source, Stepped, Variable,
};
pub use system::power::EnergyResidual;
pub use system::{Connection, InputRule, Port, PowerConnection, System, SystemError, Unwatched};
