//! What the test programs share: structures, laws, references, and how a test is skipped.

#![allow(dead_code, reason = "each program uses a part")]

pub mod beam;
pub mod contact;
pub mod cosim;
pub mod cycle;
pub mod exact_period;
pub mod external;
pub mod finite_elements;
pub mod fmi;
pub mod linear_slave;
pub mod oscillator;
pub mod pin_rig;
pub mod time;
