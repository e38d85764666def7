//! Responses that users ask for: single ones, curves, resonances, followed over a level or a parameter.
//!
//! [`start`] finds the first solution from nothing. [`frequency_response`] follows a curve over frequency or level and
//! has the [`recorder`] locate peaks and folds, pausing at the [`linear_resonances`]; [`parameter`] follows one over a parameter.
//! [`tracking`] carries a resonance from value to value, found by [`tracker`]. [`resonance`]: phase resonance
//! of a beam at held accelerations.

mod curve;
pub(crate) mod frequency_response;
pub(crate) mod linear_resonances;
pub(crate) mod parameter;
mod recorder;
pub(crate) mod resonance;
pub(crate) mod start;
pub(crate) mod tracker;
pub(crate) mod tracking;

pub use curve::{Curve, Fold, Peak};
