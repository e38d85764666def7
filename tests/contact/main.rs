//! Contact laws: their closed forms, energy, derivatives and periodic states.

#[path = "../common/mod.rs"]
mod common;

mod backlash;
mod bouc_wen;
mod catalogue;
mod derivatives;
mod energy;
mod iwan;
mod jenkins;
mod joint;
mod measured;
mod memoryless;
mod periodic;
mod sliders;
mod slip_slap;
mod valanis;
mod valanis_load;
