//! The sealed cases: case.rs: one, whose name is its seed; sealed.rs: all, later.rs: those that came later, three.rs: those for
//! a diagnosis that may add three effects; files.rs: one as files, made on demand.

pub mod case;
pub mod files;
mod later;
pub mod sealed;
pub mod three;
