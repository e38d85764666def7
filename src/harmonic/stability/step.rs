//! Derivatives of one step of a law, as disturbances take them.

use crate::contact::StateTangents;

/// Derivatives of one step of a law.
#[derive(Debug, Default)]
pub(super) struct Step {
    /// The force itself (N).
    pub force: f64,
    pub by_displacement: f64,
    pub by_velocity: f64,
    pub state: StateTangents,
}

impl Step {
    /// Whether force or memory answer to the velocity.
    pub fn follows_velocity(&self) -> bool {
        self.by_velocity != 0.0 || self.state.next_by_velocity.iter().any(|by| *by != 0.0)
    }
}
