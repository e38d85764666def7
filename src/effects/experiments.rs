//! What to measure next: advice common to several effects.

pub(super) const SWAP_SENSORS: &str =
    "calibrate the sensor, or swap it with another: a fault of the measurement stays with the channel";
pub(super) const OTHER_FREQUENCIES: &str = "repeat one level at a frequency ten times lower and higher";
pub(super) const HALF_AND_TWICE: &str = "repeat the test at half of the lowest and twice the highest level";
pub(super) const SECOND_MODE: &str = "excite a second mode and compare the error of each resonance";
pub(super) const TWO_NORMAL_SPEEDS: &str = "move the contact in the normal direction at two speeds";
pub(super) const OTHER_LEVELS: &str = "repeat the test at a lower level, from rest, and at a higher one";
