//! One communication step: comes in a system with its schedule, go out the values at the end and the energy that the
//! coupling fed in.
//!
//! unit.rs: a slave with its inputs over the step; advance.rs: a step of it; course.rs: how an input
//! runs over the step; signals.rs: what passes between them; level.rs: slaves that step at the
//! same time; solve.rs: equations for what a loop assumes; iteration.rs: a loop as such equations; energy.rs: both sides
//! of each power connection; mismatch.rs: couplings without one; engine.rs: all of it, level by level; notes.rs: what slaves
//! cannot do, in plain words.

mod advance;
mod course;
pub(super) mod energy;
pub(super) mod engine;
pub(super) mod iteration;
pub(super) mod level;
mod mismatch;
pub(super) mod notes;
pub(super) mod signals;
pub(super) mod solve;
pub(super) mod unit;
