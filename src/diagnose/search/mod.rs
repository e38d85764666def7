//! The search for effects: a refitted model comes in, the rounds of candidates and the effects kept go out.
//!
//! [`candidates`] lists what can be tried and where; [`select`] tries it, adds forward and drops backward; [`selection_path`]
//! holds the rounds. [`sensitivity`] is what small amounts of each effect would change: from it come [`detectable`] (detection
//! limits) and, with the catalogue's own words, [`confound`] (effects that look alike).

pub(super) mod candidates;
pub(super) mod confound;
pub(super) mod detectable;
pub(super) mod select;
pub(super) mod selection_path;
pub(super) mod sensitivity;
