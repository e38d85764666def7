//! Tables of resonance frequency and damping over the amplitude.
//!
//! Of a beam they are those of phase resonance with the acceleration at the exciter held (`beam`); of an oscillator those
//! of the nonlinear mode, with the acceleration of a mass held (`oscillator`).

mod beam;
mod oscillator;

pub(super) use beam::BackboneOfBeam;
pub(super) use oscillator::BackboneOfOscillator;
