//! The C interface, used from C and C++ as others use it.

#[cfg(target_os = "linux")]
mod drift;
#[cfg(target_os = "linux")]
mod examples;
#[path = "../../../tests/common/external.rs"]
mod external;
mod header;
#[cfg(target_os = "linux")]
mod install;
mod tools;

#[test]
#[cfg(not(target_os = "linux"))]
fn programs_in_c_use_the_interface() {
    external::skip("the compilers and libraries of this system are unknown here");
}
