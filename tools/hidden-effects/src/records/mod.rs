//! Records as an instrument would write them, and all random numbers.

pub mod random;
pub mod record;
