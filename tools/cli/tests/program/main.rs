//! The program as a user calls it.

#[path = "../../../../tests/common/external.rs"]
mod external;
#[cfg(target_os = "linux")]
#[path = "../../../fmi-host/tests/support/unruly.rs"]
mod unruly;

mod support;

mod bad_input;
mod demonstrations;
mod diagnosis;
mod frf;
mod friction_damper;
mod hidden_effects;
mod identification;
mod interrupt;
mod manners;
mod modes;
mod new;
mod own_data;
mod pin_rig;
mod rig;
mod simulate;
mod unruly_fmus;
mod user_stories;
