//! What of a mode is held.

/// A mode with the first harmonic of a node held at each of the amplitudes: of its displacement (0) … acceleration (2).
pub(super) struct Held<'a> {
    pub mode: usize,
    pub node: usize,
    pub derivative: usize,
    pub amplitudes: &'a [f64],
}

impl Held<'_> {
    /// The first of the amplitudes as one of the displacement (m) at `angular_frequency` (rad/s).
    pub fn first(&self, angular_frequency: f64) -> f64 {
        self.amplitudes[0] / angular_frequency.powi(self.derivative as i32)
    }
}
