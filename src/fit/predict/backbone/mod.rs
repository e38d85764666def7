//! Tables of resonance frequency and damping over the amplitude.
//!
//! Of a beam without a place for its amplitude they are those of phase resonance with the acceleration at the exciter held
//! (`beam`); of an oscillator, or at a sensor, those of the nonlinear mode with the acceleration there held (`mode`); of a free decay
//! that was cut into windows, those of the model's own decay in such windows (`decay`).

mod beam;
mod decay;
mod mode;

pub(super) use beam::BackboneOfBeam;
pub(super) use decay::BackboneOfDecay;
pub(crate) use decay::scatter_of_starts;
pub(super) use mode::BackboneOfMode;
