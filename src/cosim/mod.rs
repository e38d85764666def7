//! Master algorithms for co-simulation, over anything that is a [`Slave`]: no input or output, no FMI.
//!
//! A [`System`] is slaves with connections. A [`Master`] runs it under [`Settings`] and calls back at each
//! communication point; the result is a [`Report`], with the energy residual of each power connection and with
//! notes on what slaves cannot do.
//!
//! # Inputs over a step
//! Plain [`Algorithm::Jacobi`] and [`Algorithm::GaussSeidel`] set an input and let the slave hold it. All
//! else lets inputs run linearly over the step: for slaves that interpolate by their values at the beginning and
//! derivatives, for others by their [`InputRule`].
//!
//! # Determinism
//! The same system gives the same numbers bit by bit, stepped one by one or at the same time.

mod adaptive;
mod energy;
mod engine;
mod gauss_seidel;
mod graph;
mod initialize;
mod jacobi;
mod krylov;
mod level;
mod master;
mod native;
mod notes;
mod power;
mod report;
mod schedule;
mod settings;
mod signals;
mod slave;
mod solve;
mod source;
mod strong;
mod system;
mod unit;

pub use master::Master;
pub use native::NativeSlave;
pub use power::{EnergyResidual, PowerConnection};
pub use report::{Cause, Failure, Observed, Point, Report, RunError, Unconverged};
pub use settings::{Adaptive, Algorithm, Control, Method, Parallel, Settings, Strong};
pub use slave::{Abilities, Causality, Kind, Setup, Severity, Slave, SlaveError, Stepped, Variable};
pub use source::Source;
pub use system::{Connection, InputRule, Port, System, SystemError};
