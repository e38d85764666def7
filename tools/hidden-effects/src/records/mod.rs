//! Records as an instrument would write them (record.rs), or one that is out of order (spoilt.rs), and all random numbers.

pub mod random;
pub mod record;
pub mod spoilt;
