//! What pages, tables and JSON promise.

#[path = "../../../../tests/common/external.rs"]
mod external;
#[path = "../synthetic/mod.rs"]
mod synthetic;

mod browser;
mod comparison;
mod diagnosis;
mod responses;
