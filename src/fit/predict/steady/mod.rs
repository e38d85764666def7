//! Records of whole periods of a steady state.
//!
//! Beams are balanced in harmonics (`balance`), or linearised at the measured motion where a fit begins
//! (`linearised`); oscillators are shot at (`shooting`) and contacts of prescribed motion solved for their own memory,
//! until the balance of a [`System`](crate::system::System) serves them too.

mod balance;
mod beam;
mod contact;
mod linearised;
mod oscillator;
mod shooting;
mod spectrum;
#[cfg(test)]
mod tests;

pub(super) use beam::SteadyBeam;
pub(super) use contact::SteadyContact;
pub(super) use oscillator::SteadyOscillator;
