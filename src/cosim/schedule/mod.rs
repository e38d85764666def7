//! Which slaves step when: comes in a [`System`] and the [`Algorithm`], goes out a [`Schedule`].
//!
//! blocks.rs: levels of slaves, and who feeds whom; graph.rs: loops among them and where to open one; one file for each
//! order: jacobi.rs, gauss_seidel.rs, strong.rs.

mod blocks;
mod gauss_seidel;
mod graph;
mod jacobi;
mod strong;

pub(in crate::cosim) use blocks::Schedule;

use super::settings::{Algorithm, Settings};
use super::system::{System, SystemError};

impl Schedule {
    pub(in crate::cosim) fn new(system: &System, settings: &Settings) -> Result<Self, SystemError> {
        match &settings.algorithm {
            Algorithm::Jacobi { .. } => Ok(jacobi::schedule(system)),
            Algorithm::GaussSeidel { order, .. } => gauss_seidel::schedule(system, order.as_deref()),
            Algorithm::Strong(_) => Ok(strong::schedule(system)),
        }
    }
}
