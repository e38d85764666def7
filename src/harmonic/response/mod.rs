//! Responses that users ask for: single ones, curves, resonances, followed over a level or a parameter.
//!
//! [`start`] finds the first solution from nothing. [`sweep`] follows a curve over frequency, level or a parameter
//! and has the [`recorder`] locate peaks and folds, pausing at the [`linear_resonances`].
//! [`tracking`] carries a resonance from value to value by [`stepwise`], located by [`tracker`]. [`resonance`]: phase resonance
//! of a beam at held accelerations. [`dual`]: two harmonics held by two tones.

mod curve;
pub(crate) mod dual;
pub(crate) mod linear_resonances;
mod recorder;
pub(crate) mod resonance;
pub(crate) mod start;
pub(crate) mod stepwise;
pub(crate) mod sweep;
pub(crate) mod tracker;
pub(crate) mod tracking;

pub use curve::{Curve, Fold, Peak};
