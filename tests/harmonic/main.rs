//! Harmonic balance: responses, curves, modes, stability.

#[path = "../common/mod.rs"]
mod common;

mod beam;
mod corners;
mod curves;
mod cycle;
mod cycle_laws;
mod dual_mode;
mod held_response;
mod interrupt;
mod joint;
mod laws;
mod modes;
mod pin_rig;
mod sharp_curves;
mod stability;
mod starts;
mod steady_records;
mod tracking;
mod two_mass;
