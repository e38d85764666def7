//! All that decides: each constant is a statement about the world before the data are seen, and none is fitted to cases.

/// Prior standard deviation of the logarithm of a parameter of a contact or of damping: an engineer's guess.
pub(super) const BASE: f64 = 0.3;
/// The same of masses, stiffnesses and moduli of a structure, which drawings tell.
pub(super) const STRUCTURE: f64 = 0.05;
/// Prior standard deviation of an effect's first parameter: the value that moves the prediction by this fraction of
/// its root mean square. What moves it by more was seen before anybody measured.
pub(super) const EFFECT: f64 = 0.3;
/// Prior standard deviation of the logarithm of an effect's other parameters: a factor of e.
pub(super) const SECOND: f64 = 1.0;
/// Prior standard deviation of the logarithm of a noise that is stated, seen in repeats, carried over from other records,
/// and unknown; below what was told it is always the last.
pub(super) const NOISE: [f64; 4] = [0.1, 0.15, 0.5, 2.0];
/// The same of a noise that a discrepancy may stand beside.
pub(super) const RELEASED: f64 = 1.0;
/// Noise of an unknown size is thought to be about this fraction of the channel's root mean square.
pub(super) const UNKNOWN_NOISE: f64 = 0.02;
/// Prior odds of one more effect.
pub(super) const ODDS: f64 = 0.5;
/// Sizes of a discrepancy that are tried, as fractions of the channel.
pub(super) const DISCREPANCY: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];
/// A change of the prediction, as a fraction of a channel's root mean square, below which an effect is not worth its name.
pub(in crate::diagnose) const RELEVANT: f64 = 0.01;
/// Probability from which something is told as certain.
pub(in crate::diagnose) const CERTAIN: f64 = 0.95;
