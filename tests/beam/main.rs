//! The modal beam: closed forms, finite elements, contact points.

#[path = "../common/mod.rs"]
mod common;

mod agreement;
mod closed_forms;
mod contact_points;
mod frictional_support;
mod pin_rig;
