//! The physics of the experiments, which shares nothing with the library: the contact as many sliders clamped step by
//! step, the beam as finite elements.

pub mod finite_elements;
pub mod friction;
