//! Points of a branch and what lies ahead of them: data that every step of continuation reads.

use crate::harmonic::newton::system::Operating;

/// A solution and the direction of the curve there, per unit of arc length.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Location {
    /// The unknowns.
    pub x: Vec<f64>,
    /// The scalars.
    pub at: Operating,
    /// Direction: unknowns.
    pub unknowns: Vec<f64>,
    /// Direction: scalars, in the order of [`Scalar`].
    pub scalars: [f64; 4],
    /// Newton steps it took.
    pub iterations: usize,
}

/// How a curve came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The end of the range was reached.
    Complete,
    /// It was interrupted.
    Interrupted,
    /// The steps became too small, or too many: the rest of the range is missing.
    Stuck,
    /// The curve turned and left the range where it had come in: its other end is not reached this way.
    Returned,
}

/// A frequency at which a step must not pass unseen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearResonance {
    /// Ω (rad/s).
    pub angular_frequency: f64,
    /// Half of the bandwidth at half the power, ζ Ω (rad/s).
    pub half_width: f64,
}

impl LinearResonance {
    /// Where the harmonic `order` of the excitation meets it.
    pub(crate) fn over(&self, order: f64) -> Self {
        Self { angular_frequency: self.angular_frequency / order, half_width: self.half_width / order }
    }
}
