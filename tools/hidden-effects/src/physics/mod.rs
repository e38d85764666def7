//! The physics of the experiments, which shares nothing with the library: a contact (joint.rs: what it is made of; contact.rs:
//! in motion, step by step; gradual.rs: laws in the place of its sliders; unknown.rs: what no catalogue has) and a beam of
//! finite elements.

pub mod contact;
pub mod finite_elements;
pub mod gradual;
pub mod joint;
pub mod unknown;
