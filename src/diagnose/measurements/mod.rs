//! The measurements as a search sees them: a dataset comes in, records with weights go out.
//!
//! [`weighted_dataset`] lays out every compared channel with its weights; [`noise`] tells what is known of the noise, from
//! [`cycles`] that repeat among others and how well ([`seen`]) (a steady [`tone`] is none), [`inputs`] what noise of the inputs adds to it, and [`colour`] how large that one is and how long it remembers. [`split`] deals the records out to training,
//! validation and test. [`thinned`] and [`beginnings`] make shorter records for the many fits of a search, [`magnitudes`] the
//! scales that bound the parameters of effects.

pub(super) mod beginnings;
pub(super) mod colour;
pub(super) mod cycles;
pub(super) mod inputs;
pub(super) mod magnitudes;
pub(super) mod noise;
mod seen;
pub(super) mod split;
pub(super) mod thinned;
pub(super) mod tone;
pub(super) mod weighted_dataset;
