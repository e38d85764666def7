//! Records of whole periods of a steady state.
//!
//! Beams are balanced in harmonics (`balance`), or linearised at the measured motion where a fit begins
//! (`linearised`). So are oscillators under one measured force (`oscillator_balance`); those that the balance does not
//! resolve are shot at (`shooting`). Contacts of prescribed motion are solved for their own memory. What a record is in
//! `harmonics` serves every balance.

mod balance;
mod beam;
mod contact;
mod harmonics;
mod linearised;
mod oscillator;
mod oscillator_balance;
mod shooting;
mod spectrum;
#[cfg(test)]
pub(super) mod tests;

pub(super) use beam::SteadyBeam;
pub(super) use contact::SteadyContact;
pub(super) use oscillator::SteadyOscillator;
