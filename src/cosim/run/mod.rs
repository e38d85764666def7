//! A whole run: comes in a system with settings, goes out a report.
//!
//! initialize.rs: values at the start that agree; adaptive.rs: the size of the next step; master.rs: the steps; report.rs:
//! what it came to.

mod adaptive;
mod initialize;
mod master;
mod report;

pub use master::Master;
pub use report::{Cause, Failure, Observed, Point, Report, RunError, Unconverged};
