//! The C interface, used from C and C++ as others use it.

mod drift;
mod examples;
#[path = "../../../tests/common/external.rs"]
mod external;
mod header;
mod install;
mod tools;
