//! Strong coupling: loops one after the other, each to be repeated.

use super::blocks::{Connected, Schedule};
use crate::cosim::system::System;

/// Loops one after the other along the connections; those that can be repeated are.
pub(in crate::cosim) fn schedule(system: &System) -> Schedule {
    let mut connected = Connected::new(system);
    let saves: Vec<bool> = system.slaves.iter().map(|slave| slave.abilities().saves_state).collect();
    // Within loops nobody waits for what feeds a slave that cannot repeat: its inputs are extrapolated.
    let mut of = vec![0; saves.len()];
    for (index, (slaves, _)) in connected.components().iter().enumerate() {
        slaves.iter().for_each(|slave| of[*slave] = index);
    }
    connected.edges.retain(|(from, to, _)| saves[*to] || of[*from] != of[*to]);
    for to in (0..saves.len()).filter(|slave| !saves[*slave]) {
        connected.before[to].retain(|from| of[*from] != of[to]);
        for from in (0..saves.len()).filter(|from| of[*from] == of[to]) {
            connected.after[from].retain(|other| *other != to);
        }
    }
    let mut schedule = Schedule::empty(saves.len());
    for (slaves, cyclic) in connected.components() {
        schedule.push(&slaves, &connected, cyclic);
    }
    schedule
}
