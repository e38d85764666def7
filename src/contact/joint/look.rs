//! What a step of the base law tells, without the next state.

/// One step, without the next state.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Look {
    /// N.
    pub force: f64,
    /// N/m.
    pub by_displacement: f64,
    /// By the load (1).
    pub by_load: f64,
    /// J.
    pub dissipated_energy: f64,
    pub path: Path,
    /// Whether anything slid.
    pub slips: bool,
}

/// The distance slipped in a step (m), with its derivatives.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Path {
    pub length: f64,
    pub by_displacement: f64,
    pub by_load: f64,
}
