//! Tables of resonance frequency and damping over the amplitude.
//!
//! Of a beam without a place for its amplitude they are those of phase resonance with the acceleration at the exciter held
//! (`beam`); of an oscillator, or at a sensor, those of the nonlinear mode with the acceleration there held (`mode`).

mod beam;
mod mode;

pub(super) use beam::BackboneOfBeam;
pub(super) use mode::BackboneOfMode;
