//! What a comparison says, each part once for pages, terminal and JSON: `findings` before any fit, `stages` and what was
//! `fitted`, errors in a `summary` and beside the noise (`floors`), levels of a `ring_down`, and all `samples`.

pub(crate) mod findings;
pub(crate) mod fitted;
pub(crate) mod floors;
pub(crate) mod ring_down;
pub(crate) mod samples;
pub(crate) mod stages;
pub(crate) mod summary;
