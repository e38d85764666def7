//! What pages, tables and JSON promise.

#[path = "../../../../tests/common/external.rs"]
mod external;
#[path = "../../../../tests/common/pin_rig.rs"]
#[allow(dead_code, reason = "the tests of the library use more of it")]
mod pin_rig;
#[path = "../synthetic/mod.rs"]
mod synthetic;

mod browser;
mod comparison;
mod diagnosis;
mod responses;
mod slip_slap;
mod transfer;
