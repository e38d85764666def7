//! Jacobi: all slaves step at once, from inputs expected at the beginning of the step.
//!
//! With held inputs a force arrives on average half a step late, which acts as a negative damping `c ≈ −k H/2` of the
//! stiffness k that it belongs to, and another half where the displacement that makes the force is late too.
//!
//! Extrapolation by past values triples a component that changes its sign from step to step. In both directions of a
//! loop the gain is thus multiplied by nine: values oscillate for gains above 1/9. With output derivatives the limit is
//! 1/4, under Gauss–Seidel 1/3, and strong coupling has no limit.

use super::blocks::{Block, Connected, Schedule};
use crate::cosim::system::System;

/// One level with everyone, and nobody waits.
pub(in crate::cosim) fn schedule(system: &System) -> Schedule {
    let components = Connected::new(system).components();
    let everyone: Vec<usize> = components.into_iter().flat_map(|(slaves, _)| slaves).collect();
    let mut schedule = Schedule::empty(system.slaves.len());
    if !everyone.is_empty() {
        schedule.levels.push(everyone);
        schedule.blocks.push(Block { levels: 0..1, iterated: false });
    }
    schedule
}
