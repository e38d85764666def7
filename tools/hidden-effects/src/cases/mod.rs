//! The sealed cases: case.rs: one, whose name is its seed; sealed.rs: all; files.rs: one as files, made on demand.

pub mod case;
pub mod files;
pub mod sealed;
