//! The C interface, `stickslip.h`: models as objects with steps, tangents and saved states.
//!
//! The header is written by cbindgen from this crate and committed beside it (`include/stickslip.h`); `cargo xtask install
//! PREFIX` installs it with both libraries, a pkg-config file and a CMake package. All that is computed here is computed by
//! [`stickslip::fmi::Instance`]; the rest is translation:
//!
//! - `exports`: the functions, each a few lines; `variables`, `running`, `states` by what they are about.
//! - `object`: what a handle points to.
//! - `guard`: what every function does first and last: pointers, locks, panics, the text of an error.

mod exports;
#[cfg(test)]
mod fuzz;
mod guard;
mod object;
#[cfg(test)]
mod tests;

pub use exports::{
    stickslip_copy, stickslip_create, stickslip_error_text, stickslip_free, stickslip_parameter,
    stickslip_restore, stickslip_save, stickslip_set_parameter, stickslip_start, stickslip_state_free,
    stickslip_state_read, stickslip_state_size, stickslip_state_write, stickslip_step, stickslip_tangent,
    stickslip_time, stickslip_variable_count, stickslip_variable_find, stickslip_variable_name,
    stickslip_variable_unit, stickslip_version,
};
pub use guard::Status;
pub use object::{Kind, Object, State};
