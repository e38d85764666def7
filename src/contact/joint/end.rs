//! The end of a step.

/// Where a step ends behind the play.
#[derive(Clone, Copy)]
pub(super) struct End {
    /// w (m).
    pub displacement: f64,
    /// m N (N).
    pub load: f64,
    /// s (m).
    pub slip: f64,
    /// Which end of the play carries force; zero without play as well.
    pub side: f64,
    /// Whether w follows u.
    pub follows: bool,
    /// Whether w rests where it was.
    pub rests: bool,
    /// Factor of the limit by the velocity, and its derivative (s/m).
    pub speed: (f64, f64),
}
